"""What one method does better than another on the same experiments: differences within them, not between averages."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import fmean
from typing import Any

from cell.records import Tally
from experiments.results.pair_tests import PairTest, Who
from experiments.results.table import Interval
from maskval import mean_interval
from maskval.statistics.cluster_intervals import clustered_rate_interval

REFERENCE = "maskval"  # what the others are held against, if it is among them

Counts = Mapping[Who, Sequence[Sequence[Tally | None]]]  # of each group of experiments; None failed


@dataclass(frozen=True, slots=True)
class Paired:
    """How many parts more than the reference a method and policy place and fail, per experiment; as in table.json.

    Attributes:
        object: name of the part.
        method: name of the method.
        policy: name of the policy.
        reference: name of the other method.
        reference_policy: name of the other policy.
        experiments: how many have a result with both.
        placed: mean difference of TP, over groups.
        placed_ci: its 95 % interval, see `difference_interval`; None of fewer than two groups of experiments.
        failed: mean difference of FP, over groups.
        failed_ci: its 95 % interval.
    """

    object: str
    method: str
    policy: str
    reference: str
    reference_policy: str
    experiments: int
    placed: float
    placed_ci: Interval | None
    failed: float
    failed_ci: Interval | None

    def as_json(self) -> dict[str, Any]:
        """As it stands in table.json."""
        return asdict(self)


def pair(part: str, counts: Counts) -> list[Paired]:
    """Every other method and policy beside the first with `REFERENCE`, or beside the first of all.

    There is no row where no experiment has a result with both.

    Args:
        part: Name of the part.
        counts: By method and policy, the same groups of the same experiments. Groups are independent of one another:
            each an experiment of its own, or those of one world.
    """
    reference = next((who for who in counts if who[0] == REFERENCE), next(iter(counts)))
    rows = []
    for who in counts:
        groups = [_both(ours, theirs) for ours, theirs in zip(counts[who], counts[reference], strict=True)]
        if who == reference or not any(groups):
            continue
        slots = [[ours.parts for ours, _ in group] for group in groups if group]
        placed = [fmean(ours.tp - theirs.tp for ours, theirs in group) for group in groups if group]
        failed = [fmean(ours.fp - theirs.fp for ours, theirs in group) for group in groups if group]
        rows.append(
            Paired(
                object=part,
                method=who[0],
                policy=who[1],
                reference=reference[0],
                reference_policy=reference[1],
                experiments=sum(map(len, groups)),
                placed=fmean(placed),
                placed_ci=difference_interval(placed, slots),
                failed=fmean(failed),
                failed_ci=difference_interval(failed, slots),
            )
        )
    return rows


def difference_interval(differences: Sequence[float], slots: Sequence[Sequence[int]]) -> Interval | None:
    """The 95 % interval of the mean difference per experiment; None of fewer than two groups.

    Student's over the groups. If all of them differ by the same d, that has no width, though further ones may differ
    otherwise. Then every time slot is a trial that did not depart from d, and on either side as many parts may depart
    as the upper bound of such a share allows: that of `clustered_rate_interval` for none of n.

    Args:
        differences: Mean difference of each group, in parts per experiment.
        slots: Of each group, the number of time slots of its experiments.
    """
    if len(differences) < 2:
        return None
    varied = mean_interval(differences)
    if varied is not None:
        return varied
    trials = [slot for group in slots for slot in group]
    groups = [number for number, group in enumerate(slots) for _ in group]
    share = clustered_rate_interval([0.0] * len(trials), trials, groups)
    assert share is not None  # there are trials
    most = fmean(trials)
    return max(differences[0] - most * share[1], -most), min(differences[0] + most * share[1], most)


def format_paired(rows: Sequence[Paired], tests: Sequence[PairTest] = ()) -> str:
    """A line per row, beneath the table; nothing without rows. With tests, the p of each row's difference in parts."""
    if not rows:
        return ""
    named = have_several_policies({who for row in rows for who in _both_sides(row)})
    reference = f"{rows[0].reference} + {rows[0].reference_policy}" if named else rows[0].reference
    whos = [f"{row.method} + {row.policy}" if named else row.method for row in rows]
    widths = max(6, *(len(row.object) for row in rows)), max(6, *map(len, whos))
    p = {(test.object, frozenset((test.first, test.second))): test.p_holm for test in tests}
    lines = [
        f"parts per experiment, less those of {reference} in the same experiments [95 %]",
        f"{'object':{widths[0]}}  {'method':{widths[1]}}  {'placed':22}  {'p   ' if p else ''}  {'failed':22}  runs",
    ]
    for row, who in zip(rows, whos, strict=True):
        shown = f"{_p(p[row.object, frozenset(_both_sides(row))])}  " if p else "  "
        lines.append(
            f"{row.object:{widths[0]}}  {who:{widths[1]}}  {_difference(row.placed, row.placed_ci)}  "
            f"{shown}{_difference(row.failed, row.failed_ci)}  {row.experiments:4}"
        )
    if p:
        lines.append("p: of the difference in parts placed, by sign flips over worlds, adjusted by Holm")
    return "\n".join(lines)


def _p(p: float) -> str:
    """A p without its zero, in four characters."""
    return "1.00" if p >= 0.995 else "<.01" if p < 0.005 else f"{p:.2f}"[1:].rjust(4)


def have_several_policies(whos: Collection[Who]) -> bool:
    """Whether a method occurs with more than one policy, so that the policy must be named."""
    return len({method for method, _ in whos}) < len(set(whos))


def _both_sides(row: Paired) -> tuple[Who, Who]:
    return (row.method, row.policy), (row.reference, row.reference_policy)


def _both(ours: Sequence[Tally | None], theirs: Sequence[Tally | None]) -> list[tuple[Tally, Tally]]:
    return [(a, b) for a, b in zip(ours, theirs, strict=True) if a is not None and b is not None]


def _difference(mean: float, interval: Interval | None) -> str:
    ends = "[–]" if interval is None else f"[{interval[0]:+.2f}, {interval[1]:+.2f}]"
    return f"{mean:+.2f} {ends:16}"
