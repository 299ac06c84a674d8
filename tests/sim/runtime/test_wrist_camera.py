"""The instance ids by geometry against those of MuJoCo's renderer, in the states that an experiment passes through."""

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest

from benchmarks.instance_ids import CONDITIONS
from cell.arm.ur10 import inverse_on_branch
from cell.layout import Layout
from maskval import Pose, silhouette
from sim.errors import GraphicsError
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.parts import PartModel
from sim.model.renderer import Renderer
from sim.model.robot import JOINTS
from sim.networks.random_streams import Streams
from sim.runtime.episode import belt_under, starting_poses
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera

PARTS = 6
DOWNWARDS = np.diag([1.0, -1.0, -1.0])
# Places of the tool in W, m: over the belt, aslant and near, at its side aslant over a rail, and over the container.
TOOLS = (
    Pose(DOWNWARDS, np.array([0.68, 0.3, 0.35])),
    Pose(Pose.from_rotvec((0.4, 0.2, 0.5)).rotation @ DOWNWARDS, np.array([0.64, 0.1, 0.2])),
    Pose(Pose.from_rotvec((0.0, -0.5, 1.2)).rotation @ DOWNWARDS, np.array([0.82, 0.0, 0.1])),
    Pose(DOWNWARDS, np.array([0.05, -0.82, 0.15])),
)


def states(world: World) -> Iterator[None]:
    """Has the arm at all places, and at each part 0 where it was, half sunk into what is seen, and near the camera."""
    model, data, layout = world.mj_model, world.data, world.layout
    arm = [model.joint(name).qposadr[0] for name in JOINTS]
    part = model.joint("part_0").qposadr[0]
    for X_WT in TOOLS:
        q = inverse_on_branch(layout.X_WB.inverse() @ X_WT @ layout.gripper.X_FT.inverse(), world.q_home)
        assert q is not None
        data.qpos[arm] = q
        mujoco.mj_forward(model, data)
        yield
        X_WC = world.X_WC()
        floor_z = layout.belt.top_z if X_WT.translation[1] > -0.5 else layout.container.floor_z
        distance = (floor_z - X_WC.translation[2]) / X_WC.rotation[2, 2]
        for p_CO in ([0.0, 0.0, distance], [0.01, 0.02, 0.12]):
            data.qpos[part : part + 3] = X_WC.apply(p_CO)
            mujoco.mj_forward(model, data)
            yield


@pytest.mark.parametrize("name", CONDITIONS)
def test_the_instance_ids_are_mujocos_in_all_but_two_of_ten_thousand_pixels(handle: PartModel, name: str) -> None:
    conditions = CONDITIONS[name]
    world = World(Layout(belt=belt_under(conditions, PARTS)), handle, PARTS, conditions)
    world.reset(starting_poses(world, Streams(1, 0, "handle")))
    camera, renderer = WristCamera(world), Renderer(world.mj_model, 480, 640)
    shown, hidden = 0, 0
    for _ in states(world):
        X_CO_true = [world.X_CO(part) for part in range(PARTS)]
        found, expected = camera.instance_ids(X_CO_true), renderer.instance_ids(world.data, "wrist")
        assert (found != expected).sum() <= 2e-4 * found.size
        # Nor are the pixels of a part wrong at more than its outline: 0.05 % of them, as for silhouettes.
        assert (found != expected).sum() <= 5e-4 * (expected != NO_INSTANCE).sum() + 2
        shown += (expected != NO_INSTANCE).sum()
        for X_CO in X_CO_true:
            whole = silhouette(handle.part.mesh, X_CO, world.camera_true, pixel_center=PIXEL_CENTER).mask
            hidden += (whole & (found == NO_INSTANCE)).sum()
    renderer.close()
    assert shown > 50_000
    assert hidden > 1_000


def test_opengl_is_opened_for_pictures_only_and_closed(antenna_world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    opened, closed = [], []

    class Watched(Renderer):
        def __init__(self, *arguments: Any) -> None:
            opened.append(arguments)
            super().__init__(*arguments)

        def close(self) -> None:
            closed.append(self)
            super().close()

    for module in ("sim.runtime.wrist_camera", "sim.runtime.pictures"):
        monkeypatch.setattr(f"{module}.Renderer", Watched)
    camera = WristCamera(antenna_world)
    camera.instance_ids([antenna_world.X_CO(part) for part in range(2)])
    camera.close()
    assert opened == closed == []
    for count in (1, 2):  # one context each: a depth is exact, a picture is smooth
        assert camera.rgb().shape == (480, 640, 3)
        assert camera.depth().shape == (480, 640)
        assert len(opened) == 2, count
    camera.close()
    camera.close()
    assert len(closed) == 2


def test_without_opengl_pictures_raise_and_instance_ids_do_not(
    antenna_world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise AttributeError("'NoneType' object has no attribute 'eglQueryString'")

    monkeypatch.setattr("sim.model.renderer.mujoco.Renderer", broken)
    camera = WristCamera(antenna_world)
    assert camera.instance_ids([antenna_world.X_CO(part) for part in range(2)]).shape == (480, 640)
    for picture in (camera.rgb, camera.depth):
        with pytest.raises(GraphicsError, match="no off-screen OpenGL, which pictures need"):
            picture()
