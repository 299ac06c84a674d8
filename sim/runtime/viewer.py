"""MuJoCo's window onto a running world, in real time."""

import atexit
import os
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import glfw
import mujoco
import mujoco.viewer
import numpy as np

from sim.errors import GraphicsError
from sim.runtime.pictures import scenery_of
from sim.runtime.world import World
from sim.scenery.lighting import OVERVIEW

FRAMES_PER_SECOND = 60.0
MAX_DELAY = 0.1  # s that are caught up with, as MuJoCo's own viewer has it; after longer pauses time just goes on
_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
CLOSING_TIME = 5.0  # s of the wall clock that a window may take to go


def has_display() -> bool:
    """Whether there is said to be a screen to open a window on."""
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


class Window:
    """Shows a world; call `show` after every step of it, it waits where physics is ahead of the clock on the wall.

    What is shown is a copy, so that nothing done in the window touches the world.

    Raises:
        GraphicsError: there is no display, or none that shows OpenGL.
    """

    def __init__(self, world: World) -> None:
        _check_display()
        self._world = world
        self._mj_model = scenery_of(world)
        self._data = mujoco.MjData(self._mj_model)
        self._state = np.empty(mujoco.mj_stateSize(world.mj_model, _STATE))
        self._copy()
        before = set(threading.enumerate())
        self._viewer = mujoco.viewer.launch_passive(self._mj_model, self._data, show_left_ui=False, show_right_ui=False)
        self._threads = set(threading.enumerate()) - before
        atexit.register(self.close)  # before GLFW, which the viewer has registered, terminates
        with self._viewer.lock():
            _look_from(self._viewer.cam, self._mj_model, self._data, OVERVIEW)
        self._began = (world.time, time.monotonic())  # when both clocks were together
        self._shown_at = world.time

    def show(self) -> None:
        """Draws the world's state, at most `FRAMES_PER_SECOND` times per second of the cell's clock.

        A window that someone has closed neither draws nor waits.
        """
        now = self._world.time
        is_new = now < self._shown_at  # the world was reset
        if not self._viewer.is_running() or (not is_new and now - self._shown_at < 1.0 / FRAMES_PER_SECOND):
            return
        ahead = now - self._began[0] - (time.monotonic() - self._began[1])
        if is_new or ahead < -MAX_DELAY:
            self._began = (now, time.monotonic())
        else:
            time.sleep(max(0.0, ahead))
        self._shown_at = now
        self._copy()
        self._viewer.sync()

    def _copy(self) -> None:
        """Has what is shown stand as the world does; contacts are found anew."""
        mujoco.mj_getState(self._world.mj_model, self._world.data, self._state, _STATE)
        mujoco.mj_setState(self._mj_model, self._data, self._state, _STATE)
        mujoco.mj_forward(self._mj_model, self._data)

    def close(self) -> None:
        """Closes the window, and waits until it is gone: GLFW must not be left while another thread draws."""
        atexit.unregister(self.close)
        self._viewer.close()
        for thread in self._threads:
            thread.join(CLOSING_TIME)


def _look_from(view: mujoco.MjvCamera, mj_model: mujoco.MjModel, data: mujoco.MjData, camera: str) -> None:
    """Puts the view that the mouse moves where a camera of the model stands, without its roll."""
    fixed = data.camera(camera)
    forward_W = -fixed.xmat.reshape(3, 3)[:, 2]
    view.distance = forward_W @ (mj_model.stat.center - fixed.xpos)
    view.lookat = fixed.xpos + view.distance * forward_W
    view.azimuth = np.degrees(np.arctan2(forward_W[1], forward_W[0]))
    view.elevation = np.degrees(np.arcsin(forward_W[2]))
    mj_model.vis.global_.fovy = mj_model.camera(camera).fovy[0]


def _check_display() -> None:
    """Opens a window that nobody sees: where that fails, MuJoCo's viewer would end the whole process."""
    if not has_display():
        raise GraphicsError(
            "render_mode 'human' opens a window and needs a display, but neither DISPLAY nor WAYLAND_DISPLAY is "
            "set; render_mode 'rgb_array' needs none"
        )
    with ThreadPoolExecutor(1) as apart:  # this thread may hold an EGL context, beside which GLX ends the process
        obstacle = apart.submit(_obstacle).result()
    if obstacle:
        raise GraphicsError(
            "render_mode 'human' opens a window and needs a display with OpenGL, but there is none "
            f"({obstacle}); render_mode 'rgb_array' needs none"
        )


def _obstacle() -> str:
    """What GLFW says is in the way of a window with OpenGL; empty if nothing is."""
    with warnings.catch_warnings(action="ignore", category=glfw.GLFWError):
        window = None
        if glfw.init():
            glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
            window = glfw.create_window(64, 64, "", None, None)
            glfw.default_window_hints()
        if not window:
            reason = glfw.get_error()[1]
            return reason.decode() if isinstance(reason, bytes) else "GLFW gives no reason"
        glfw.destroy_window(window)
    return ""
