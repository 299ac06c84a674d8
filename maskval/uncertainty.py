"""How uncertain an estimated pose is: the protocol, the paper's two methods, and the method that never doubts."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.camera import Camera
from maskval.errors import InvalidEstimatesError
from maskval.geometry import Pose
from maskval.mesh import Mesh
from maskval.pose_error import add
from maskval.silhouette import silhouette_iou

# The paper's sensitivity towards the visibility.
ALPHA = 0.8
# The paper's upper end of the ADD disagreement, "5 cm to exclude high outliers".
ENSEMBLE_MAXIMUM_M = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Estimates:
    """N detections of one kind of part in one image, and what one or more pose estimators make of them.

    Args:
        camera: Intrinsics and image size.
        mesh: The part.
        masks: The detector's masks, (N, H, W), bool.
        poses: poses[e][i] is estimator e's pose X_CO of detection i, made from mask i; estimator 0 is the one used.
        scores: The detector's confidences, (N,).
        pixel_center: Where pixel i of the masks is sampled, u = i + pixel_center.

    Raises:
        InvalidEstimatesError: If masks, poses and scores are not equally many, the masks are not of the image's
            size or not bool, or there is no estimator.
    """

    camera: Camera
    mesh: Mesh
    masks: NDArray[np.bool_]
    poses: tuple[tuple[Pose, ...], ...]
    scores: NDArray[np.float64]
    pixel_center: float = 0.0

    def __post_init__(self) -> None:
        masks, scores = np.array(self.masks), np.array(self.scores, dtype=np.float64)
        size = (self.camera.height, self.camera.width)
        if masks.dtype != np.bool_ or masks.ndim != 3 or masks.shape[1:] != size:
            raise InvalidEstimatesError(
                f"masks must be bool of shape (N, {size[0]}, {size[1]}), but are {masks.dtype} of {masks.shape}"
            )
        if not self.poses:
            raise InvalidEstimatesError("poses must hold those of at least one estimator, but hold none")
        for e, poses in enumerate(self.poses):
            if len(poses) != len(masks):
                raise InvalidEstimatesError(
                    f"every estimator must give a pose for each of {len(masks)} masks, but estimator {e} "
                    f"gives {len(poses)}"
                )
        if scores.shape != (len(masks),) or not np.isfinite(scores).all():
            raise InvalidEstimatesError(f"scores must be finite and of shape ({len(masks)},), but are {scores}")
        for name, array in (("masks", masks), ("scores", scores)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "poses", tuple(tuple(poses) for poses in self.poses))

    def __len__(self) -> int:
        return len(self.masks)


class UncertaintyMethod(Protocol):
    """An uncertainty quantification: anything that gives every estimated pose a number that is low for a good one."""

    @property
    def estimators(self) -> int:
        """How many pose estimators it needs."""
        ...

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The uncertainty u of each pose of estimator 0, (N,), in [0, 1]; low is good.

        Args:
            estimates: Detections and the poses of at least `estimators` estimators.
        """
        ...


@dataclass(frozen=True, slots=True)
class NoUncertainty:
    """The method that trusts every pose: u = 0."""

    estimators: ClassVar[int] = 1

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """Zero for each pose, (N,)."""
        return np.zeros(len(estimates))


@dataclass(frozen=True, slots=True)
class MaskVal:
    """The paper's method: compare each pose's silhouette with the mask that it was made from.

    Args:
        alpha: Visibility below which the certainty is lowered by the visibility, in [0, 1].
    """

    alpha: float = ALPHA
    estimators: ClassVar[int] = 1

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


@dataclass(frozen=True, slots=True)
class EnsembleAdd:
    """The peer method of the paper: how far the poses of two estimators are apart (ADD), scaled to [0, 1].

    Args:
        minimum_m: Disagreement of u = 0, metres, >= 0; the paper takes the least of its test set.
        maximum_m: Disagreement of u = 1, metres, above the minimum.
    """

    minimum_m: float
    maximum_m: float = ENSEMBLE_MAXIMUM_M
    estimators: ClassVar[int] = 2

    def __post_init__(self) -> None:
        if not 0 <= self.minimum_m < self.maximum_m < np.inf:
            raise InvalidEstimatesError(
                f"the disagreements must be 0 <= minimum_m < maximum_m, but are {self.minimum_m} and {self.maximum_m}"
            )

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """`clip((ADD - minimum) / (maximum - minimum), 0, 1)` of each detection, (N,).

        Raises:
            InvalidEstimatesError: If there is one estimator only.
        """
        if len(estimates.poses) < self.estimators:
            raise InvalidEstimatesError(
                f"EnsembleAdd needs 2 estimators, but the estimates hold {len(estimates.poses)}"
            )
        used, other = estimates.poses[:2]
        points_O = estimates.mesh.vertices
        distances = np.array([add(X1, X2, points_O) for X1, X2 in zip(used, other, strict=True)])
        return np.clip((distances - self.minimum_m) / (self.maximum_m - self.minimum_m), 0.0, 1.0)


def maskval_uncertainty(iou: ArrayLike, visibility: ArrayLike, alpha: float = ALPHA) -> NDArray[np.float64]:
    """The paper's equation: u = 1 - c v if v < α, else u = 1 - c, in [0, 1], of the shape of the arguments.

    Args:
        iou: Certainty c, the intersection over union of silhouette and mask, in [0, 1].
        visibility: Share v of the silhouette inside the image, in [0, 1].
        alpha: Visibility from which it no longer matters, in [0, 1].

    Raises:
        InvalidEstimatesError: If an argument is out of its range.
    """
    c, v = np.asarray(iou, dtype=np.float64), np.asarray(visibility, dtype=np.float64)
    _check_alpha(alpha)
    for name, values in (("iou", c), ("visibility", v)):
        if not ((values >= 0) & (values <= 1)).all():
            raise InvalidEstimatesError(f"{name} must be in [0, 1], but is {values}")
    return 1.0 - np.where(v < alpha, c * v, c)


def _check_alpha(alpha: float) -> None:
    if not 0 <= alpha <= 1:
        raise InvalidEstimatesError(f"alpha must be in [0, 1], but is {alpha}")
