"""The surfaces that a model's pictures show, as triangles: for those who draw the cell without MuJoCo."""

from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

_SHOWN = 3  # groups of geoms below are drawn
_USUAL = 0.5  # MuJoCo's grey, which gives way to a material's colour
_GROUND = 6.0  # m: side of the square that stands for a plane without end
_THIN = 1e-3  # m

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """What a body shows in one colour.

    Attributes:
        body: its name.
        vertices: in the body's frame, (V, 3) m.
        faces: indices of vertices, (F, 3).
        rgb: 0 to 255.
    """

    body: str
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    rgb: tuple[int, int, int]

    def __post_init__(self) -> None:
        for array in (self.vertices, self.faces):
            array.setflags(write=False)


def shapes_of(model: mujoco.MjModel) -> list[Shape]:
    """The visible shapes, one for each body and colour; textures are left out."""
    found: dict[tuple[str, tuple[int, int, int]], list[trimesh.Trimesh]] = defaultdict(list)
    for geom in np.flatnonzero(model.geom_group < _SHOWN).tolist():
        solid = _solid(model, geom)
        if solid is not None:
            solid.apply_transform(_place(model, geom))
            found[model.body(model.geom_bodyid[geom]).name, _rgb(model, geom)].append(solid)
    return [_joined(body, solids, rgb) for (body, rgb), solids in found.items()]


def _joined(body: str, solids: list[trimesh.Trimesh], rgb: tuple[int, int, int]) -> Shape:
    concatenate: Any = trimesh.util.concatenate
    whole = concatenate(solids)
    return Shape(body, np.array(whole.vertices, np.float32), np.array(whole.faces, np.uint32), rgb)


def _solid(model: mujoco.MjModel, geom: int) -> Any:
    """The surface in the geom's frame; None for what has none, or none that is known here."""
    size, kinds = model.geom_size[geom], mujoco.mjtGeom
    solid: Any = None
    match model.geom_type[geom]:
        case kinds.mjGEOM_MESH:
            solid = _mesh(model, int(model.geom_dataid[geom]))
        case kinds.mjGEOM_BOX:
            solid = trimesh.creation.box(2 * size)
        case kinds.mjGEOM_PLANE:
            solid = trimesh.creation.box((_GROUND, _GROUND, _THIN)).apply_translation((0, 0, -_THIN / 2))
        case kinds.mjGEOM_CYLINDER:
            solid = trimesh.creation.cylinder(size[0], 2 * size[1])
        case kinds.mjGEOM_CAPSULE:
            solid = trimesh.creation.capsule(2 * size[1], size[0])
        case kinds.mjGEOM_SPHERE:
            solid = trimesh.creation.icosphere(3, size[0])
    return solid


def _mesh(model: mujoco.MjModel, mesh: int) -> trimesh.Trimesh:
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    begin, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    vertices, triangles = model.mesh_vert[first : first + count], model.mesh_face[begin : begin + faces]
    return trimesh.Trimesh(vertices.astype(np.float64), triangles, process=False)


def _place(model: mujoco.MjModel, geom: int) -> Array:
    """The geom's frame in its body's, (4, 4)."""
    rotation, place = np.empty(9), np.eye(4)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    place[:3, :3], place[:3, 3] = rotation.reshape(3, 3), model.geom_pos[geom]
    return place


def _rgb(model: mujoco.MjModel, geom: int) -> tuple[int, int, int]:
    rgba, material = model.geom_rgba[geom], model.geom_matid[geom]
    if material >= 0 and (rgba[:3] == _USUAL).all():
        rgba = model.mat_rgba[material]
    red, green, blue = (round(255 * float(value)) for value in rgba[:3])
    return red, green, blue
