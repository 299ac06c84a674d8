"""Uncertainties from the disagreement of two pose estimators, scaled to [0, 1]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates
from maskval.geometry import Pose, angle_between
from maskval.pose_error import add, mdd

# The paper's upper end of the ADD disagreement, "5 cm to exclude high outliers".
ENSEMBLE_MAXIMUM_M = 0.05
# As far apart as two directions can be at all.
ENSEMBLE_MAXIMUM_RAD = np.pi


@dataclass(frozen=True, slots=True)
class EnsembleAdd:
    """The peer method of the paper: the ADD between the poses of two estimators.

    Args:
        minimum_m: Disagreement of u = 0, metres, >= 0; the paper takes the least of its test set.
        maximum_m: Disagreement of u = 1, metres, above the minimum.
    """

    minimum_m: float
    maximum_m: float = ENSEMBLE_MAXIMUM_M
    estimators: ClassVar[int] = 2

    def __post_init__(self) -> None:
        _check_range(self.minimum_m, self.maximum_m)

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """`clip((ADD - minimum) / (maximum - minimum), 0, 1)` of each detection, (N,).

        Raises:
            InvalidEstimatesError: If there is one estimator only.
        """
        points_O = estimates.mesh.vertices
        return _scaled(estimates, lambda X1, X2: add(X1, X2, points_O), self.minimum_m, self.maximum_m)


@dataclass(frozen=True, slots=True)
class EnsembleMdd:
    """The maximum distance error between the poses of two estimators, scaled like `EnsembleAdd`.

    Args:
        minimum_m: Disagreement of u = 0, metres, >= 0.
        maximum_m: Disagreement of u = 1, metres, above the minimum.
    """

    minimum_m: float
    maximum_m: float = ENSEMBLE_MAXIMUM_M
    estimators: ClassVar[int] = 2

    def __post_init__(self) -> None:
        _check_range(self.minimum_m, self.maximum_m)

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The scaled maximum distance of each detection, (N,), in [0, 1]."""
        points_O = estimates.mesh.vertices
        return _scaled(estimates, lambda X1, X2: mdd(X1, X2, points_O), self.minimum_m, self.maximum_m)


@dataclass(frozen=True, slots=True)
class EnsembleTranslation:
    """The distance between the translations of two estimators' poses, scaled like `EnsembleAdd`.

    Args:
        minimum_m: Disagreement of u = 0, metres, >= 0.
        maximum_m: Disagreement of u = 1, metres, above the minimum.
    """

    minimum_m: float = 0.0
    maximum_m: float = ENSEMBLE_MAXIMUM_M
    estimators: ClassVar[int] = 2

    def __post_init__(self) -> None:
        _check_range(self.minimum_m, self.maximum_m)

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The scaled distance of each detection, (N,), in [0, 1]."""
        return _scaled(
            estimates,
            lambda X1, X2: float(np.linalg.norm(X1.translation - X2.translation)),
            self.minimum_m,
            self.maximum_m,
        )


@dataclass(frozen=True, slots=True)
class EnsembleRotation:
    """The angle between the rotations of two estimators' poses, scaled like `EnsembleAdd`.

    Args:
        minimum_rad: Disagreement of u = 0, radians, >= 0.
        maximum_rad: Disagreement of u = 1, radians, above the minimum.
    """

    minimum_rad: float = 0.0
    maximum_rad: float = ENSEMBLE_MAXIMUM_RAD
    estimators: ClassVar[int] = 2

    def __post_init__(self) -> None:
        _check_range(self.minimum_rad, self.maximum_rad)

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The scaled angle of each detection, (N,), in [0, 1]."""
        return _scaled(
            estimates, lambda X1, X2: angle_between(X1.rotation, X2.rotation), self.minimum_rad, self.maximum_rad
        )


def _scaled(
    estimates: Estimates, disagreement: Callable[[Pose, Pose], float], minimum: float, maximum: float
) -> NDArray[np.float64]:
    if len(estimates.poses) < 2:
        raise InvalidEstimatesError(f"an ensemble needs 2 estimators, but the estimates hold {len(estimates.poses)}")
    used, other = estimates.poses[:2]
    values = np.array([disagreement(X1, X2) for X1, X2 in zip(used, other, strict=True)])
    return np.clip((values - minimum) / (maximum - minimum), 0.0, 1.0)


def _check_range(minimum: float, maximum: float) -> None:
    if not 0 <= minimum < maximum < np.inf:
        raise InvalidEstimatesError(f"disagreements must be 0 <= minimum < maximum, but are {minimum} and {maximum}")
