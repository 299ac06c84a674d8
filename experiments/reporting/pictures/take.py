"""Pictures of looks and attempts, by simulating their experiments again, bit for bit."""

import base64
from collections.abc import Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.part import Part
from cell.records import DecisionRecord
from experiments.reading.resimulation import resimulate
from experiments.reporting.data.happened import Rows
from experiments.reporting.data.shapes import silhouette_outline
from experiments.setup.experiment import ExperimentSpec, kept_cell
from experiments.setup.pool import run_all
from experiments.units.unit import Unit
from sim.errors import GraphicsError
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.runtime.film import Film
from sim.runtime.pictures import Pictures
from sim.runtime.world import World

_OVERVIEW = 360, 480  # px: height and width
_SAMPLES = 4
_QUALITY = 62  # of JPEG: below 60, edges of masks and parts blur


@dataclass(frozen=True, slots=True, eq=False)
class Task:
    """An experiment to simulate again, and which of its items get pictures.

    Attributes:
        spec: the experiment.
        unit: what it came to.
        items: as the page has them, by their number in the experiment.
    """

    spec: ExperimentSpec
    unit: Unit
    items: Mapping[int, Rows]


@dataclass(frozen=True, slots=True, eq=False)
class Pictured:
    """What is added to the items of an experiment.

    Attributes:
        items: by number, `truth`, the outline at the true pose; with OpenGL `wrist`, `overview`, `moment` and, of an
            attempt that came to the part, `gripper`.
        without: why there are no pictures; None if there are.
    """

    items: Mapping[int, Rows]
    without: str | None


def take_pictures(tasks: Sequence[Task], jobs: int) -> Generator[Pictured, None, None]:
    """Simulates experiments again and takes their pictures, in the order of the tasks.

    Raises:
        UsageError: an experiment came to something else than before.
    """
    return run_all(pictured, tasks, jobs)


def pictured(task: Task) -> Pictured:
    """The pictures of one experiment.

    Raises:
        UsageError: it came to something else than before.
    """
    cell, film, truths = kept_cell(*task.spec.cell), Film(), dict[int, FrameTruth]()
    frames = {item["f"] for item in task.items.values()}

    def tell(record: object, latest_truth: LatestTruth) -> None:
        if isinstance(record, DecisionRecord) and record.observation.frame.index in frames:
            truths[record.observation.frame.index] = latest_truth.of(record.observation.frame)

    with film.recording(cell.world):
        resimulate(task.spec, task.unit, tell, cell)
    part = cell.world.part_model.part
    found = {number: _truth(item, truths[item["f"]], part) for number, item in task.items.items()}
    try:
        shown = _photographed(task, film, cell.world)
    except GraphicsError as error:
        return Pictured(found, str(error))
    return Pictured({number: {**row, **shown[number]} for number, row in found.items()}, None)


def _truth(item: Rows, truth: FrameTruth, part: Part) -> Rows:
    """The outline of the part that the detection shows, where it truly is."""
    if item["part"] is None:
        return {}
    return {"truth": silhouette_outline(part, truth.X_CO_true[item["part"]], truth.camera)}


def _photographed(task: Task, film: Film, world: World) -> dict[int, Rows]:
    """The wrist picture at the look, and the overview and the gripper's close-up at the grasp of each item."""
    camera, times = world.layout.camera, {row["frame"]: row["time_s"] for row in task.unit.tables["frames"]}
    moments = {number: moment(item, task.unit.tables["transitions"]) for number, item in task.items.items()}
    shown: dict[int, Rows] = {number: {"moment": one.told} for number, one in moments.items()}
    with closing(Pictures(world, camera.height, camera.width, _SAMPLES)) as pictures:
        for number, item in task.items.items():
            shown[number]["wrist"] = _as_uri(pictures.rgb("wrist", film.at(times[item["f"]])))
    with closing(Pictures(world, *_OVERVIEW, _SAMPLES)) as pictures:
        for number, one in moments.items():
            shown[number]["overview"] = _as_uri(pictures.rgb("overview", film.at(one.time)))
            if one.is_grasp:
                shown[number]["gripper"] = _as_uri(pictures.close_up(film.at(one.time)))
    return shown


class Moment(NamedTuple):
    """When an item is decided.

    Attributes:
        time: s.
        told: what happens then, in words.
        is_grasp: whether the gripper is at the part: closed, or stopped by a contact.
    """

    time: float
    told: str
    is_grasp: bool


def moment(item: Rows, transitions: Sequence[Rows]) -> Moment:
    """When an attempt is decided, and what happens then: a contact, the end of closing, or the end.

    Args:
        item: as the page has it.
        transitions: of its experiment.
    """
    if item["k"] == "time-out":
        return Moment(item["z"], f"at {item['z']:.1f} s, when the time ran out", False)
    if item["hit"] is not None:
        return Moment(item["hit"], f"at {item['hit']:.1f} s, {item['force']:.0f} N on the {item['touch']}", True)
    for row in transitions:
        if row["source"] == "close" and item["b"] <= row["time_s"] <= item["z"]:
            return Moment(row["time_s"], f"at {row['time_s']:.1f} s, {row['reason']}", True)
    return Moment(item["z"], f"at {item['z']:.1f} s, at the end", False)


def _as_uri(image: NDArray[np.uint8]) -> str:
    """A picture, (H, W, 3) RGB, as the address of itself."""
    _, packed = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(packed.tobytes()).decode("ascii")
