"""The surfaces that hide parts are those that MuJoCo draws."""

import mujoco
import numpy as np
import pytest

from cell.layout import Belt, Layout
from maskval import Camera, Mesh, Pose
from maskval.rendering.z_buffer import ZBuffer
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.conditions import Conditions
from sim.model.parts import PartModel
from sim.model.renderer import pinhole
from sim.runtime.hiders import hiders_of
from sim.runtime.world import World

CAMERA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
GEOMS = {
    "box": ("box", [0.08, 0.05, 0.03]),
    "cylinder": ("cylinder", [0.06, 0.09, 0.0]),
    "sphere": ("sphere", [0.08, 0.0, 0.0]),
    "capsule": ("capsule", [0.04, 0.07, 0.0]),
    "ellipsoid": ("ellipsoid", [0.09, 0.05, 0.03]),
    "mesh": ("mesh", [0.0, 0.0, 0.0]),
}


def model_with(kind: str, size: list[float], **options: object) -> mujoco.MjModel:
    """One geom, turned, 0.6 m before the camera."""
    spec = mujoco.MjSpec()
    spec.visual.quality.offsamples = 0
    spec.stat.extent, spec.visual.map.znear = 1.0, 0.01
    mesh = spec.add_mesh(name="tetrahedron")
    corners = np.array([[0.0, 0.0, 0.1], [0.1, 0.0, -0.05], [-0.06, 0.08, -0.05], [-0.06, -0.07, -0.06]])
    mesh.uservert, mesh.userface = corners.ravel(), [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2]
    geom = spec.worldbody.add_geom(
        type=getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}"),
        size=size,
        pos=[0.02, -0.01, 0.6],
        quat=Pose.from_rotvec((0.5, -0.7, 0.3)).quaternion_wxyz,
        **options,
    )
    if kind == "mesh":
        geom.meshname = "tetrahedron"
    spec.worldbody.add_camera(name="camera", **pinhole(CAMERA, Pose.identity()))
    return spec.compile()


def background() -> Mesh:
    """A sheet that fills the image from behind."""
    corners = np.array([[-2.0, -2.0, 1.5], [2.0, -2.0, 1.5], [2.0, 2.0, 1.5], [-2.0, 2.0, 1.5]])
    return Mesh(corners, np.array([[0, 2, 1], [0, 3, 2]]))


@pytest.mark.parametrize(("kind", "size"), GEOMS.values(), ids=GEOMS)
def test_a_geom_hides_the_pixels_that_mujoco_draws_of_it(kind: str, size: list[float]) -> None:
    model = model_with(kind, size)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, CAMERA.height, CAMERA.width) as renderer:
        renderer.update_scene(data, "camera")
        renderer.enable_segmentation_rendering()
        drawn = renderer.render()[..., 0] == 0
    hiders = hiders_of(model, 0)
    assert hiders.geoms.tolist() == [0]
    image = ZBuffer(CAMERA, pixel_center=PIXEL_CENTER)
    image.draw(background(), Pose.identity(), 0)
    assert (image.numbers == 0).all()
    rotation, translation = data.geom_xmat[0].reshape(3, 3).copy(), data.geom_xpos[0].copy()
    for array in (rotation, translation):
        array.setflags(write=False)
    ((surface, is_solid),) = hiders.surfaces
    image.hide(surface, rotation, translation, is_solid=is_solid)
    assert drawn.sum() > 3000
    assert ((image.numbers == NO_INSTANCE) ^ drawn).sum() <= 5e-4 * drawn.sum()  # OpenGL snaps corners to 1/256 pixel


def test_what_mujoco_does_not_draw_hides_nothing() -> None:
    assert len(hiders_of(model_with(*GEOMS["box"], group=3), 0).geoms) == 0
    assert len(hiders_of(model_with("plane", [1.0, 1.0, 0.1]), 0).geoms) == 0


def test_a_belt_longer_than_a_mesh_may_be_hides_too(antenna: PartModel) -> None:
    world = World(Layout(belt=Belt(speed=0.1, upstream=14.0)), antenna, 1, Conditions(belt_speed=0.1))
    hiders = hiders_of(world.mj_model, 1)
    assert hiders.radii.max() == pytest.approx(np.linalg.norm([0.028, 15.9 + 0.06, 0.09]) / 2)  # of a rail
    names = [world.mj_model.geom(int(geom)).name for geom in hiders.geoms]
    assert "belt" in names
    assert "part_0" not in names
