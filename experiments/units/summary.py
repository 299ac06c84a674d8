"""From a run's units to its table and logs."""

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.results.counted import Counted, Of, parts_placed
from experiments.results.pair_tests import PairTest, letters, pair_tests
from experiments.results.paired import Paired, pair
from experiments.results.store import SCHEMAS, LogWriter
from experiments.results.table import Cell, make_cell
from experiments.units.asked import Asked
from experiments.units.identity import Description
from experiments.units.run_folder import RunFolder
from experiments.units.unit import Unit


@dataclass(frozen=True, slots=True)
class Summary:
    """A run's table, and the experiments that it was made of."""

    experiments: tuple[Counted, ...]
    cells: tuple[Cell, ...]
    pairs: tuple[Paired, ...]
    tests: tuple[PairTest, ...]

    @property
    def completed(self) -> int:
        """How many experiments have a result."""
        return sum(one.count is not None for one in self.experiments)

    @property
    def failures(self) -> tuple[Counted, ...]:
        """Those that have none."""
        return tuple(one for one in self.experiments if one.count is None)


def summarise(folder: RunFolder) -> Summary:
    """The table of all experiments in a folder; writes their logs there, one experiment in memory at a time."""
    counted = []
    with LogWriter(folder.path, folder.units_digest()) as logs:
        for unit in folder.units():
            logs.write({name: unit.tables.get(name, []) for name in SCHEMAS})
            counted.append(counted_of(unit))
    return summary_of(counted)


def counted_of(unit: Unit) -> Counted:
    """What the table needs of a unit."""
    description = unit.description
    return Counted(
        of=of(description),
        experiment=description["experiment"],
        world=_world(description["noise"], description["experiment"]),
        count=unit.count,
        first=unit.first,
        placed=() if unit.count is None else parts_placed(unit.tables, unit.count.parts),
        failure=unit.failure,
    )


def of(description: Description) -> Of:
    """Object, method and policy of a description."""
    named = description["of"]
    return named["object"], named["method"], named["policy"]


def _world(noise: Iterable[Sequence[Any]], experiment: int) -> Hashable:
    return tuple(map(tuple, noise)) or experiment


def summary_of(counted: Sequence[Counted]) -> Summary:
    """The table of experiments, in their order."""
    tests = pair_tests(counted)
    same = letters(tests, counted)
    cells = [replace(cell, same=same.get((cell.object, cell.method, cell.policy))) for cell in make_cells(counted)]
    return Summary(tuple(counted), tuple(cells), tuple(make_pairs(counted)), tuple(tests))


def make_cells(counted: Sequence[Counted]) -> list[Cell]:
    """One cell per object, method and policy, in the order in which they come."""
    groups: dict[Of, list[Counted]] = {}
    for one in counted:
        groups.setdefault(one.of, []).append(one)
    return [
        make_cell(
            of,
            [one.count for one in group],
            [one.world for one in group],
            [one.first for one in group],
        )
        for of, group in groups.items()
    ]


def make_pairs(counted: Sequence[Counted]) -> list[Paired]:
    """Every method and policy compared with the reference, object by object, over the experiments that both have.

    Experiments with the same error model of a domain gap are not independent: they form a group.
    """
    pairs = []
    for part in dict.fromkeys(one.of[0] for one in counted):
        own = [one for one in counted if one.of[0] == part]
        worlds: dict[Hashable, list[int]] = {}
        for one in own:
            numbers = worlds.setdefault(one.world, [])
            if one.experiment not in numbers:
                numbers.append(one.experiment)
        counts = {(one.of[1:], one.experiment): one.count for one in own}
        pairs += pair(
            part,
            {
                who: [[counts.get((who, number)) for number in numbers] for numbers in worlds.values()]
                for who in dict.fromkeys(one.of[1:] for one in own)
            },
        )
    return pairs


def thresholds_of(asked: Iterable[Asked]) -> dict[str, dict[str, float]]:
    """The u_t,g in use, by object and method."""
    found: dict[str, dict[str, float]] = {}
    for cell in asked:
        u_grasp = cell.description["cell"]["u_grasp"]
        if u_grasp is not None:
            found.setdefault(cell.of["object"], {})[cell.of["method"]] = u_grasp
    return found


def caveats_of(asked: Iterable[Asked]) -> list[str]:
    """A line for each u_t,g that was neither given nor derived by the rule of the others."""
    lines = [
        f"{cell.of['object']} × {cell.of['method']}: u_t,g = {cell.description['cell']['u_grasp']:.3f}: "
        f"{cell.description['cell']['caveat']}"
        for cell in asked
        if cell.description["cell"]["caveat"] is not None
    ]
    return list(dict.fromkeys(lines))
