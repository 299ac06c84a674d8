"""From the counts of many experiments in several worlds to what five experiments in one of them would show."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean

import numpy as np
from numpy.typing import NDArray

from cell.records import Tally
from experiments.results.first_attempts import FirstAttempts
from maskval.statistics.intervals import percentile_interval

EXPERIMENTS = 5  # of the paper's robot per cell
LEVEL = 0.95
_REPLICATES = 4_000

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Rate:
    """A predicted AP or AR.

    Attributes:
        mean: over all experiments that have one.
        interval: 95 % of the means over 5 experiments of one world.
        paper: what the paper's robot had, if it did.
    """

    mean: float | None
    interval: tuple[float, float] | None
    paper: float | None

    @property
    def agrees(self) -> bool | None:
        """Whether the paper's rate lies in the interval; None without one."""
        if self.paper is None or self.interval is None:
            return None
        return self.interval[0] <= self.paper <= self.interval[1]


@dataclass(frozen=True, slots=True)
class PredictedCell:
    """A cell of the robot table.

    Attributes:
        object: name of the part.
        method: name of the method.
        experiments: how many were run.
        tp: parts placed.
        fp: failed attempts.
        fn: parts left on the belt.
        timeouts: slots that ran out.
        ap: predicted.
        ar: predicted.
        counts: of each experiment, by world, as [tp, fp, fn, timeouts].
        ap_first: AP of the first attempt for each part (see `FirstAttempts`), mean over the experiments that have one.
        parts_failed: distinct parts that an attempt failed for, summed over experiments.
        first_attempts: of each experiment, by world, as [parts, placed, failed]; None in files that lack them.
    """

    object: str
    method: str
    experiments: int
    tp: int
    fp: int
    fn: int
    timeouts: int
    ap: Rate
    ar: Rate
    counts: list[list[list[int]]]
    ap_first: float | None = None
    parts_failed: int | None = None
    first_attempts: list[list[list[int]]] | None = None


def predict_cell(
    part: str,
    method: str,
    worlds: Sequence[Sequence[Tally]],
    paper: tuple[float, float] | None,
    seed: int,
    *,
    firsts: Sequence[Sequence[FirstAttempts]] | None = None,
) -> PredictedCell:
    """A cell from the counts of each world's experiments.

    Args:
        part: Name of the part.
        method: Name of the method.
        worlds: At least one, each with at least one experiment.
        paper: AP and AR of the paper's robot.
        seed: Root of the replicates' random numbers.
        firsts: First attempts of the same experiments, if they are known.
    """
    counts = [count for row in worlds for count in row]
    known = [first for row in firsts or () for first in row]
    defined = [first.ap for first in known if first.ap is not None]
    return PredictedCell(
        object=part,
        method=method,
        experiments=len(counts),
        tp=sum(count.tp for count in counts),
        fp=sum(count.fp for count in counts),
        fn=sum(count.fn for count in counts),
        timeouts=sum(count.timeouts for count in counts),
        ap=_rate([[count.ap for count in row] for row in worlds], paper[0] if paper else None, seed),
        ar=_rate([[count.ar for count in row] for row in worlds], paper[1] if paper else None, seed),
        counts=[[[one.tp, one.fp, one.fn, one.timeouts] for one in row] for row in worlds],
        ap_first=fmean(defined) if defined else None,
        parts_failed=sum(first.failed for first in known) if known else None,
        first_attempts=[[[one.parts, one.placed, one.failed] for one in row] for row in firsts] if firsts else None,
    )


def _rate(worlds: list[list[float | None]], paper: float | None, seed: int) -> Rate:
    table = np.array([[np.nan if rate is None else rate for rate in row] for row in worlds])
    if np.isnan(table).all():
        return Rate(None, None, paper)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(4,)))
    chosen = rng.integers(len(table), size=(_REPLICATES, 1))
    replicates = table[chosen, rng.integers(table.shape[1], size=(_REPLICATES, EXPERIMENTS))]
    replicates = replicates[~np.isnan(replicates).all(axis=1)]  # a mean over no defined rate is none
    means = np.nanmean(replicates, axis=1)
    return Rate(float(np.nanmean(table)), percentile_interval(means.tolist(), LEVEL), paper)
