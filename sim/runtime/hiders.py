"""What may stand between a camera and the parts: all that MuJoCo's renderer draws but the parts and the floor."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from cell.rounding import rounded
from maskval import Mesh
from maskval.contour import ContourEdges, contour_edges
from sim.model.bodies import part_body

Array = NDArray[np.float64]
Surface = tuple[ContourEdges, bool]  # in the geom's frame, and whether it bounds a volume

_QUARTER_STACKS = 8  # of the 16 stacks that MuJoCo makes a sphere of


@dataclass(frozen=True, slots=True, eq=False)
class Hiders:
    """The bodies of G geoms of a model.

    Attributes:
        geoms: their indices, (G,).
        surfaces: their surfaces.
        centres: middles of balls around them in the geoms' frames, (G, 3) m.
        radii: of the balls, (G,) m.
    """

    geoms: NDArray[np.intp]
    surfaces: tuple[Surface, ...]
    centres: Array
    radii: Array


def hiders_of(mj_model: mujoco.MjModel, parts: int) -> Hiders:
    """All geoms that MuJoCo draws by default, without the parts, and without planes, which lie behind everything.

    Args:
        mj_model: the compiled cell.
        parts: how many parts it has.
    """
    shown = mujoco.MjvOption().geomgroup.astype(bool)[mj_model.geom_group]
    shown &= mj_model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE
    shown[[mj_model.geom(part_body(index)).id for index in range(parts)]] = False
    geoms = np.flatnonzero(shown)
    surfaces = tuple(_surface(mj_model, int(geom)) for geom in geoms)
    centres = np.array([edges.centre_O for edges, _ in surfaces]).reshape(-1, 3)
    return Hiders(geoms, surfaces, centres, np.array([edges.radius for edges, _ in surfaces]))


def _surface(mj_model: mujoco.MjModel, geom: int) -> Surface:
    """The triangles that MuJoCo draws for a geom."""
    if mj_model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        shape = mj_model.mesh(int(mj_model.geom_dataid[geom]))
        first_vertex, first_face = int(shape.vertadr[0]), int(shape.faceadr[0])
        mesh = Mesh(
            mj_model.mesh_vert[first_vertex : first_vertex + int(shape.vertnum[0])],
            mj_model.mesh_face[first_face : first_face + int(shape.facenum[0])],
        )
        return mesh.edges, mesh.is_solid
    kind, size = mujoco.mjtGeom(mj_model.geom_type[geom]), mj_model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_BOX:  # a drum of four sides, turned and stretched
        corners, faces = _turned(np.array([(0.0, -1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 1.0)]), 4, np.pi / 4)
        scale = size * (np.sqrt(2.0), np.sqrt(2.0), 1.0)
    else:
        corners, faces = _turned(_profile(kind, size), int(mj_model.vis.quality.numslices), 0.0)
        scale = size if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else np.ones(3)
    # Rounded, because processors differ in the last bit of a sine.
    return contour_edges(rounded(corners * scale), faces), True


def _profile(kind: mujoco.mjtGeom, size: Array) -> Array:
    """Half of the outline of a solid of revolution, from its lowest to its highest point: radii and heights, (P, 2)."""
    radius, half_height = float(size[0]), float(size[1])
    angles = np.linspace(-np.pi / 2, np.pi / 2, 2 * _QUARTER_STACKS + 1)
    ball = np.column_stack((np.cos(angles), np.sin(angles)))
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return np.array([(0.0, -half_height), (radius, -half_height), (radius, half_height), (0.0, half_height)])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return radius * ball
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return ball
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        lower, upper = radius * ball[: _QUARTER_STACKS + 1], radius * ball[_QUARTER_STACKS:]
        return np.concatenate((lower - (0.0, half_height), upper + (0.0, half_height)))
    raise ValueError(f"expected geoms that are boxes, cylinders, spheres, capsules or meshes, got {kind.name}")


def _turned(profile: Array, slices: int, start: float) -> tuple[Array, NDArray[np.int32]]:
    """The surface of a profile that is turned about z: corners (V, 3) and faces (F, 3), seen from outside."""
    angles = start + np.arange(slices) * 2 * np.pi / slices
    radii, heights = profile[:, :1], np.repeat(profile[:, 1:], slices, axis=1)
    corners = np.stack((radii * np.cos(angles), radii * np.sin(angles), heights), axis=-1)
    ring, one = np.indices((len(profile) - 1, slices))
    a, b = ring * slices + one, ring * slices + (one + 1) % slices
    c, d = b + slices, a + slices
    faces = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, c), (a, c, d))])
    return corners.reshape(-1, 3), faces.astype(np.int32)
