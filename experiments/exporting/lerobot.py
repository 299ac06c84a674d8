"""A run as a LeRobot dataset: an episode for each time slot, in which the robot is to fetch one part."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.exporting.lerobot_files import CAMERAS, SIZE, LeRobotFiles, Numbers, video_file
from experiments.exporting.motion import Filming, Motion, sampled
from experiments.exporting.mp4 import Mp4, check_av, opened_mp4
from experiments.reading.resimulation import resimulate
from experiments.setup.experiment import ExperimentSpec, kept_cell
from experiments.units.unit import Unit
from sim.runtime.pictures import Pictures
from sim.runtime.world import World

_EVERY_S = 1.0  # of the pictures that statistics are made of
_COARSER = 4  # pixels that such a picture leaves out per pixel and side


def export_lerobot(out: Path, pairs: Iterable[tuple[ExperimentSpec, Unit]], *, fps: int, rgb: bool) -> str:
    """Writes the dataset; returns what it holds, in words.

    Args:
        out: an empty folder.
        pairs: the experiments, each with its unit.
        fps: frames per second of the cell's clock.
        rgb: whether to film with the wrist camera and from beside the cell.

    Raises:
        UsageError: PyAV is missing, or an experiment does not come to the same again; the dataset is then not whole.
        GraphicsError: there is no OpenGL to film with.
    """
    if rgb:
        check_av()
    files = LeRobotFiles(out, fps, videos=rgb)
    for number, (spec, unit) in enumerate(pairs):
        _add_experiment(files, number, spec, unit, rgb=rgb)
    files.finish()
    return f"{files.episodes} episodes with {files.frames} frames"


@dataclass(slots=True, eq=False)
class _Seen:
    """Some of the pictures that were filmed, coarser, by the camera and the number of the frame in its video."""

    every: int
    count: dict[str, int] = field(default_factory=lambda: defaultdict(int))
    pictures: dict[str, dict[int, NDArray[np.uint8]]] = field(default_factory=lambda: defaultdict(dict))

    def __call__(self, camera: str, rgb: NDArray[np.uint8]) -> None:
        if self.count[camera] % self.every == 0:
            self.pictures[camera][self.count[camera]] = rgb[::_COARSER, ::_COARSER].copy()
        self.count[camera] += 1

    def of(self, camera: str, frames: range) -> list[NDArray[np.uint8]]:
        """Those of an episode's frames; the one before them if there is none."""
        kept = self.pictures[camera]
        return [kept[number] for number in frames if number in kept] or [kept[max(n for n in kept if n < frames.stop)]]


def _add_experiment(files: LeRobotFiles, number: int, spec: ExperimentSpec, unit: Unit, *, rgb: bool) -> None:
    world, slots, seen = kept_cell(*spec.cell).world, unit.tables["slots"], _Seen(round(_EVERY_S * files.fps))
    intervals = [(slot["start_s"], slot["end_s"]) for slot in slots]
    with ExitStack() as stack:
        see = None
        if rgb:
            pictures, videos = stack.enter_context(_filmed(files, number, world))
            see = Filming(pictures, videos, intervals, seen)
        motion = stack.enter_context(sampled(world, files.fps, see))
        resimulate(spec, unit)
    files.begin(number)
    goals, first = motion.goals(), 0
    of = {name: unit.description["of"][name] for name in ("object", "method", "policy")}
    for slot, interval in zip(slots, intervals, strict=True):
        chosen = motion.within(interval)
        if not len(chosen):
            continue
        frames = range(first, first := first + len(chosen))
        files.add_episode(
            _numbers(motion, goals, chosen, placed=slot["outcome"] == "placed"),
            {camera: seen.of(camera, frames) for camera in seen.count},
            f"pick one {of['object']} from the belt and place it in the container",
            {**of, "experiment": spec.experiment, "slot": slot["slot"], "outcome": slot["outcome"]},
        )
    files.end()


@contextmanager
def _filmed(files: LeRobotFiles, number: int, world: World) -> Iterator[tuple[Pictures, dict[str, Mp4]]]:
    """What takes pictures of the world, and the videos of an experiment by the name of their camera."""
    width, height = SIZE
    pictures = Pictures(world, height, width, samples=1)
    try:
        with ExitStack() as stack:
            paths = {camera: files.folder / video_file(key, number) for camera, key in CAMERAS.items()}
            opened = {camera: opened_mp4(path, width, height, files.fps) for camera, path in paths.items()}
            yield pictures, {camera: stack.enter_context(one) for camera, one in opened.items()}
    finally:
        pictures.close()


def _numbers(motion: Motion, goals: NDArray[np.float64], chosen: NDArray[np.intp], *, placed: bool) -> Numbers:
    """The features of an episode's frames that are numbers."""
    last = np.arange(len(chosen)) == len(chosen) - 1
    return {
        "observation.state": np.array(motion.measured)[chosen],
        "action": goals[chosen],
        "next.done": last,
        "next.success": last & placed,
    }
