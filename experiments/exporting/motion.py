"""What the robot did in an experiment, sampled at equal times: measured, told, and seen."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from experiments.exporting.mp4 import Mp4
from sim.runtime.pictures import Pictures
from sim.runtime.world import World

Interval = tuple[float, float]  # s: its begin, and its end, which does not belong to it


@dataclass(slots=True, eq=False)
class Motion:
    """Samples of an experiment, S of them.

    Attributes:
        times: s of the cell's clock, S.
        measured: joint angles (rad) and the jaws' half opening (m), S times (7,).
        told: what the servos were told last, likewise.
    """

    times: list[float] = field(default_factory=list)
    measured: list[NDArray[np.float64]] = field(default_factory=list)
    told: list[NDArray[np.float64]] = field(default_factory=list)

    def within(self, interval: Interval) -> NDArray[np.intp]:
        """Numbers of the samples in an interval of time."""
        times = np.array(self.times)
        return np.flatnonzero((times >= interval[0]) & (times < interval[1]))

    def goals(self) -> NDArray[np.float64]:
        """What the servos are told by the next sample, (S, 7): the action from this sample to that one."""
        return np.array([*self.told[1:], self.told[-1]])


@contextmanager
def sampled(world: World, fps: int, see: Callable[[float], None] | None = None) -> Iterator[Motion]:
    """Samples the world as its time passes in the block.

    Args:
        world: the cell.
        fps: samples per second; divides the steps per second.
        see: is called at each sample with its time, s.
    """
    motion, stride = Motion(), round(1.0 / (fps * world.time_step))

    def on_step() -> None:
        step = round(world.time / world.time_step)
        if step % stride == 0:
            motion.times.append(step / stride / fps)
            motion.measured.append(np.array([*world.q, world.jaw_half_opening]))
            motion.told.append(np.array([*world.q_told, world.jaws_told]))
            if see is not None:
                see(motion.times[-1])

    before, world.on_step = world.on_step, on_step
    try:
        yield motion
    finally:
        world.on_step = before


class Filming:
    """Adds a picture of each camera to its video, within intervals of time.

    Args:
        pictures: of the world.
        videos: by the name of the camera.
        intervals: when to film.
        keep: is given each camera's name and picture.
    """

    def __init__(
        self,
        pictures: Pictures,
        videos: Mapping[str, Mp4],
        intervals: Sequence[Interval],
        keep: Callable[[str, NDArray[np.uint8]], None],
    ) -> None:
        self._pictures, self._videos = pictures, videos
        self._intervals, self._keep = intervals, keep

    def __call__(self, time: float) -> None:
        """Films the moment, if it lies in an interval."""
        if any(begin <= time < end for begin, end in self._intervals):
            for camera, video in self._videos.items():
                rgb = self._pictures.rgb(camera)
                video.add(rgb)
                self._keep(camera, rgb)
