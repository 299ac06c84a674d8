"""The window without a screen: a viewer that only counts, and a clock that only adds up what is waited for."""

from collections.abc import Iterator
from contextlib import nullcontext
from typing import Any

import mujoco
import numpy as np
import pytest

from sim.errors import GraphicsError
from sim.model.parts import PartModel
from sim.runtime.viewer import Window
from sim.runtime.world import World
from tests.sim.conftest import on_belt, standing


class Clock:
    """Stands in for the module `time`."""

    def __init__(self) -> None:
        self.now = 1000.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds


class Viewer:
    """Stands in for MuJoCo's handle."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, **_: Any) -> None:
        self.model, self.data, self.cam = model, data, mujoco.MjvCamera()
        self.frames, self.is_open = 0, True

    def lock(self) -> Any:
        return nullcontext()

    def is_running(self) -> bool:
        return self.is_open

    def sync(self) -> None:
        self.frames += 1

    def close(self) -> None:
        self.is_open = False


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr("sim.runtime.viewer.time", clock)
    monkeypatch.setattr("sim.runtime.viewer._check_display", lambda: None)
    monkeypatch.setattr("mujoco.viewer.launch_passive", Viewer)
    return clock


@pytest.fixture
def world(antenna: PartModel, antenna_world: World) -> World:
    x = antenna_world.layout.belt.center_x
    antenna_world.reset([on_belt(antenna, x, y, standing(antenna)) for y in (0.3, -0.3)])
    return antenna_world


@pytest.fixture
def window(world: World, clock: Clock) -> Iterator[Window]:
    window = Window(world)
    yield window
    window.close()


def viewer_of(window: Window) -> Viewer:
    viewer: Any = window._viewer
    assert isinstance(viewer, Viewer)
    return viewer


def one_second(window: Window, world: World, clock: Clock, *, cost: float = 0.0) -> float:
    """Steps through a second of the cell, each step at a cost of the wall's clock; how long it took there."""
    began = clock.now
    for _ in range(round(1.0 / world.time_step)):
        world.step()
        clock.now += cost
        window.show()
    return clock.now - began


def test_a_second_takes_a_second_in_at_most_60_frames(window: Window, world: World, clock: Clock) -> None:
    assert one_second(window, world, clock) == pytest.approx(1.0, abs=1 / 50)
    assert 50 <= viewer_of(window).frames <= 60


def test_what_the_computing_costs_is_waited_less(window: Window, world: World, clock: Clock) -> None:
    assert one_second(window, world, clock, cost=0.9 * world.time_step) == pytest.approx(1.0, abs=1 / 50)


def test_a_short_delay_is_made_up_for_and_a_pause_is_not_hurried_after(
    window: Window, world: World, clock: Clock
) -> None:
    clock.now += 0.05
    assert one_second(window, world, clock) == pytest.approx(0.95, abs=1 / 50)
    clock.now += 10.0
    assert one_second(window, world, clock) == pytest.approx(1.0, abs=1 / 50)


def test_a_reset_world_is_shown_from_its_beginning(window: Window, world: World, clock: Clock) -> None:
    one_second(window, world, clock)
    frames = viewer_of(window).frames
    world.reset([world.X_WO(0), world.X_WO(1)])
    assert one_second(window, world, clock) == pytest.approx(1.0, abs=1 / 50)
    assert viewer_of(window).frames - frames >= 50


def test_a_window_that_someone_closed_neither_draws_nor_waits(window: Window, world: World, clock: Clock) -> None:
    viewer_of(window).close()
    assert one_second(window, world, clock) == 0.0
    assert viewer_of(window).frames == 0


def test_the_window_shows_a_copy_that_nothing_leads_back_from(window: Window, world: World, clock: Clock) -> None:
    viewer = viewer_of(window)
    one_second(window, world, clock)
    assert 0.0 <= world.time - viewer.data.time < 1 / 50  # the newest frame
    before, gravity = world.data.qpos.copy(), world.mj_model.opt.gravity.copy()
    viewer.data.qpos[:] = 0.0
    viewer.model.opt.gravity[:] = 0.0
    assert np.array_equal(world.data.qpos, before)
    assert np.array_equal(world.mj_model.opt.gravity, gravity)
    assert before.any()
    assert gravity.any()


def test_the_first_view_is_the_overviews(window: Window, world: World) -> None:
    viewer, scene = viewer_of(window), mujoco.MjvScene(world.mj_model, 1000)
    overview = viewer.data.camera("overview")
    mujoco.mjv_updateCamera(viewer.model, viewer.data, viewer.cam, scene)
    eyes = scene.camera  # for stereo, 68 mm apart
    assert (eyes[0].pos + eyes[1].pos) / 2 == pytest.approx(overview.xpos, abs=1e-3)
    assert eyes[0].forward == pytest.approx(-overview.xmat.reshape(3, 3)[:, 2], abs=1e-3)
    assert eyes[0].up == pytest.approx(overview.xmat.reshape(3, 3)[:, 1], abs=1e-3)
    assert viewer.model.vis.global_.fovy == viewer.model.camera("overview").fovy[0]


def test_a_display_that_is_not_there_is_an_error_and_not_the_end(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.setenv("DISPLAY", ":9876")
    with pytest.raises(GraphicsError, match=r"needs a display with OpenGL, but there is none .*'rgb_array' needs none"):
        Window(world)
