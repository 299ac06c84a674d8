"""The square of an image around an instance, turned to the long axis of its mask, and the camera that would see it.

A crop is an image of its own: that of a camera which is turned about the optical axis and has another focal length and
principal point. Everything that is known of cameras then holds for crops: projection, PnP, rendering of labels.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.rounding import rounded
from maskval import Camera, Pose

PIXEL_CENTER = 0.5  # where pixel i is sampled, in images and crops
ZOOM = 1.35  # side of a crop, in lengths of the ellipse that has the mask's moments
_SMALLEST_SIDE_PX = 16.0
_MOST_SAMPLES = 6  # per crop pixel and side, where a crop is smaller than what it shows

Array = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(frozen=True)
class Square:
    """A square of an image.

    Attributes:
        center_px: u and v of its middle, i + 0.5 for the middle of pixel i.
        angle: from the image's u axis to the square's, rad.
        side_px: length of a side.
    """

    center_px: tuple[float, float]
    angle: float
    side_px: float

    @classmethod
    def around(cls, mask: NDArray[np.bool_]) -> "Square":
        """The square around a mask, its u axis along the mask's longest direction; a small one where it is empty.

        Args:
            mask: (H, W).
        """
        v, u = np.nonzero(mask)
        if len(u) == 0:
            return cls((mask.shape[1] / 2.0, mask.shape[0] / 2.0), 0.0, _SMALLEST_SIDE_PX)
        center = rounded(np.array((u.mean(), v.mean())))
        du, dv = u - center[0], v - center[1]
        uu, vv, uv = (rounded(np.mean(product)) for product in (du * du, dv * dv, du * dv))
        angle = 0.5 * math.atan2(2.0 * uv, uu - vv)
        longest = (uu + vv) / 2.0 + math.hypot((uu - vv) / 2.0, uv)  # variance along it
        side = max(4.0 * math.sqrt(longest) * ZOOM, _SMALLEST_SIDE_PX)
        return cls((float(center[0]) + PIXEL_CENTER, float(center[1]) + PIXEL_CENTER), angle, float(rounded(side)))

    def moved(self, du: float, dv: float, turn: float, scale: float) -> "Square":
        """Another square: moved by shares of a side along the image's axes, turned (rad) and scaled."""
        u, v = self.center_px
        side = self.side_px
        return Square((u + du * side, v + dv * side), self.angle + turn, side * scale)

    def affine(self, size: int) -> Array:
        """From image coordinates to those of a crop of `size` pixels, (2, 3)."""
        scale = size / self.side_px
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        turn = scale * np.array(((cosine, sine), (-sine, cosine)))
        return np.column_stack((turn, size / 2.0 - turn @ self.center_px))

    def inverse_affine(self, size: int) -> Array:
        """From coordinates of a crop of `size` pixels to those of the image, (2, 3)."""
        affine = self.affine(size)
        back = np.linalg.inv(affine[:, :2])
        return np.column_stack((back, -back @ affine[:, 2]))


@dataclass(frozen=True)
class CropView:
    """The camera that sees a crop.

    Attributes:
        square: what it shows.
        image_camera: the camera of the whole image.
        size: of the crop, px.
    """

    square: Square
    image_camera: Camera
    size: int

    @cached_property
    def camera(self) -> Camera:
        """Its intrinsics; V is its frame."""
        return self._parts[0]

    @cached_property
    def X_VC(self) -> Pose:
        """Pose of the image's camera in the crop's: a turn about the optical axis."""
        return self._parts[1]

    @cached_property
    def _parts(self) -> tuple[Camera, Pose]:
        affine, K = self.square.affine(self.size), self.image_camera.K
        M = affine[:, :2] @ K[:2, :2]
        cx, cy = affine[:, :2] @ K[:2, 2] + affine[:, 2]
        # M = upper triangular × rotation.
        fy = math.hypot(*M[1])
        across, along = M[1] / fy
        R = np.array(((along, -across, 0.0), (across, along, 0.0), (0.0, 0.0, 1.0)))
        fx, skew = M[0] @ R[0, :2], M[0] @ R[1, :2]
        camera = Camera(float(fx), fy, float(cx), float(cy), self.size, self.size, float(skew))
        return camera, Pose(R, np.zeros(3))

    def points(self, depth: NDArray[np.float32]) -> Array:
        """The point that each pixel of a depth image of the crop shows, (size, size, 3) in V, metres."""
        camera, z = self.camera, depth.astype(np.float64)
        grid = np.arange(self.size) + PIXEL_CENTER
        y = (grid[:, None] - camera.cy) * z / camera.fy
        x = ((grid[None, :] - camera.cx) * z - camera.skew * y) / camera.fx
        return np.stack((x, y, z), axis=-1)


def cut(image: Image, square: Square, size: int) -> Image:
    """The crop, (size, size, 3): each pixel the mean of what it shows, black beyond the image.

    Args:
        image: (H, W, 3) or (H, W), uint8.
        square: where.
        size: px.
    """
    samples = min(max(math.ceil(square.side_px / size), 1), _MOST_SAMPLES)
    affine = square.affine(size * samples)
    # OpenCV's coordinates are those of pixel middles: 0 for the first.
    affine[:, 2] += affine[:, :2] @ (PIXEL_CENTER, PIXEL_CENTER) - PIXEL_CENTER
    fine = cv2.warpAffine(image, affine, (size * samples, size * samples), flags=cv2.INTER_LINEAR)
    if samples == 1:
        return np.asarray(fine, dtype=np.uint8)
    return np.asarray(cv2.resize(fine, (size, size), interpolation=cv2.INTER_AREA), dtype=np.uint8)
