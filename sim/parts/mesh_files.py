"""The one place that reads a part's mesh files, and that says in one line what is wrong with one of them."""

import io
from pathlib import Path

import numpy as np
import trimesh

from sim.errors import PartFileError

KINDS = (".stl", ".ply", ".obj", ".glb")
LARGEST_PART = 0.5  # m; nothing larger fits the gripper and the belt
SMALLEST_PART = 0.003  # m; nothing smaller stays between the jaws
FARTHEST = 0.5  # m between a mesh's box and its frame's origin; a grasp's lever and all rounding grow with it
MOST_FACES = 200_000  # more make every picture slow; `graspcell part` simplifies


def read_mesh(name: str, content: bytes) -> trimesh.Trimesh:
    """The mesh of a file, which holds all of it: no other file is opened.

    Args:
        name: the file's name; its ending says the format, one of `KINDS`.
        content: what it holds.

    Raises:
        PartFileError: it is of another kind, broken, or has no triangles.
    """
    kind = Path(name).suffix.lower()
    if kind not in KINDS:
        raise _unfit(name, f"its name ends in {kind!r}")
    try:
        loaded = trimesh.load(io.BytesIO(content), file_type=kind.removeprefix("."), force="mesh")
    except Exception as error:  # trimesh's readers raise whatever they stumble over
        reason = " ".join(str(error).split())[:200]
        raise _unfit(name, f"{type(error).__name__}: {reason}") from error
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise PartFileError(f"mesh file {name} has no triangles: is it whole, and of the kind that its name says?")
    if loaded.faces.min() < 0 or loaded.faces.max() >= len(loaded.vertices):
        raise PartFileError(f"mesh file {name}: a triangle names a corner that is not there")
    if not np.isfinite(loaded.vertices).all():
        raise PartFileError(f"mesh file {name} has vertices that are not finite")
    return loaded


def convex_hull(name: str, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """The convex hull of a mesh.

    Args:
        name: of the mesh, for messages.
        mesh: what to wrap.

    Raises:
        PartFileError: the mesh is flat.
    """
    try:
        hull: trimesh.Trimesh = mesh.convex_hull
    except Exception as error:  # Qhull's, several kinds of them
        raise PartFileError(f"{name}: expected a mesh with a volume, got a flat one") from error
    if not hull.volume > 0:
        raise PartFileError(f"{name}: expected a mesh with a volume, got {hull.volume:g} m³")
    return hull


def check_face_count(mesh: trimesh.Trimesh, source: str) -> None:
    """Rejects a surface of a part's file that would make every picture slow.

    Raises:
        PartFileError: it has more than `MOST_FACES` faces.
    """
    if len(mesh.faces) > MOST_FACES:
        raise PartFileError(
            f"{source}: the mesh has {len(mesh.faces)} faces, expected at most {MOST_FACES}; `graspcell part` "
            "simplifies a mesh"
        )


def check_mesh(mesh: trimesh.Trimesh, source: str) -> None:
    """Rejects a surface that encloses no volume or is not in metres.

    Raises:
        PartFileError: says what is wrong and how to see it.
    """
    if len(mesh.faces) == 0:
        raise PartFileError(f"{source}: the mesh has no faces")
    if not np.isfinite(mesh.vertices).all():
        raise PartFileError(f"{source}: the mesh has vertices that are not finite")
    _check_size(mesh, source)
    if not mesh.is_watertight:
        edges, counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
        raise PartFileError(
            f"{source}: the mesh is open: {int((counts != 2).sum())} of {len(edges)} edges do not have two faces"
        )
    if mesh.volume <= 0:
        raise PartFileError(f"{source}: the mesh is inside out: its volume is {mesh.volume:g} m³")


def _check_size(mesh: trimesh.Trimesh, source: str) -> None:
    extent = float(mesh.extents.max())
    if extent > LARGEST_PART:
        hint = " (is it in millimetres? expected metres)" if extent > 10 * LARGEST_PART else ""
        raise PartFileError(f"{source}: the mesh is {extent:g} m large, expected at most {LARGEST_PART} m{hint}")
    if extent < SMALLEST_PART:
        raise PartFileError(f"{source}: the mesh is {extent:g} m large, expected at least {SMALLEST_PART} m")
    away = float(np.linalg.norm(np.maximum(0.0, np.maximum(mesh.bounds[0], -mesh.bounds[1]))))
    if away > FARTHEST:
        raise PartFileError(
            f"{source}: the mesh lies {away:g} m from its frame's origin, expected at most {FARTHEST} m"
        )


def _unfit(name: str, reason: str) -> PartFileError:
    return PartFileError(f"mesh file {name}: expected one file with the whole mesh, .stl, .ply, .obj or .glb: {reason}")
