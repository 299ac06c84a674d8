"""MaskVal: how uncertain a pose is, judged by the overlap of its silhouette with the mask it should project to."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.association import UNMATCHED, Rule, associate
from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError, InvalidMaskError
from maskval.estimates import Estimates
from maskval.geometry import PosesLike, as_poses
from maskval.inputs.arrays import check_number, floats
from maskval.masks import PackedMasks
from maskval.mesh import Mesh
from maskval.rendering.silhouettes import silhouette_iou
from maskval.rendering.views import Canvas

# The paper's sensitivity towards the visibility.
ALPHA = 0.8


@dataclass(frozen=True, slots=True)
class MaskVal:
    """The paper's method: compare each pose's silhouette with the mask that it was made from.

    Args:
        alpha: Visibility below which the certainty is lowered by the visibility, in [0, 1]; 0 leaves it out.
    """

    alpha: float = ALPHA

    def __post_init__(self) -> None:
        _check_alpha(self.alpha)

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The paper's u of each pose, (N,), in [0, 1]."""
        iou, visibility = silhouette_iou(
            estimates.mesh,
            estimates.poses[0],
            estimates.masks,
            estimates.camera,
            paired=True,
            pixel_center=estimates.pixel_center,
        )
        return maskval_uncertainty(iou, visibility, self.alpha)


@dataclass(frozen=True, slots=True, eq=False)
class Uncertainties:
    """What MaskVal says of N poses.

    Args:
        masks: Index of the mask that each pose was matched to, (N,), or `UNMATCHED`.
        c: Certainty, the intersection over union with that mask, (N,), in [0, 1]; 0 without one.
        v: Visibility, the share of the silhouette inside the image, (N,), in [0, 1].
        u: Uncertainty, (N,), in [0, 1]; low is good.
    """

    masks: NDArray[np.int64]
    c: NDArray[np.float64]
    v: NDArray[np.float64]
    u: NDArray[np.float64]

    def __post_init__(self) -> None:
        for array in (self.masks, self.c, self.v, self.u):
            array.setflags(write=False)


def uncertainty(
    mesh: Mesh,
    poses: PosesLike,
    masks: NDArray[Any] | PackedMasks,
    camera: Camera,
    *,
    association: Literal["known"] | Rule = "known",
    alpha: float = ALPHA,
    pixel_center: float = 0.0,
    canvas: Canvas = "full",
) -> Uncertainties:
    """The paper's uncertainty of each of N poses of one object, given K masks.

    Args:
        mesh: The object.
        poses: N poses X_CO, or their homogeneous matrices, (N, 4, 4).
        masks: K masks, (K, H, W), bool or uint8 of 0 and 1, or packed.
        camera: Intrinsics and image size.
        association: "known" when pose i comes from mask i (two-stage estimators), else the matching J: "greedy",
            the paper's example, or "optimal" (Hungarian).
        alpha: Visibility below which the certainty is lowered by the visibility, in [0, 1].
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL and BOP.
        canvas: Where the whole silhouette is counted for the visibility: "full", or "3x3" images, as BOP does.

    Raises:
        InvalidMaskError: If the masks are not binary, of another size than the image, or not as many as the poses
            although their association is known.
    """
    poses = as_poses(poses)
    packed = masks if isinstance(masks, PackedMasks) else PackedMasks.pack(masks)
    known = association == "known"
    if known and len(packed) != len(poses):
        raise InvalidMaskError(
            f"{len(poses)} poses and {len(packed)} masks have no known association: pass association='greedy'"
        )
    iou, v = silhouette_iou(mesh, poses, packed, camera, paired=known, pixel_center=pixel_center, canvas=canvas)
    if association == "known":
        matched, c = np.arange(len(poses)), iou
    else:
        matched = associate(iou, association)
        c = np.zeros(len(poses))
        found = np.flatnonzero(matched != UNMATCHED)
        c[found] = iou[found, matched[found]]
    return Uncertainties(matched, c, v, maskval_uncertainty(c, v, alpha))


def maskval_uncertainty(iou: ArrayLike, visibility: ArrayLike, alpha: float = ALPHA) -> NDArray[np.float64]:
    """The paper's equation: u = 1 - c v if v < α, else u = 1 - c, in [0, 1], of the shape of the arguments.

    Args:
        iou: Certainty c, the intersection over union of silhouette and mask, in [0, 1].
        visibility: Share v of the silhouette inside the image, in [0, 1].
        alpha: Visibility from which it no longer matters, in [0, 1].

    Raises:
        InvalidEstimatesError: If an argument is out of its range.
    """
    c, v = floats("iou", iou, InvalidEstimatesError), floats("visibility", visibility, InvalidEstimatesError)
    _check_alpha(alpha)
    for name, values in (("iou", c), ("visibility", v)):
        if not ((values >= 0) & (values <= 1)).all():
            raise InvalidEstimatesError(f"{name} must be in [0, 1], but is {values}")
    return 1.0 - np.where(v < alpha, c * v, c)


def _check_alpha(alpha: float) -> None:
    check_number("alpha", alpha, InvalidEstimatesError, least=0, most=1)
