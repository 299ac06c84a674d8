"""Object coordinates: which point of the part each pixel of a crop shows, and the pose that follows from them."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import PoseEstimate
from cell.rounding import rounded
from maskval import Camera, Correspondences, Mesh, Pose
from maskval.symmetry import right_angle_symmetries
from sim.learned.crops import PIXEL_CENTER, CropView
from sim.learned.pnp import DepthEstimate, solve

CROP_SIZE, MAP_SIZE = 64, 32  # of what the pose networks are given, and of their maps, px
_LEAST_SIGMA_PX = 0.25  # of the crop: no correspondence is surer
# What a network may say of its own errors.
_LOG_SCALES = (-5.0, 1.0)  # of coordinates, in half sizes of the part
_PREFERENCE = np.array((1.0, 0.3, 0.1))  # for O's x, y and z axis to point to the right of the crop
_LOG_SIGMAS = (-6.0, 1.0)  # of the logarithm of depth

Array = NDArray[np.float64]
Output = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Maps:
    """What a pose network says of a crop.

    Attributes:
        coordinates: the part's point at each pixel, (3, h, w) in half sizes of its box from the box's middle.
        log_scale: logarithm of the error to expect of them (mean absolute error of a coordinate), (h, w).
        visible: logit of each pixel to show the part, (h, w).
        head: of the middle of the part's box: where it lies in the crop from the crop's middle, u and v in half
            crops, the logarithm of its depth (see `ObjectCoordinates.depth_unit`), and the logarithm of that one's
            standard deviation.
    """

    coordinates: Output
    log_scale: Output
    visible: Output
    head: Output


@dataclass(frozen=True, slots=True, eq=False)
class ObjectCoordinates:
    """The frame in which a network sees a part's points: the box of its mesh, from −1 to 1.

    Attributes:
        center_O: the box's middle, (3,) m.
        half_size: half of its size, (3,) m.
        diameter: the part's, m.
        alike: the poses X_OO in which it looks alike, the identity first.
    """

    center_O: Array
    half_size: Array
    diameter: float
    alike: tuple[Pose, ...]

    @classmethod
    def of(cls, mesh: Mesh, symmetries: tuple[Pose, ...] = ()) -> Self:
        """That of a part.

        Args:
            mesh: its surface.
            symmetries: the poses in which it looks alike; without any, turns by right angles are looked for.
        """
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        alike = symmetries or (Pose.identity(), *right_angle_symmetries(mesh))
        return cls((low + high) / 2.0, (high - low) / 2.0, mesh.diameter, alike)

    def normalised(self, points_O: Array) -> Array:
        """Points in half sizes from the middle, (..., 3)."""
        normalised: Array = (points_O - self.center_O) / self.half_size
        return normalised

    def points_O(self, normalised: Array) -> Array:
        """Points in O, (..., 3) m."""
        points: Array = self.center_O + self.half_size * normalised
        return points

    def turned_alike(self, R_VO: Array) -> Pose:
        """Which of the poses in which the part looks alike its networks all give: a rule, since pictures do not tell.

        O's x axis, then its y axis, points to the right of the crop, whose u axis runs along the mask. So no small
        error changes the choice for a long part.
        """
        sides = [_PREFERENCE @ (R_VO @ pose.rotation)[0] for pose in self.alike]
        return self.alike[int(np.argmax(rounded(np.array(sides))))]

    def depth_unit(self, camera: Camera) -> float:
        """The depth, m, at which the part's diameter is as long as a side of the crop that a camera sees."""
        return math.sqrt(camera.fx * camera.fy) * self.diameter / camera.width


def estimate_of(maps: Maps, view: CropView, coordinates: ObjectCoordinates, weight: float) -> PoseEstimate:
    """X_CO_est of the part that a crop shows, with the correspondences, which are those of the image.

    Args:
        maps: what a network says of the crop.
        view: the crop.
        coordinates: the part's.
        weight: of one correspondence against the depth of the head, see `sim.learned.pnp.solve`.
    """
    camera = view.camera
    found = correspondences(maps, camera, coordinates)
    log_depth = float(maps.head[2]) + math.log(coordinates.depth_unit(camera))
    sigma = math.exp(np.clip(float(maps.head[3]), *_LOG_SIGMAS))
    depth = DepthEstimate(coordinates.center_O, log_depth, sigma)
    X_VO = solve(found, camera, depth, weight)
    if X_VO is None:
        X_VO = _pose_of_head(maps.head, log_depth, camera, coordinates)
    turn = coordinates.turned_alike(X_VO.rotation)
    X_CO = view.X_VC.inverse() @ X_VO @ turn
    to_image = view.square.inverse_affine(view.size)
    pixels = found.pixels @ to_image[:, :2].T + to_image[:, 2]
    sigmas = found.sigma_px * view.square.side_px / view.size
    return PoseEstimate(X_CO, Correspondences(turn.inverse().apply(found.points_O), pixels, sigmas))


def correspondences(maps: Maps, camera: Camera, coordinates: ObjectCoordinates) -> Correspondences:
    """The points of all pixels that are likelier to show the part than not, in the crop."""
    v, u = np.nonzero(maps.visible > 0.0)
    stride = camera.width / maps.visible.shape[0]
    pixels = stride * (np.stack((u, v), axis=1) + PIXEL_CENTER)
    points_O = coordinates.points_O(maps.coordinates[:, v, u].T.astype(np.float64))
    scale = np.exp(np.clip(maps.log_scale[v, u].astype(np.float64), *_LOG_SCALES))
    # A point at the depth unit: its error in half sizes of the box becomes one in pixels.
    px_per_m = camera.width / coordinates.diameter
    sigma_px = np.maximum(scale * float(coordinates.half_size.mean()) * px_per_m, _LEAST_SIGMA_PX)
    return Correspondences(points_O, pixels, sigma_px)


def _pose_of_head(head: Output, log_depth: float, camera: Camera, coordinates: ObjectCoordinates) -> Pose:
    """A pose of the right place and no particular rotation, for a crop that shows hardly anything of the part."""
    u, v = (1.0 + head[:2].astype(np.float64)) * camera.width / 2.0
    z = math.exp(log_depth)
    y = (v - camera.cy) / camera.fy * z
    x = ((u - camera.cx) * z - camera.skew * y) / camera.fx
    return Pose.from_translation(np.array((x, y, z)) - coordinates.center_O)
