"""Adds pictures to the attempts that a page shows, as many as were asked for and as fit."""

from collections.abc import Sequence
from dataclasses import dataclass

from experiments.errors import UsageError
from experiments.progress import counted
from experiments.reading.resimulation import Choice, finished
from experiments.reporting.data.happened import Rows
from experiments.reporting.data.source import Source
from experiments.reporting.pictures.choice import by_experiment, chosen
from experiments.reporting.pictures.take import Task, take_pictures
from experiments.units.summary import of

MOST_BYTES = 24_000_000  # of all pictures: with all else a page then stays below 30 MB
_PICTURES = ("wrist", "overview", "gripper")


@dataclass(frozen=True, slots=True)
class Asked:
    """How many pictures are wanted.

    Attributes:
        most: attempts and time-outs to picture.
        jobs: worker processes.
        needed: whether it is an error if a run cannot be simulated again; the page says so otherwise.
    """

    most: int
    jobs: int
    needed: bool


def illustrate(sources: Sequence[Source], asked: Asked) -> None:
    """Adds the pictures to the items of the sources, and notes on what is missing.

    Raises:
        UsageError: an experiment came to something else than before; or a run cannot be simulated again, if needed.
    """
    room = MOST_BYTES
    for place, source in enumerate(sources):
        share = asked.most // len(sources) + (place < asked.most % len(sources))
        try:
            tasks, experiments = _tasks(source, share)
        except UsageError as error:
            if asked.needed:
                raise
            source.notes.append(f"No pictures and no true poses of {source.name}: {error}")
            continue
        room = _take(source, tasks, experiments, asked.jobs, room)


def _tasks(source: Source, most: int) -> tuple[list[Task], list[Rows]]:
    """What is to be simulated again, and the experiments that the pictures go to."""
    wanted = by_experiment(chosen(source.experiments, most))
    if not wanted:
        return [], []
    keys = {_key(source.experiments[number]): number for number in wanted}
    numbers = tuple(sorted({source.experiments[number]["e"] for number in wanted}))
    _, pairs = finished(source.folder, Choice(experiments=numbers))
    tasks, experiments = [], []
    for spec, unit in pairs:
        number = keys.get((*of(unit.description), unit.description["experiment"]))
        if number is not None:
            items = source.experiments[number]["items"]
            tasks.append(Task(spec, unit, {item: items[item] for item in wanted[number]}))
            experiments.append(source.experiments[number])
    return tasks, experiments


def _take(source: Source, tasks: Sequence[Task], experiments: Sequence[Rows], jobs: int, room: int) -> int:
    """Takes the pictures while there is room for them; returns how many bytes are left."""
    total = left_out = 0
    without = set()
    shown = counted(take_pictures(tasks, jobs), "experiment", "pictures", len(tasks))
    for experiment, made in zip(experiments, shown, strict=True):
        if made.without is not None:
            without.add(made.without)
        for number, row in made.items.items():
            size = sum(len(row.get(name, "")) for name in _PICTURES)
            if size > room:
                left_out += 1
                row = {name: value for name, value in row.items() if name not in _PICTURES}  # noqa: PLW2901
            else:
                room -= size
            experiment["items"][number] |= row
            total += 1
    source.notes += [f"No wrist pictures and no overviews: {reason}" for reason in sorted(without)]
    if left_out:
        source.notes.append(f"{left_out} of {total} pictures were left out, since the page would be larger than 30 MB.")
    listed = sum(len(one["items"]) for one in source.experiments)
    source.pictured = f"{total} of {listed} attempts and time-outs were simulated again, bit for bit, for pictures."
    return room


def _key(experiment: Rows) -> tuple[str, str, str, int]:
    return experiment["o"], experiment["m"], experiment["p"], experiment["e"]
