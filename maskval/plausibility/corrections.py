"""What may have gone wrong with all poses or masks alike, and how to undo it, so that a guess can be tried."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from maskval.camera import Camera
from maskval.geometry import Pose
from maskval.masks import PackedMasks
from maskval.mesh import Mesh

_TO_OPENCV = Pose(np.diag((1.0, -1.0, -1.0)), np.zeros(3))  # from OpenGL's camera axes: y up, z backwards


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """The poses of an object in an image.

    Args:
        mesh: The object.
        poses: N poses X_CO.
        masks: The masks of the object in the image.
        camera: Intrinsics and image size.
        X_CW: Pose of the world in the camera, where it is known.
    """

    mesh: Mesh
    poses: tuple[Pose, ...]
    masks: PackedMasks
    camera: Camera
    X_CW: Pose | None = None


class Correction(NamedTuple):
    """A mistake, and the view without it.

    Args:
        cause: The mistake, in words.
        undo: The view that was meant, of the one given; None where it cannot be told.
    """

    cause: str
    undo: Callable[[View], View | None]


def _of_poses(undo: Callable[[Pose], Pose]) -> Callable[[View], View]:
    return lambda view: replace(view, poses=tuple(undo(X) for X in view.poses))


def _scaled(factor: float) -> Callable[[View], View]:
    return _of_poses(lambda X: Pose(X.rotation, factor * X.translation))


def _reordered(*order: int) -> Callable[[View], View]:
    """Poses whose quaternions have these components of the given ones, which are w x y z."""
    return _of_poses(lambda X: Pose.from_quaternion_wxyz(X.quaternion_wxyz[list(order)], X.translation))


def _out_of_the_world(view: View) -> View | None:
    X_CW = view.X_CW
    return None if X_CW is None else replace(view, poses=tuple(X_CW @ X_WO for X_WO in view.poses))


def _transposed(view: View) -> View:
    """The view whose masks and image are as high as they were wide."""
    masks = PackedMasks.pack(view.masks.unpack().transpose(0, 2, 1))
    return replace(view, masks=masks, camera=Camera.from_K(view.camera.K, masks.width, masks.height))


def _column_by_column(view: View) -> View:
    """The view whose masks were read column by column, but written row by row."""
    pixels = view.masks.unpack()
    return replace(view, masks=PackedMasks.pack(pixels.transpose(0, 2, 1).reshape(pixels.shape)))


CORRECTIONS = (
    Correction("translations are 1,000 times too short: metres where millimetres are expected?", _scaled(1000.0)),
    Correction(
        "translations are 1,000 times too long for the model: millimetres where metres are expected, or a model in "
        "metres where millimetres are?",
        _scaled(0.001),
    ),
    Correction(
        "poses are in the world frame, not the camera's: expected X_CO = X_CW X_WO, with cam_R_w2c and cam_t_w2c",
        _out_of_the_world,
    ),
    Correction("poses are those of the camera in the object: expected their inverses", _of_poses(Pose.inverse)),
    Correction(
        "poses are in OpenGL's camera axes, y up and z backwards: expected OpenCV's, y down and z forward",
        _of_poses(lambda X: _TO_OPENCV @ X),
    ),
    Correction(
        "rotations are transposed: expected R from the object to the camera, row by row",
        _of_poses(lambda X: Pose(X.rotation.T, X.translation)),
    ),
    Correction("quaternions x y z w were taken for w x y z", _reordered(3, 0, 1, 2)),
    Correction("quaternions w x y z were taken for x y z w", _reordered(1, 2, 3, 0)),
    Correction("masks are transposed: expected sizes as height, width", _transposed),
    Correction("run lengths go row by row: expected COCO's, column by column", _column_by_column),
)
