"""The most probable parameters and how well they are determined: least squares with priors on common random numbers.

Parameters are counted in standard deviations of their priors, z. What is minimised is the sum of squares of
((figure − target) / sd) over the targets and of z over the parameters: the posterior's mode. The same images and random
numbers serve every set of parameters, so that figures change smoothly enough for finite differences. Around the mode
the posterior is taken for normal, with the covariance (JᵀJ + 1)⁻¹ (Laplace's approximation).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

STEP = 0.4  # of a finite difference, in standard deviations of the prior: well above what single outliers change
_ARRIVED = 0.01  # a step that changes the parameters, or lowers the sum of squares, by a smaller share is the last

Array = NDArray[np.float64]
Misses = Callable[[Sequence[Array]], list[Array]]  # of many z, each (D,): (figure - target) / sd of each, (T,)


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """A fit of D parameters to T targets.

    Attributes:
        z: the most probable parameters, in standard deviations of their priors, (D,).
        misses: (figure − target) / sd there, (T,).
        jacobian: how the misses change with z, (T, D).
        rounds: how often the Jacobian was taken.
    """

    z: Array
    misses: Array
    jacobian: Array
    rounds: int

    @property
    def covariance(self) -> Array:
        """Of z, (D, D), after the fit; 1 before it."""
        return np.asarray(np.linalg.inv(self.jacobian.T @ self.jacobian + np.eye(len(self.z))))

    @property
    def sd(self) -> Array:
        """What is left of each parameter's standard deviation, (D,), of 1 before the fit."""
        left: Array = np.sqrt(np.diag(self.covariance))
        return left

    @property
    def determined(self) -> int:
        """How many combinations of parameters the targets say more about than the priors."""
        return int(np.count_nonzero(np.linalg.eigvalsh(self.jacobian.T @ self.jacobian) > 1.0))

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Parameters as probable as the targets leave them, (count, D)."""
        drawn: Array = rng.multivariate_normal(self.z, self.covariance, size=count)
        return drawn

    def corrected(self, z: Array, misses: Array) -> Array:
        """A draw moved to where it misses what it was drawn to miss: figures are curved, the covariance is not.

        Args:
            z: The draw, (D,).
            misses: What it misses, (T,).
        """
        meant = self.misses + self.jacobian @ (z - self.z)
        moved: Array = z - self.covariance @ self.jacobian.T @ (misses - meant)
        return moved


def fit(misses: Misses, start: Array, rounds: int) -> Fit:
    """The most probable parameters.

    Args:
        misses: The misses of many sets of parameters; they may be worked out at the same time.
        start: Where to begin, (D,).
        rounds: At most this many steps; 1 stays at the start and only takes the Jacobian there.
    """
    parameters = len(start)
    taken = 0
    last: tuple[Array, Array] | None = None

    def residuals(z: Array) -> Array:
        nonlocal last
        last = z.copy(), misses([z])[0]
        return np.concatenate((last[1], z))

    def jacobian(z: Array) -> Array:
        nonlocal taken
        taken += 1
        here = last[1] if last is not None and np.array_equal(last[0], z) else misses([z])[0]
        ahead = np.array(misses(list(z + STEP * np.eye(parameters))))
        return np.vstack(((ahead - here).T / STEP, np.eye(parameters)))

    found = least_squares(residuals, start, jac=jacobian, xtol=_ARRIVED, ftol=_ARRIVED, max_nfev=rounds)
    targets = len(found.fun) - parameters
    return Fit(found.x, found.fun[:targets], found.jac[:targets], taken)
