"""`graspcell plan`: how many experiments an answer takes, by the scatter of a pilot run."""

# ruff: noqa: PLC0415  # the statistics are loaded when the job begins: --help does not wait for them

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from experiments.errors import UsageError

if TYPE_CHECKING:
    from experiments.results.counted import Counted
    from experiments.statistics.until import Condition

_CAUTION = 0.8  # confidence of the upper end of a pilot's scatter


@dataclass(frozen=True)
class Plan:
    """Say how many experiments it takes to answer conditions, by the scatter between worlds in a pilot run.

    A condition compares a method with another one or with a bound: "placed(maskval) > placed(none)",
    "ap(maskval) >= 0.99"; ap, ar, placed and failed are figures of an experiment.
    """

    run: Annotated[Path, tyro.conf.Positional]
    """Folder of the pilot, as compare writes it."""
    conditions: Annotated[tuple[str, ...], tyro.conf.Positional]
    """What is to be answered."""
    wanted: float | None = None
    """Difference to be found, in the unit of the condition; by default the pilot's, which a lucky pilot overstates."""
    power: float = 0.8
    """Chance to find it, or to show the bound, above 0.05 and below 1."""

    def check(self) -> None:
        """Rejects what cannot be.

        Raises:
            UsageError: says what, and what is valid.
        """
        if not self.conditions:
            raise UsageError('expected at least one condition such as "ap(maskval) >= 0.99", got none')
        if not 0.05 < self.power < 1:
            raise UsageError(f"expected --power above 0.05 and below 1, got {self.power:g}")
        if self.wanted is not None and not 0 < self.wanted <= 8:
            raise UsageError(f"expected --wanted above 0 and at most 8, got {self.wanted:g}")


def plan(config: Plan) -> int:
    """Prints a plan for every condition and object; returns the exit code.

    Raises:
        UsageError: an invalid argument, or a pilot that cannot tell.
    """
    from experiments.progress import saying
    from experiments.statistics.until import parse_condition
    from experiments.units.run_folder import RunFolder
    from experiments.units.summary import counted_of

    config.check()
    folder = RunFolder.read(config.run)
    counted = [counted_of(unit) for unit in folder.units()]
    objects = list(dict.fromkeys(one.of[0] for one in counted))
    for text in config.conditions:
        condition = parse_condition(text)
        if condition.part is not None and condition.part not in objects:
            raise UsageError(f'expected an object of {", ".join(objects)} in "{text}", got {condition.part}')
        for part in [condition.part] if condition.part is not None else objects:
            print(f"{part}: {text}", flush=True)
            with saying("plan"):
                told = _plan(config, condition, _by_method(counted, part), _worlds(folder.options, part))
            for line in told:
                print(f"  {line}")
    return 0


def _by_method(counted: "Sequence[Counted]", part: str) -> "dict[str, dict[int, Counted]]":
    """The experiments with a result, by method and number."""
    found: dict[str, dict[int, Counted]] = {}
    for one in counted:
        if one.of[0] == part and one.count is not None:
            own = found.setdefault(one.of[1], {})
            if one.experiment in own:
                raise UsageError(f"expected a pilot with one policy for {one.of[1]}, got several")
            own[one.experiment] = one
    return found


def _worlds(options: Mapping[str, object], part: str) -> int | None:
    """How many error models experiments have in turn; None if each has its own."""
    from experiments.setup.actors import Actors
    from sim.model.parts import load_part

    actors = options.get("actors")
    gap = actors.get("gap", "none") if isinstance(actors, dict) else "none"
    names = options.get("objects")
    for name in names if isinstance(names, list) else ():
        if gap != "none" and load_part(name).part.name == part:
            return len({Actors(gap=gap).noise(name, number) for number in range(1000)})
    return None


def _plan(
    config: Plan, condition: "Condition", methods: "Mapping[str, Mapping[int, Counted]]", worlds: int | None
) -> list[str]:
    for name in (condition.method, condition.other):
        if name is not None and name not in methods:
            raise UsageError(f"expected a method of the pilot, {', '.join(methods)}, got {name}")
    if condition.other is None:
        return _plan_bound(config, condition, list(methods[condition.method].values()), worlds)
    both = [
        (one, methods[condition.other][number])
        for number, one in methods[condition.method].items()
        if number in methods[condition.other]
    ]
    return _plan_difference(config, condition, both, worlds)


