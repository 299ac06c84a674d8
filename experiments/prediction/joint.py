"""How far the paper's figures are from the prediction, all of them jointly, and whether it beats a random table."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist, pdist

from experiments.prediction.cells import EXPERIMENTS, PredictedCell, Rate

FITTED = "none"  # the method whose row of the robot table the gap is fitted to
_REPLICATES = 10_000
_SCORED = 2_000  # of them, for the distances of all pairs
_LEAST_VARIANCE = 1e-4  # of each figure, as in `gap_fit`: the paper's are given to .1 %, and some replicates all agree
_SAME = 1e-9  # squared distances that differ by less are equal

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Joint:
    """The paper's AP and AR of several cells as one point, beside replicates of what the paper did.

    A replicate is a world for each part, every world as often, and the means over 5 of its experiments drawn at random,
    the same ones for every method.

    Attributes:
        figures: how many AP and AR.
        p: posterior predictive p-value (Gelman, Meng and Stern 1996) of the squared Mahalanobis distance from the
            replicates' mean, with their covariance, summed over parts: the share of the replicates that are at least
            as far as the paper's figures.
        energy_score: mean Euclidean distance of the paper's figures from the replicates, less half of that between two
            replicates: a proper score, low is good; of a single figure it is the CRPS (Gneiting and Raftery 2007).
        random_energy_score: that of a table in which every figure is uniformly random in [0, 1].
    """

    figures: int
    p: float
    energy_score: float
    random_energy_score: float


def joint(cells: Sequence[PredictedCell], seed: int) -> dict[str, Joint]:
    """By part, and of "all" parts if there are several: the predicted cells that the paper has; empty without any.

    Args:
        cells: Of all parts and methods; those of one part have the same worlds and experiments.
        seed: Root of the replicates' random numbers.
    """
    chosen = [cell for cell in cells if cell.method != FITTED and cell.ap.paper is not None]
    parts = {
        part: [cell for cell in chosen if cell.object == part] for part in dict.fromkeys(cell.object for cell in chosen)
    }
    sequences = np.random.SeedSequence(seed, spawn_key=(5,)).spawn(len(parts) + 1)
    drawn: dict[str, tuple[Array, Array]] = {}
    for (part, group), sequence in zip(parts.items(), sequences[1:], strict=True):
        rows = _replicates(group, np.random.default_rng(sequence))
        rows = rows[~np.isnan(rows).any(axis=1)]
        if len(rows) > 0:
            drawn[part] = rows, _paper(group)
    random = np.random.default_rng(sequences[0])
    found = {part: _judge([one], random) for part, one in drawn.items()}
    return found | ({"all": _judge(list(drawn.values()), random)} if len(drawn) > 1 else {})


def _replicates(cells: Sequence[PredictedCell], rng: np.random.Generator) -> Array:
    """AP and AR of each cell in each replicate, (R, 2 C); NaN where no experiment of it has one."""
    counts = np.array([cell.counts for cell in cells], dtype=np.float64)
    hits, sizes = counts[..., :1], counts[..., :1] + counts[..., 1:3]
    rates = np.divide(hits, sizes, where=sizes > 0, out=np.full(sizes.shape, np.nan))
    world = rng.permutation(np.arange(_REPLICATES) % counts.shape[1])[:, None]
    experiments = rng.integers(counts.shape[2], size=(_REPLICATES, EXPERIMENTS))
    drawn = rates[:, world, experiments]
    there = ~np.isnan(drawn)
    number = there.sum(axis=2)
    means = np.divide(
        np.where(there, drawn, 0.0).sum(axis=2), number, where=number > 0, out=np.full(number.shape, np.nan)
    )
    return np.asarray(means.transpose(1, 0, 2).reshape(_REPLICATES, -1))


def _paper(cells: Sequence[PredictedCell]) -> Array:
    rates: list[Rate] = [rate for cell in cells for rate in (cell.ap, cell.ar)]
    return np.array([rate.paper for rate in rates], dtype=np.float64)


def _judge(drawn: Sequence[tuple[Array, Array]], random: np.random.Generator) -> Joint:
    """Of independent parts, the replicates and the paper's figures of each."""
    size = min(len(rows) for rows, _ in drawn)
    squared = np.sum([_squared_distances(rows[:size], robot) for rows, robot in drawn], axis=0)
    rows, robot = (np.concatenate(arrays, axis=-1) for arrays in zip(*((r[:size], y) for r, y in drawn), strict=True))
    return Joint(
        figures=len(robot),
        p=float(np.mean(squared[1:] >= squared[0] - _SAME)),
        energy_score=_energy_score(rows[:_SCORED], robot),
        random_energy_score=_energy_score(random.random((_SCORED, len(robot))), robot),
    )


def _squared_distances(rows: Array, robot: Array) -> Array:
    """Mahalanobis's of the paper's figures and of each replicate, (1 + R,)."""
    off = np.vstack((robot, rows)) - rows.mean(axis=0)
    inverse = np.linalg.inv(off[1:].T @ off[1:] / len(rows) + _LEAST_VARIANCE * np.eye(len(robot)))
    return np.asarray(np.einsum("ia,ab,ib->i", off, inverse, off))


def _energy_score(rows: Array, robot: Array) -> float:
    within = pdist(rows).mean() if len(rows) > 1 else 0.0
    return float(cdist(robot[None], rows).mean() - within / 2)
