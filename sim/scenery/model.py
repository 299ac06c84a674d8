"""The model that pictures are taken of: the cell's bodies and joints, with looks in place of simple shapes."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Any

import mujoco
import numpy as np
import trimesh

from cell.layout import Layout
from sim.model.apply_conditions import disturb
from sim.model.conditions import Conditions
from sim.model.parts import PartModel
from sim.model.scene import describe_scene
from sim.scenery.furniture_looks import furniture_pieces
from sim.scenery.lighting import add_lighting
from sim.scenery.materials import add_materials
from sim.scenery.robot_looks import Piece, arm_pieces, camera_pieces, gripper_pieces
from sim.scenery.solids import Solid, merged
from sim.scenery.vendor_meshes import maker_meshes

_HIDDEN = 3  # group of geoms: MuJoCo draws groups 0 to 2
_REPLACED = ("base", "flange", "container")  # bodies whose own shapes are not drawn, beside those of joints
_SHARP = 0.6  # rad between faces above which an edge of a part is an edge
_WIDER = 0.35  # of a part's shininess: a lamp far away is a point to OpenGL, but none that a part mirrors
_FINE = 0.016  # m: longest edge of a part's faces, since lights are computed at vertices


def build_scenery(
    layout: Layout,
    models: Sequence[PartModel],
    slot_size: tuple[float, float],
    conditions: Conditions,
    *,
    use_meshes: bool = False,
) -> mujoco.MjModel:
    """The compiled model; its joints are those of `sim.model.scene.build_scene`, in the same order.

    Args:
        layout: the cell.
        models: a part model per part on the belt.
        slot_size: inner size of the container's slots along W's x and y, m.
        conditions: what differs from the layout that the controller believes in.
        use_meshes: whether the arm is drawn with its maker's meshes.

    Raises:
        MeshesMissingError: they are asked for and not installed.
    """
    spec = describe_scene(layout, models, slot_size, conditions)
    _hide_shapes(spec)
    add_lighting(spec)
    add_materials(spec)
    pieces = [*furniture_pieces(layout, slot_size), *gripper_pieces(layout.gripper), *camera_pieces()]
    _add(spec, pieces if use_meshes else [*pieces, *arm_pieces()])
    if use_meshes:
        _add_maker_meshes(spec)
    for model in {model.part.name: model for model in models}.values():
        _smooth(spec, model)
    compiled = spec.compile()
    disturb(compiled, conditions)
    return compiled


def _hide_shapes(spec: mujoco.MjSpec) -> None:
    """Hides what has looks of its own."""
    for body in spec.bodies:
        moves = bool(body.joints) and not body.name.startswith(("part_", "distractor_"))
        for geom in body.geoms:
            is_ground = geom.name == "belt" or geom.type == mujoco.mjtGeom.mjGEOM_PLANE
            if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
                geom.size = (0.0, 0.0, 1.0)  # drawn without end, fading into the sky
            if (moves or body.name in (*_REPLACED, "belt", "floor")) and not is_ground:
                geom.group = _HIDDEN


def _add(spec: mujoco.MjSpec, pieces: Iterable[Piece]) -> None:
    """Adds one mesh per body and material."""
    found: dict[tuple[str, str], list[Solid]] = defaultdict(list)
    for body, material, solid in pieces:
        found[body, material].append(solid)
    for (body, material), solids in found.items():
        name, whole = f"{body}_{material}", merged(solids)
        mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        mesh.uservert, mesh.usernormal = whole.vertices.ravel(), whole.normals.ravel()
        mesh.usertexcoord, mesh.userface = whole.uv.ravel(), whole.faces.ravel()
        mesh.userfacenormal = mesh.userfacetexcoord = whole.faces.ravel()
        _draw(spec.body(body), name, material=f"look_{material}")


def _add_maker_meshes(spec: mujoco.MjSpec) -> None:
    for body, meshes in maker_meshes().items():
        for index, piece in enumerate(meshes):
            name = f"{body}_{index}"
            mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
            mesh.uservert, mesh.userface = piece.vertices.ravel(), piece.faces.ravel()
            _draw(spec.body(body), name, rgba=piece.rgba)


def _draw(body: mujoco.MjsBody, mesh: str, **look: object) -> None:
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, contype=0, conaffinity=0, density=0.0, **look)


def _smooth(spec: mujoco.MjSpec, model: PartModel) -> None:
    """Gives a part's mesh smaller faces, and normals that are smooth but at its edges."""
    mesh = model.part.mesh
    subdivide: Any = trimesh.remesh.subdivide_to_size
    vertices, faces = subdivide(mesh.vertices, mesh.faces, _FINE)
    shaded = trimesh.graph.smooth_shade(trimesh.Trimesh(vertices, faces), angle=_SHARP)
    spec.material(model.part.name).shininess = _WIDER * model.shininess
    shape = spec.mesh(model.part.name)
    shape.uservert, shape.userface = shaded.vertices.ravel(), shaded.faces.astype(np.int32).ravel()
    shape.usernormal = shaded.vertex_normals.ravel()
    shape.userfacenormal = shaded.faces.astype(np.int32).ravel()
