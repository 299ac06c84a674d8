"""The methods that every other one must beat: trust all, trust the detector, trust at random."""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates


@dataclass(frozen=True, slots=True)
class NoUncertainty:
    """The method that trusts every pose: u = 0."""

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """Zero for each pose, (N,)."""
        return np.zeros(len(estimates))


@dataclass(frozen=True, slots=True)
class DetectorScore:
    """The method that trusts the detector: u = 1 - score."""

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """1 - score of each detection, (N,), in [0, 1].

        Raises:
            InvalidEstimatesError: If a score is not in [0, 1].
        """
        scores = estimates.scores
        if not ((scores >= 0) & (scores <= 1)).all():
            raise InvalidEstimatesError(f"scores must be in [0, 1], but are {scores}")
        return np.asarray(1.0 - scores)


@dataclass(frozen=True, slots=True)
class RandomUncertainty:
    """Chance, the floor: a uniform number that depends on the seed and the pose only, to 1e-9.

    The same pose has the same u whenever it is looked at, and in whatever company.

    Args:
        seed: Another seed gives other numbers, in [0, 2^64).
    """

    seed: int

    def __post_init__(self) -> None:
        if not 0 <= self.seed < 2**64:
            raise InvalidEstimatesError(f"seed must be in [0, 2^64), but is {self.seed}")

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """A number for each pose, (N,), uniform in [0, 1)."""
        key = self.seed.to_bytes(8, "little")
        # Processors differ in a pose's last bits. Adding 0 makes 0 of -0.
        rounded = (np.round(X_CO.matrix, 9) + 0.0 for X_CO in estimates.poses[0])
        digests = (hashlib.blake2b(matrix.tobytes(), digest_size=8, key=key).digest() for matrix in rounded)
        # The 53 upper bits: as many as a float in [0, 1) can hold.
        return np.array([(int.from_bytes(digest, "little") >> 11) * 2.0**-53 for digest in digests])
