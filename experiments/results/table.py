"""From experiments to the cells of the table: the paper's averages, pooled figures and their intervals."""

from collections.abc import Hashable, Sequence
from dataclasses import asdict, dataclass
from statistics import fmean
from typing import Any

from cell.records import Tally
from experiments.results.first_attempts import FirstAttempts
from maskval import proportion_interval
from maskval.statistics.cluster_intervals import clustered_rate_interval

Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Cell:
    """One cell of the table; rates in [0, 1], None where undefined. The names are those of table.json, a contract.

    Attributes:
        object: name of the part.
        method: name of the method.
        policy: name of the policy.
        experiments: how many have a result.
        failed: how many have none.
        parts: parts that lay on the belts.
        tp: parts placed.
        fp: failed attempts.
        fn: parts left on the belt.
        void: attempts that met nothing.
        timeouts: slots that ran out.
        ap: TP/(TP+FP), mean over the experiments that have one: the paper's figure.
        ar: TP/(TP+FN), likewise.
        ap_pooled: the same of the summed counts.
        ar_pooled: likewise.
        ap_ci: 95 % interval of `ap`, by the variance between worlds; see `clustered_rate_interval`.
        ar_ci: likewise of `ar`.
        cycle_time_s: time of all experiments per placed part, s.
        worlds: how many error models the experiments with a result had; without a domain gap each counts as one.
        ap_pooled_ci: 95 % Clopper-Pearson interval of `ap_pooled`, as if all attempts were independent.
        ar_pooled_ci: likewise of `ar_pooled`.
        ap_first: AP of the first attempt for each part (see `FirstAttempts`), mean over the experiments that have one.
        ap_first_ci: 95 % interval of `ap_first`, as of `ap`.
        parts_failed: distinct parts that an attempt failed for, summed over experiments.
        same: letters; cells of one object that share one cannot be told apart in parts placed. None without another.
    """

    object: str
    method: str
    policy: str
    experiments: int
    failed: int
    parts: int
    tp: int
    fp: int
    fn: int
    void: int
    timeouts: int
    ap: float | None
    ar: float | None
    ap_pooled: float | None
    ar_pooled: float | None
    ap_ci: Interval | None
    ar_ci: Interval | None
    cycle_time_s: float | None
    worlds: int
    ap_pooled_ci: Interval | None
    ar_pooled_ci: Interval | None
    ap_first: float | None
    ap_first_ci: Interval | None
    parts_failed: int | None
    same: str | None = None

    def as_json(self) -> dict[str, Any]:
        """The cell as it stands in table.json."""
        return asdict(self)


def make_cell(
    of: tuple[str, str, str],
    counts: Sequence[Tally | None],
    worlds: Sequence[Hashable] | None = None,
    firsts: Sequence[FirstAttempts | None] = (),
) -> Cell:
    """The cell of the experiments with one object, one method and one policy.

    Args:
        of: Names of object, method and policy.
        counts: Of each experiment; None for one that failed.
        worlds: Label of each experiment's world: those with one error model have one. Without it each has its own.
        firsts: First attempts of each experiment; None for one that failed. Without it they are unknown.
    """
    labels = range(len(counts)) if worlds is None else worlds
    done = [count for count in counts if count is not None]
    world = [label for count, label in zip(counts, labels, strict=True) if count is not None]
    known = [first for first in firsts if first is not None]
    tp, fp, fn = (sum(getattr(count, name) for count in done) for name in ("tp", "fp", "fn"))
    return Cell(
        object=of[0],
        method=of[1],
        policy=of[2],
        experiments=len(done),
        failed=len(counts) - len(done),
        parts=sum(count.parts for count in done),
        tp=tp,
        fp=fp,
        fn=fn,
        void=sum(count.void for count in done),
        timeouts=sum(count.timeouts for count in done),
        ap=_mean([count.ap for count in done]),
        ar=_mean([count.ar for count in done]),
        ap_pooled=tp / (tp + fp) if tp + fp else None,
        ar_pooled=tp / (tp + fn) if tp + fn else None,
        ap_ci=_interval([count.ap for count in done], [count.tp + count.fp for count in done], world),
        ar_ci=_interval([count.ar for count in done], [count.tp + count.fn for count in done], world),
        cycle_time_s=sum(count.duration for count in done) / tp if tp else None,
        worlds=len(set(world)),
        ap_pooled_ci=proportion_interval(tp, tp + fp),
        ar_pooled_ci=proportion_interval(tp, tp + fn),
        ap_first=_mean([first.ap for first in known]),
        ap_first_ci=_interval([first.ap for first in known], [first.parts for first in known], world)
        if known
        else None,
        parts_failed=sum(first.failed for first in known) if known else None,
    )


def _mean(rates: Sequence[float | None]) -> float | None:
    defined = [rate for rate in rates if rate is not None]
    return fmean(defined) if defined else None


def _interval(rates: Sequence[float | None], trials: Sequence[int], worlds: Sequence[Hashable]) -> Interval | None:
    """The interval of the mean over the experiments that have a rate."""
    defined = [rate for rate in rates if rate is not None]
    places = [place for place, rate in enumerate(rates) if rate is not None]
    return clustered_rate_interval(defined, [trials[place] for place in places], [worlds[place] for place in places])
