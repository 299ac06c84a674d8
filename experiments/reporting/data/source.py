"""A run as the page shows it: its table, and of each experiment what happened, from its units."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from experiments.reporting.data.command_lines import object_of, replay
from experiments.reporting.data.happened import Rows, experiment_of
from experiments.results.provenance import config_as_json
from experiments.units.asked import Asked
from experiments.units.run_folder import RunFolder
from experiments.units.summary import Summary, counted_of, summary_of
from experiments.units.unit import Unit
from sim.errors import SimError
from sim.model.conditions import Conditions
from sim.model.parts import PartModel, load_part

MOST_EXPERIMENTS = 600  # that a page lists: about 12 MB of outlines


@dataclass(slots=True)
class Source:
    """One run; it gathers notes, and pictures into its experiments.

    Attributes:
        name: what the page calls it.
        folder: the run's.
        summary: its table.
        experiments: of those with a result or a failure, what happened, as the page's JSON has it.
        total: how many the run has; more than `experiments` where the page would be too large.
        notes: what cannot be shown, and why.
        pictured: how many items have pictures, in words.
    """

    name: str
    folder: RunFolder
    summary: Summary
    experiments: list[Rows]
    total: int
    notes: list[str] = field(default_factory=list)
    pictured: str = "No attempt was simulated again for pictures."

    @property
    def as_paper(self) -> bool:
        """Whether the experiments were the paper's, so that its figures belong beside them."""
        return all(
            cell.description["cell"]["own_policy"]
            and cell.description["common"]["conditions"] == config_as_json(Conditions())
            for cell in self.folder.asked
        )

    @property
    def thresholds(self) -> dict[tuple[str, str], float]:
        """The u_t,g of each object and method that has one."""
        found = {}
        for cell in self.folder.asked:
            if cell.description["cell"]["u_grasp"] is not None:
                found[cell.of["object"], cell.of["method"]] = cell.description["cell"]["u_grasp"]
        return found


def read_sources(paths: tuple[Path, ...]) -> list[Source]:
    """The runs, each with a name of its own.

    Raises:
        UsageError: a folder holds no run, or a damaged one.
    """
    names = [path.resolve().name for path in paths]
    named = [f"{name}-{place + 1}" if names.count(name) > 1 else name for place, name in enumerate(names)]
    most = MOST_EXPERIMENTS // len(paths)
    return [_read(RunFolder.read(path), name, most) for path, name in zip(paths, named, strict=True)]


def _read(folder: RunFolder, name: str, most: int) -> Source:
    parts, notes = _parts(folder)
    counted, experiments, worlds = [], [], dict[str, dict[str, int]]()
    lowest = _numbers_within(folder, most)
    for unit in folder.units():
        counted.append(counted_of(unit))
        if unit.description["experiment"] < lowest:
            experiments.append(_experiment(unit, folder, parts, worlds))
    if len(experiments) < len(counted):
        notes.append(
            f"Of {len(counted)} experiments the list, the grids and the charts have those with numbers below {lowest}, "
            f"{len(experiments)}; the table has all."
        )
    return Source(name, folder, summary_of(counted), experiments, len(counted), notes)


def _experiment(unit: Unit, folder: RunFolder, parts: dict[str, PartModel], worlds: dict[str, dict[str, int]]) -> Rows:
    options, description = _options(folder, unit), unit.description
    model, named = parts.get(description["of"]["object"]), description["of"]
    rows = experiment_of(unit, None if model is None else model.part)
    own_worlds = worlds.setdefault(named["object"], {})
    rows["w"] = own_worlds.setdefault(str(description["noise"] or description["experiment"]), len(own_worlds))
    own = bool(description["cell"]["own_policy"])
    rows["cmd"] = replay(options, named, description["experiment"], None, own_policy=own)
    return rows


def _options(folder: RunFolder, unit: Unit) -> dict[str, Any]:
    cell = next(cell for cell in folder.asked if tuple(cell.of.values()) == tuple(unit.description["of"].values()))
    return cell.options or folder.options


def _numbers_within(folder: RunFolder, most: int) -> int:
    """The number below which experiments are shown, so that all methods show the same ones."""
    return max(1, most // max(1, len(folder.asked)))


def _parts(folder: RunFolder) -> tuple[dict[str, PartModel], list[str]]:
    """The kinds of parts by name; notes on those whose shape is not known here any more."""
    found: dict[str, PartModel] = {}
    notes: list[str] = []
    for cell in folder.asked:
        name = cell.of["object"]
        if name in found or any(note.startswith(f"{name}:") for note in notes):
            continue
        try:
            found[name] = _part(cell, folder)
        except SimError as error:
            notes.append(f"{name}: masks and silhouettes are not drawn, since its file cannot be read: {error}")
    return found, notes


def _part(cell: Asked, folder: RunFolder) -> PartModel:
    return load_part(object_of(cell.options or folder.options, cell.of["object"]))


def cells_by_object(source: Source) -> Iterator[tuple[str, list[Any]]]:
    """The cells of the table, part by part."""
    for name in dict.fromkeys(cell.object for cell in source.summary.cells):
        yield name, [cell for cell in source.summary.cells if cell.object == name]
