"""Every two methods of a table on the same parts: tests, intervals, and letters for those that cannot be told apart."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import combinations
from statistics import fmean
from typing import Any

from experiments import progress
from experiments.results.counted import Counted
from experiments.results.table import Interval
from experiments.statistics.clusters import ratio_difference
from experiments.statistics.holm import holm
from experiments.statistics.letters import compact_letters
from experiments.statistics.mcnemar import PairedParts, count_parts, mcnemar_p, tango_interval

Who = tuple[str, str]  # method and policy
ALPHA = 0.05


@dataclass(frozen=True, slots=True)
class Contrast:
    """By how much a figure of the first exceeds that of the second: pooled over the experiments that both have.

    Attributes:
        difference: in the figure's unit.
        interval: its 95 % interval over worlds; None of fewer than two worlds, or if nothing varies between them.
        p: two-sided, by sign flips of the worlds' differences.
    """

    difference: float
    interval: Interval | None
    p: float


@dataclass(frozen=True, slots=True)
class PairTest:
    """Two methods and policies on the same parts. The names are table.json's.

    Attributes:
        object: name of the part.
        first: method and policy.
        second: method and policy.
        experiments: how many both have a result of.
        worlds: how many error models these had.
        parts: in how many of their parts both, either or none was placed.
        mcnemar_p: exact, as if parts were independent.
        share_ci: Tango's 95 % interval of the difference between the shares of parts placed, likewise.
        placed: parts placed per experiment.
        failed: failed attempts per experiment.
        ap: TP/(TP+FP); None where neither has an attempt that counts.
        ar: TP/(TP+FN).
        cycle_time_s: time per placed part, s; None where one placed none.
        p_holm: that of `placed`, adjusted for all comparisons of the table.
    """

    object: str
    first: Who
    second: Who
    experiments: int
    worlds: int
    parts: PairedParts
    mcnemar_p: float
    share_ci: Interval
    placed: Contrast
    failed: Contrast
    ap: Contrast | None
    ar: Contrast | None
    cycle_time_s: Contrast | None
    p_holm: float = 1.0

    def as_json(self) -> dict[str, Any]:
        """As it stands in table.json."""
        return asdict(self)


def pair_tests(counted: Sequence[Counted]) -> list[PairTest]:
    """Of every two methods and policies that share an experiment with a result, object by object."""
    groups: dict[str, dict[Who, dict[int, Counted]]] = {}
    for one in counted:
        if one.count is not None:
            groups.setdefault(one.of[0], {}).setdefault(one.of[1:], {})[one.experiment] = one
    both = [
        (part, first, second, [(mine[number], theirs[number]) for number in mine if number in theirs])
        for part, whos in groups.items()
        for (first, mine), (second, theirs) in combinations(whos.items(), 2)
        if mine.keys() & theirs.keys()
    ]
    tests = [_test(*pair) for pair in progress.counted(both, "pair", "test", after=progress.SHOWN_AFTER)]
    adjusted = holm([test.placed.p for test in tests]) if tests else []
    return [replace(test, p_holm=p) for test, p in zip(tests, adjusted, strict=True)]


def letters(tests: Sequence[PairTest], counted: Sequence[Counted]) -> dict[tuple[str, str, str], str]:
    """By object, method and policy: those of one object that share a letter cannot be told apart in parts placed."""
    found = {}
    for part in dict.fromkeys(test.object for test in tests):
        own = [test for test in tests if test.object == part]
        means = {
            "\0".join(who): fmean(one.count.tp for one in counted if one.of == (part, *who) and one.count is not None)
            for who in dict.fromkeys(who for test in own for who in (test.first, test.second))
        }
        different = [("\0".join(test.first), "\0".join(test.second)) for test in own if test.p_holm < ALPHA]
        for name, shown in compact_letters(means, different).items():
            method, policy = name.split("\0")
            found[part, method, policy] = shown
    return found


def _test(part: str, first: Who, second: Who, pairs: Sequence[tuple[Counted, Counted]]) -> PairTest:
    parts = count_parts(*(_placed([pair[side] for pair in pairs]) for side in (0, 1)))
    worlds = [one.world for one, _ in pairs]
    sums = [_sums([pair[side] for pair in pairs]) for side in (0, 1)]

    def contrast(above: str, below: str) -> Contrast | None:
        ours, theirs = ((side[above], side[below]) for side in sums)
        if not sum(ours[1]) or not sum(theirs[1]):
            return None
        found = ratio_difference(ours, theirs, worlds)
        return Contrast(found.value, found.interval, found.p)

    placed, failed = contrast("tp", "one"), contrast("fp", "one")
    assert placed is not None and failed is not None  # noqa: PT018  # there are experiments
    return PairTest(
        object=part,
        first=first,
        second=second,
        experiments=len(pairs),
        worlds=len(set(worlds)),
        parts=parts,
        mcnemar_p=mcnemar_p(parts),
        share_ci=tango_interval(parts),
        placed=placed,
        failed=failed,
        ap=contrast("tp", "attempts"),
        ar=contrast("tp", "present"),
        cycle_time_s=contrast("duration", "tp"),
    )


def _placed(ones: Sequence[Counted]) -> "list[bool]":
    return [placed for one in ones for placed in one.placed]


def _sums(ones: Sequence[Counted]) -> Mapping[str, list[float]]:
    """Of each experiment, what the figures are ratios of."""
    counts = [one.count for one in ones if one.count is not None]
    return {
        "one": [1.0] * len(counts),
        "tp": [float(count.tp) for count in counts],
        "fp": [float(count.fp) for count in counts],
        "attempts": [float(count.tp + count.fp) for count in counts],
        "present": [float(count.tp + count.fn) for count in counts],
        "duration": [count.duration for count in counts],
    }
