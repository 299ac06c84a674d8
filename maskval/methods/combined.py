"""Several uncertainty methods as one."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEstimatesError
from maskval.estimates import Estimates, Needs, UncertaintyMethod, needs_of


@dataclass(frozen=True, slots=True)
class Combined:
    """Multiplies the certainties of its methods, as the paper multiplies certainty and visibility: u = 1 - Π (1 - u_k).

    Nothing is fitted: a pose is trusted as far as all methods trust it, and each one alone can refuse it.

    Args:
        methods: At least one, in any order.
    """

    methods: tuple[UncertaintyMethod, ...]

    def __post_init__(self) -> None:
        if not self.methods:
            raise InvalidEstimatesError("methods must be at least one, but are none")

    @property
    def needs(self) -> Needs:
        """What all of its methods need together."""
        return Needs.together(*map(needs_of, self.methods))

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        """The combined u of each pose, (N,), in [0, 1]."""
        certainties = [1.0 - method(estimates) for method in self.methods]
        return np.asarray(1.0 - np.prod(certainties, axis=0))
