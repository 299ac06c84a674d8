"""Uncertainties from the disagreement of two pose estimators, scaled to [0, 1]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs
from maskval.geometry import Pose
from maskval.pose_errors import add, mdd, rotation_error, translation_error

Disagreement = Literal["add", "mdd", "translation", "rotation"]
# The paper's upper end of the ADD disagreement, "5 cm to exclude high outliers"; taken for all distances.
ENSEMBLE_MAXIMUM_M = 0.05
# As far apart as two directions can be at all.
ENSEMBLE_MAXIMUM_RAD = np.pi

_DISAGREEMENTS: dict[Disagreement, Callable[[Pose, Pose, NDArray[np.float64]], float]] = {
    "add": add,
    "mdd": mdd,
    "translation": lambda X1, X2, _: translation_error(X1, X2),
    "rotation": lambda X1, X2, _: rotation_error(X1, X2),
}


@dataclass(frozen=True, slots=True)
class Ensemble:
    """The peer method of the paper: how far the poses of two estimators are apart (Shi et al. 2021).

    Args:
        disagreement: What is far apart: the mean point ("add", the paper's choice), the farthest point ("mdd"), the
            translations or the rotations.
        minimum: Disagreement of u = 0, metres, or radians of rotations, >= 0; the paper takes the least of its
            test set.
        maximum: Disagreement of u = 1, above the minimum; 5 cm or half a turn by default.

    Raises:
        InvalidEstimatesError: If there is no such disagreement, or the scale is empty.
    """

    disagreement: Disagreement = "add"
    minimum: float = 0.0
    maximum: float | None = None
    needs: ClassVar[Needs] = Needs(estimators=2)

    def __post_init__(self) -> None:
        if self.disagreement not in _DISAGREEMENTS:
            known = ", ".join(get_args(Disagreement))
            raise InvalidEstimatesError(f"disagreement must be one of {known}, but is {self.disagreement!r}")
        if not 0 <= self.minimum < self._maximum < np.inf:
            raise InvalidEstimatesError(
                f"disagreements must be 0 <= minimum < maximum, but are {self.minimum} and {self._maximum}"
            )

    @property
    def _maximum(self) -> float:
        if self.maximum is not None:
            return self.maximum
        return ENSEMBLE_MAXIMUM_RAD if self.disagreement == "rotation" else ENSEMBLE_MAXIMUM_M

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """`clip((disagreement - minimum) / (maximum - minimum), 0, 1)` of each detection, (N,).

        Raises:
            InvalidEstimatesError: If there is one estimator only.
        """
        if len(estimates.poses) < 2:
            raise InvalidEstimatesError(
                f"an ensemble needs 2 estimators, but the estimates hold {len(estimates.poses)}"
            )
        measure, points_O = _DISAGREEMENTS[self.disagreement], estimates.mesh.vertices
        used, other = estimates.poses[:2]
        values = np.array([measure(X1, X2, points_O) for X1, X2 in zip(used, other, strict=True)])
        return np.clip((values - self.minimum) / (self._maximum - self.minimum), 0.0, 1.0)
