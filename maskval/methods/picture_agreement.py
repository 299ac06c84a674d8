"""How uncertain a pose is, judged by the picture that the object would give in it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs
from maskval.geometry import Pose
from maskval.mesh import Mesh
from maskval.rendering.depth import depth_crop

_FEWEST = 20  # pixels with a normal: fewer fit any light
_GREY = np.array((0.299, 0.587, 0.114))  # of R, G and B in luminance, ITU-R BT.601

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class RenderNcc:
    """How little the picture correlates with the object's shading under the pose: u = 1 - R.

    R is the normalised cross-correlation of the picture's grey levels with those of the rendered object, over the
    pixels that the object covers, lit as fits best. The grey level of a matt surface is a + b · n with its normal n,
    whatever the distant lights; so R is the coefficient of multiple correlation of grey level and normal. What is in
    front of the object, shadows and texture lower it. Where the object covers nothing of the image, u = 1.
    """

    needs: ClassVar[Needs] = Needs(rgb=True)

    def __call__(self, estimates: Estimates) -> Array:
        """1 - R of each pose, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If there is no picture.
        """
        if estimates.rgb is None:
            raise InvalidEstimatesError("render-ncc needs the picture, but the estimates hold none")
        grey = estimates.rgb @ _GREY
        mesh, camera, pixel_center = estimates.mesh, estimates.camera, estimates.pixel_center
        return np.array([1.0 - shading_correlation(grey, mesh, X, camera, pixel_center) for X in estimates.poses[0]])


def shading_correlation(grey: Array, mesh: Mesh, X_CO: Pose, camera: Camera, pixel_center: float) -> float:
    """R of one pose, in [0, 1]; see `RenderNcc`.

    Args:
        grey: The picture's grey levels, (H, W).
        mesh: The object.
        X_CO: Its pose.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled.
    """
    crop = depth_crop(mesh, X_CO, camera, pixel_center=pixel_center)
    height, width = crop.depth.shape
    if height < 3 or width < 3:
        return 0.0
    v, u = np.indices(crop.depth.shape) + pixel_center
    normals, known = _normals(crop.depth.astype(np.float64), u + crop.left, v + crop.top, camera)
    seen = grey[crop.top : crop.top + height, crop.left : crop.left + width][known]
    if len(seen) < _FEWEST:
        return 0.0
    total = float(np.sum((seen - seen.mean()) ** 2))
    if total <= 1e-12 * len(seen):
        return 0.0
    terms = np.column_stack((np.ones(len(seen)), normals[known]))
    fitted = terms @ np.linalg.lstsq(terms, seen, rcond=None)[0]
    explained = 1.0 - float(np.sum((seen - fitted) ** 2)) / total
    return float(np.sqrt(np.clip(explained, 0.0, 1.0)))


def _normals(depth: Array, u: Array, v: Array, camera: Camera) -> tuple[Array, NDArray[np.bool_]]:
    """Unit normals of a depth image, (h, w, 3), and where they are known: inside the surface, off its border."""
    y = (v - camera.cy) * depth / camera.fy
    x = ((u - camera.cx) * depth - camera.skew * y) / camera.fx
    points = np.stack((x, y, depth), axis=-1)
    along_v, along_u = np.gradient(points, axis=(0, 1))
    normals = np.cross(along_u, along_v)
    lengths = np.linalg.norm(normals, axis=-1)
    covered = depth > 0
    known = covered.copy()
    for axis in (0, 1):
        for step in (-1, 1):
            known &= np.roll(covered, step, axis=axis)
    known[[0, -1]] = known[:, [0, -1]] = False  # there `roll` takes the opposite border for a neighbour
    known &= lengths > 0
    return normals / np.where(lengths > 0, lengths, 1.0)[..., None], known
