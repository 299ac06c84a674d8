"""Where on a grid of gaps the cell without uncertainty quantification does as the paper's robot did.

Every point of the grid is simulated; between the points, mean and covariance of an experiment's (AP, AR) are
interpolated linearly. The paper gives one number for each, a mean over five experiments: its likelihood is normal, with
a fifth of the covariance, and the simulation's own error. A priori every logarithm within the grid is equally probable.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from cell.records import Tally
from experiments.errors import UsageError
from sim.networks.domain_gap import Gap

PAPER_EXPERIMENTS = 5
CORE_SCALES = (1.0, 1.5, 2.25)
OUTLIER_ODDS = (1.0, 4.0, 16.0, 64.0)
_FINE = 41  # points per axis at which the likelihood is taken
_FEWEST = 2  # experiments that a covariance takes
_LEAST_VARIANCE = 1e-4  # of an experiment's AP or AR: where all of a point's experiments agree

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class GapFit:
    """What the paper's row says of the gap.

    Attributes:
        mode: the most probable gap.
        expected: AP and AR of an experiment there.
        core_scales: of the fine grid, (F,).
        outlier_odds: of the fine grid, (F,).
        probability: of each fine grid point, (F, F); the sum is 1.
        misfit: squared Mahalanobis distance of the paper's AP and AR at the mode; above 6 they are out of reach.
    """

    mode: Gap
    expected: tuple[float, float]
    core_scales: Array
    outlier_odds: Array
    probability: Array
    misfit: float

    def draw(self, count: int, rng: np.random.Generator) -> list[Gap]:
        """Gaps as probable as the paper's row leaves them."""
        flat = rng.choice(self.probability.size, size=count, p=self.probability.ravel())
        rows, columns = np.unravel_index(flat, self.probability.shape)
        return [
            Gap(float(self.core_scales[row]), float(self.outlier_odds[column]))
            for row, column in zip(rows, columns, strict=True)
        ]

    def interval(self, axis: int) -> tuple[float, float]:
        """95 % of what is believed of the core's scale (axis 0) or the odds (axis 1)."""
        values = (self.core_scales, self.outlier_odds)[axis]
        below = np.cumsum(self.probability.sum(axis=1 - axis))
        low, high = np.searchsorted(below, (0.025, 0.975))
        return float(values[low]), float(values[min(high, len(values) - 1)])


def design() -> list[Gap]:
    """The gaps to simulate, row by row of equal scale."""
    return [Gap(scale, odds) for scale, odds in product(CORE_SCALES, OUTLIER_ODDS)]


def fit_gap(counts: Sequence[Sequence[Tally]], paper: tuple[float, float]) -> GapFit:
    """The gap that the paper's row speaks for.

    Args:
        counts: The experiments of each gap of `design`.
        paper: The row's AP and AR, in [0, 1].

    Raises:
        UsageError: at one of the gaps fewer than two experiments have an AP and an AR.
    """
    rates = [np.array([(one.ap, one.ar) for one in row if one.ap is not None and one.ar is not None]) for row in counts]
    for one, row in zip(design(), rates, strict=True):
        if len(row) < _FEWEST:
            raise UsageError(
                f"expected at least {_FEWEST} experiments with grasps at every gap of the grid, got {len(row)} at core "
                f"scale {one.core_scale:g}, outlier odds {one.outlier_odds:g}: more --experiments give more"
            )
    shape = (len(CORE_SCALES), len(OUTLIER_ODDS))
    axes = (np.log(CORE_SCALES), np.log(OUTLIER_ODDS))
    mean = np.array([row.mean(axis=0) for row in rates]).reshape(*shape, 2)
    spread = np.array([np.cov(row.T) + _LEAST_VARIANCE * np.eye(2) for row in rates]).reshape(*shape, 2, 2)
    terms = np.array([1.0 / PAPER_EXPERIMENTS + 1.0 / len(row) for row in rates]).reshape(shape)
    fine = tuple(np.linspace(axis[0], axis[-1], _FINE) for axis in axes)
    points = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1)
    expected = RegularGridInterpolator(axes, mean)(points)
    covariance = RegularGridInterpolator(axes, spread * terms[..., None, None])(points)
    off = np.array(paper) - expected
    misfit = np.einsum("ija,ijab,ijb->ij", off, np.linalg.inv(covariance), off)
    likelihood = -0.5 * (misfit + np.log(np.linalg.det(covariance)))
    probability = np.exp(likelihood - likelihood.max())
    best = np.unravel_index(int(probability.argmax()), probability.shape)
    scales, odds = (np.exp(axis) for axis in fine)
    return GapFit(
        mode=Gap(float(scales[best[0]]), float(odds[best[1]])),
        expected=(float(expected[best][0]), float(expected[best][1])),
        core_scales=scales,
        outlier_odds=odds,
        probability=probability / probability.sum(),
        misfit=float(misfit[best]),
    )
