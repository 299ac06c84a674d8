"""Triangles of what a model shows: sizes, places and colours are those of its geoms."""

import mujoco
import numpy as np
import pytest
import trimesh

from maskval import Pose
from sim.scenery.shapes import Shape, shapes_of

KINDS = mujoco.mjtGeom
PLACE = Pose.from_rotvec((0.5, -0.7, 0.3), (0.02, -0.01, 0.6))
# By name: kind, size, half extents and volume; the round ones are of triangles within them, some percent smaller.
SOLIDS = {
    "box": (KINDS.mjGEOM_BOX, (0.08, 0.05, 0.03), (0.08, 0.05, 0.03), 8 * 0.08 * 0.05 * 0.03),
    "cylinder": (KINDS.mjGEOM_CYLINDER, (0.06, 0.09, 0), (0.06, 0.06, 0.09), np.pi * 0.06**2 * 0.18),
    "sphere": (KINDS.mjGEOM_SPHERE, (0.08, 0, 0), (0.08, 0.08, 0.08), 4 / 3 * np.pi * 0.08**3),
    "capsule": (
        KINDS.mjGEOM_CAPSULE,
        (0.04, 0.07, 0),
        (0.04, 0.04, 0.11),
        np.pi * 0.04**2 * 0.14 + 4 / 3 * np.pi * 0.04**3,
    ),
}
TETRAHEDRON = np.array([[0.0, 0.0, 0.1], [0.1, 0.0, -0.05], [-0.06, 0.08, -0.05], [-0.06, -0.07, -0.06]])


def shown(spec: mujoco.MjSpec) -> list[Shape]:
    return shapes_of(spec.compile())


def placed(X_BO: Pose) -> dict[str, np.ndarray]:
    return {"pos": X_BO.translation, "quat": X_BO.quaternion_wxyz}


def in_frame_of(X_BO: Pose, shape: Shape) -> trimesh.Trimesh:
    """The shape in the frame of the geom."""
    inverse = X_BO.inverse()
    return trimesh.Trimesh(shape.vertices @ inverse.rotation.T + inverse.translation, shape.faces)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_geom_has_its_size_its_place_and_faces_that_look_outwards(name: str) -> None:
    kind, size, half, volume = SOLIDS[name]
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=kind, size=size, rgba=(1, 0.5, 0, 1), **placed(PLACE))
    (shape,) = shown(spec)
    solid = in_frame_of(PLACE, shape)
    assert solid.bounds == pytest.approx(np.array([-np.array(half), half]), abs=0.002 * max(half))
    assert solid.is_watertight
    assert 0.96 * volume < solid.volume < volume * (1 + 1e-5)
    assert (shape.body, shape.rgb) == ("world", (255, 128, 0))


def test_a_mesh_has_the_corners_that_it_was_given() -> None:
    spec = mujoco.MjSpec()
    mesh = spec.add_mesh(name="tetrahedron")
    mesh.uservert, mesh.userface = TETRAHEDRON.ravel(), [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2]
    spec.worldbody.add_geom(type=KINDS.mjGEOM_MESH, meshname="tetrahedron", **placed(PLACE))
    (shape,) = shown(spec)
    corners = TETRAHEDRON @ PLACE.rotation.T + PLACE.translation
    assert len(shape.vertices) == len(corners)
    distances = np.linalg.norm(corners[:, None] - shape.vertices[None], axis=2)
    assert distances.min(axis=1).max() < 1e-6


def test_a_plane_is_a_sheet_whose_upper_side_is_the_plane() -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=KINDS.mjGEOM_PLANE, size=(0, 0, 1), pos=(0, 0, -0.8))
    (shape,) = shown(spec)
    assert shape.vertices[:, 2].max() == pytest.approx(-0.8)
    assert np.ptp(shape.vertices, axis=0)[:2].min() > 5.0


def test_geoms_of_a_body_and_colour_are_one_shape_and_hidden_groups_none() -> None:
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="arm", pos=(1, 2, 3))
    red, blue = (1, 0, 0, 1), (0, 0, 1, 1)
    for number, (color, group) in enumerate(((red, 0), (blue, 1), (red, 2), (red, 3))):
        body.add_geom(type=KINDS.mjGEOM_BOX, size=(0.1, 0.1, 0.1), pos=(number, 0, 0), rgba=color, group=group)
    found = {shape.rgb: shape for shape in shown(spec)}
    assert {shape.body for shape in found.values()} == {"arm"}
    assert found.keys() == {(255, 0, 0), (0, 0, 255)}
    first, other = found[255, 0, 0].vertices, found[0, 0, 255].vertices
    assert (first[:, 0].min(), first[:, 0].max()) == pytest.approx((-0.1, 2.1))  # in the body's frame
    assert (other[:, 0].min(), other[:, 0].max()) == pytest.approx((0.9, 1.1))


@pytest.mark.parametrize(("options", "rgb"), [({}, (0, 51, 102)), ({"rgba": (1, 1, 1, 1)}, (255, 255, 255))])
def test_a_geoms_own_colour_takes_precedence_over_its_materials(
    options: dict[str, object], rgb: tuple[int, int, int]
) -> None:
    spec = mujoco.MjSpec()
    spec.add_material(name="paint", rgba=(0, 0.2, 0.4, 1))
    spec.worldbody.add_geom(type=KINDS.mjGEOM_BOX, size=(1, 1, 1), material="paint", **options)
    (shape,) = shown(spec)
    assert shape.rgb == rgb


def test_a_shape_cannot_be_written_to() -> None:
    spec = mujoco.MjSpec()
    spec.worldbody.add_geom(type=KINDS.mjGEOM_BOX, size=(1, 1, 1))
    (shape,) = shown(spec)
    for array in (shape.vertices, shape.faces):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