def _plan_difference(
    config: Plan, condition: "Condition", both: "Sequence[tuple[Counted, Counted]]", worlds: int | None
) -> list[str]:
    from experiments.statistics.pilot import measure_pilot
    from experiments.statistics.planning import plan_difference

    figure = _figure(condition)
    groups: dict[Hashable, list[float]] = {}
    for ours, theirs in both:
        a, b = figure(ours), figure(theirs)
        if a is not None and b is not None:
            groups.setdefault(ours.world, []).append(a - b)
    if len(groups) < 2:
        raise UsageError(f"expected a pilot of at least two worlds with a result of both, got {len(groups)}")
    pilot = measure_pilot(list(groups.values()))
    told = [
        f"pilot: {pilot.experiments} experiments in {pilot.worlds} worlds, difference {pilot.mean:+.3f}, "
        f"standard deviation {pilot.total**0.5:.3f}"
    ]
    wanted = config.wanted if config.wanted is not None else abs(pilot.mean)
    if pilot.total <= 0 or wanted == 0:
        return [*told, "it does not vary, or has no difference: a larger pilot, or --wanted, is needed"]
    repeated = worlds if worlds is not None and pilot.within is not None else None
    for name, scatter in (("with its scatter", pilot), ("with the upper end of its scatter", pilot.cautious(_CAUTION))):
        found = plan_difference(scatter, wanted, config.power, worlds=repeated)
        what = f"to find {wanted:.3f} with a power of {100 * config.power:.0f} % {name}"
        if found.experiments is None:
            told.append(f"{what}: no number over {found.worlds} worlds; the power is {100 * found.power:.0f} % at most")
        else:
            told.append(f"{what}: {found.experiments} experiments")
    if worlds is not None and repeated is None:
        told.append(f"there are {worlds} worlds that repeat; a pilot with two experiments of one would count with that")
    return told


def _plan_bound(config: Plan, condition: "Condition", ones: "Sequence[Counted]", worlds: int | None) -> list[str]:
    from experiments.statistics.pilot import correlation_within
    from experiments.statistics.planning import plan_bound

    if condition.quantity not in ("ap", "ar") or not condition.above or condition.bound is None:
        raise UsageError("expected a bound on ap or ar from below, such as ap(maskval) >= 0.99")
    counts = [one.count for one in ones if one.count is not None]
    hits = [count.tp for count in counts]
    trials = [count.tp + (count.fp if condition.quantity == "ap" else count.fn) for count in counts]
    if not sum(trials):
        raise UsageError(f"expected a pilot in which {condition.method} has attempts, got none")
    rate, correlation = sum(hits) / sum(trials), correlation_within(hits, trials)
    each = sum(trials) / len(trials)
    told = [
        f"pilot: {sum(hits)} of {sum(trials)} in {len(trials)} experiments, correlation within them {correlation:.2f}"
    ]
    for expected in dict.fromkeys((rate, 1.0)):
        what = f"to show it with a power of {100 * config.power:.0f} % if the true rate is {expected:.3f}"
        if expected <= condition.bound:
            told.append(f"{what}: no number, since that is not above the bound")
            continue
        try:
            found = plan_bound(
                *(condition.bound, expected, max(1.0, each), correlation),
                power=config.power,
                confidence=0.975,
                worlds=worlds,
            )
        except ValueError as error:
            told.append(f"{what}: {error}")
            continue
        alone = f"{found.attempts} attempts with {found.failures} failures at most if they were independent"
        if found.experiments is None:
            told.append(f"{what}: no number over {worlds} worlds; {alone}")
        else:
            told.append(f"{what}: {found.experiments} experiments; {alone}")
    return told


def _figure(condition: "Condition") -> "Callable[[Counted], float | None]":
    """The quantity of an experiment with a result."""

    def figure(one: "Counted") -> float | None:
        count = one.count
        assert count is not None  # failed experiments are left out
        return {"ap": count.ap, "ar": count.ar, "placed": float(count.tp), "failed": float(count.fp)}[
            condition.quantity
        ]

    return figure
