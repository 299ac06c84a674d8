"""Videos of an environment that show what happens between two decisions, too."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium.wrappers import RecordVideo
from numpy.typing import NDArray

from sim.runtime.world import World

FRAMES_PER_SECOND = 10  # of the cell's clock and of the video: an experiment of 90 s fills 830 MB until it is written


class RecordMotion(RecordVideo):
    """Gymnasium's `RecordVideo` in real time, with pictures between the steps; needs the extra graspcell[record].

    Args:
        env: one of this package's, made with render_mode="rgb_array".
        video_folder: where the videos go to.
        fps: pictures per second of the cell's clock, and of the video.
        options: those of `RecordVideo`; `video_length` counts pictures.
    """

    def __init__(
        self, env: gymnasium.Env[Any, Any], video_folder: str, fps: int = FRAMES_PER_SECOND, **options: Any
    ) -> None:
        super().__init__(env, video_folder, fps=fps, **options)

    def _capture_frame(self) -> None:
        """Gymnasium's method, which takes one picture after each step."""
        self.recorded_frames += self.env.unwrapped.frames(self.frames_per_sec)  # type: ignore[attr-defined]


class Notes:
    """Where everything was, so many times a second of a world's clock, since somebody last asked."""

    def __init__(self, world: World, per_second: float) -> None:
        self._world, self._interval, self._shown = world, 1.0 / per_second, world.on_step
        self._next = world.time + self._interval
        self._positions: list[NDArray[np.float32]] = []
        world.on_step = self._note

    def take(self) -> list[NDArray[np.float32]]:
        """The positions of the joints, oldest first; forgets them."""
        taken, self._positions = self._positions, []
        return taken

    def _note(self) -> None:
        if self._shown is not None:
            self._shown()
        now = self._world.time
        if now < self._next - 2.0 * self._interval:  # the world was reset
            self._positions, self._next = [], now
        if now >= self._next:
            self._positions.append(self._world.data.qpos.astype(np.float32))
            self._next += self._interval
