"""MuJoCo's window onto a running world, in real time."""

import os
import sys
import time

import mujoco.viewer

from sim.errors import GraphicsError
from sim.world import World

FRAMES_PER_SECOND = 60.0


def has_display() -> bool:
    """Whether there is a screen to open a window on."""
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


class Window:
    """Shows a world; call `show` after every step of it, it waits where physics is ahead of the clock on the wall.

    Raises:
        GraphicsError: there is no display.
    """

    def __init__(self, world: World) -> None:
        if not has_display():
            raise GraphicsError(
                "render_mode 'human' opens a window and needs a display, but neither DISPLAY nor WAYLAND_DISPLAY is "
                "set; render_mode 'rgb_array' needs none"
            )
        self._world = world
        self._viewer = mujoco.viewer.launch_passive(world.model, world.data)
        self._shown_at = (world.time, time.monotonic())

    def show(self) -> None:
        """Draws the world's state, at most `FRAMES_PER_SECOND` times per second of the cell's clock."""
        ahead = self._world.time - self._shown_at[0]
        if 0.0 <= ahead < 1.0 / FRAMES_PER_SECOND:
            return
        time.sleep(max(0.0, self._shown_at[1] + ahead - time.monotonic()))
        self._shown_at = (self._world.time, time.monotonic())
        self._viewer.sync()

    def close(self) -> None:
        """Closes the window."""
        self._viewer.close()
