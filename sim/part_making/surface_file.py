"""A mesh file of one's own as a closed surface in metres: its unit found, what is safe repaired, the rest refused."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from maskval.inputs.files import MOST_MESH, read_input
from sim.errors import PartFileError
from sim.part_making.solids import joined, mesh_of, simplified, solid_of
from sim.parts.mesh_files import LARGEST_PART, check_mesh, read_mesh

UNITS = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inch": 0.0254}
SURELY_METRES = 0.5  # in the file's unit: a part of this size and less is in metres
SURELY_MILLIMETRES = 20.0  # and of this size and more in millimetres
MOST_INPUT_FACES = 2_000_000
MOST_FACES = 12_000  # of the surface that is written: a picture's cost grows with them
_SIMPLER = (2e-4, 5e-4, 1e-3, 2e-3)  # of the diameter by which simplifying may move the surface
_SPECK = 1e-3  # of the volume: a loose body below is dirt of the export


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A closed surface in metres.

    Attributes:
        mesh: the surface.
        unit: that of the file.
        notes: what was done to it, a line each.
    """

    mesh: trimesh.Trimesh
    unit: str
    notes: tuple[str, ...]


def read_surface(path: Path, unit: str | None = None) -> Surface:
    """The surface that a mesh file holds.

    Args:
        path: an STL, OBJ, PLY or GLB file.
        unit: a name of `UNITS`; None finds it, if the size leaves no doubt.

    Raises:
        InvalidFileError: the file cannot be read.
        PartFileError: the unit is in doubt, or the mesh bounds no solid.
    """
    mesh = read_mesh(path.name, read_input(path, MOST_MESH))
    if len(mesh.faces) > MOST_INPUT_FACES:
        raise PartFileError(f"{path.name}: expected at most {MOST_INPUT_FACES} faces, got {len(mesh.faces)}")
    unit = unit or ("m" if path.suffix.lower() == ".glb" else _unit(path.name, mesh))
    mesh = trimesh.Trimesh(mesh.vertices * UNITS[unit], mesh.faces, process=False)
    extent = float(mesh.extents.max())
    if not extent <= LARGEST_PART:
        raise PartFileError(
            f"{path.name}: read in {unit} the mesh is {extent:g} m large, expected at most {LARGEST_PART} m; "
            f"another unit: --unit {' | '.join(UNITS)}"
        )
    mesh, notes = _repaired(mesh)
    check_mesh(mesh, path.name)
    mesh, more = _one_body(mesh, path.name)
    notes += more
    diameter = float(np.linalg.norm(mesh.extents))
    before = len(mesh.faces)
    mesh, moved = simplified(mesh, MOST_FACES, [share * diameter for share in _SIMPLER])
    if len(mesh.faces) < before:
        notes.append(
            f"simplified from {before} to {len(mesh.faces)} faces; the surface moved by {1000 * moved:.2f} mm at most"
        )
    return Surface(mesh, unit, tuple(notes))


def _unit(name: str, mesh: trimesh.Trimesh) -> str:
    extent = float(mesh.extents.max())
    if extent <= SURELY_METRES:
        return "m"
    if extent >= SURELY_MILLIMETRES:
        return "mm"
    size = " × ".join(f"{length:.4g}" for length in mesh.extents)
    raise PartFileError(
        f"{name}: the unit is in doubt: {size} may be millimetres or metres; say which: --unit {' | '.join(UNITS)}"
    )


def _repaired(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, list[str]]:
    """The mesh after what cannot change its shape, and what that was."""
    notes = []
    faces = len(mesh.faces)
    mesh.merge_vertices(digits_vertex=7)  # a tenth of a micrometre
    mesh.update_faces(mesh.nondegenerate_faces() & mesh.unique_faces())
    mesh.remove_unreferenced_vertices()
    if len(mesh.faces) < faces:
        notes.append(f"left out {faces - len(mesh.faces)} triangles without an area or doubled")
    if not mesh.is_watertight:
        before = len(mesh.faces)
        trimesh.repair.fill_holes(mesh)  # of three or four edges
        if len(mesh.faces) > before:
            notes.append(f"closed holes of three or four edges with {len(mesh.faces) - before} triangles")
    if not mesh.is_winding_consistent or (mesh.is_watertight and mesh.volume < 0):
        trimesh.repair.fix_normals(mesh, multibody=True)  # type: ignore[no-untyped-call]
        notes.append("turned triangles so that all of them face outwards")
    return mesh, notes


def _one_body(mesh: trimesh.Trimesh, name: str) -> tuple[trimesh.Trimesh, list[str]]:
    """One solid: specks left out, bodies that overlap joined.

    Raises:
        PartFileError: the bodies do not touch one another, or the mesh bounds no solid.
    """
    bodies = mesh.split(only_watertight=False)
    notes = []
    if len(bodies) > 1:
        volumes = np.array([body.volume for body in bodies])
        specks = (volumes > 0) & (volumes < _SPECK * volumes.max())
        if specks.any():
            notes.append(f"left out {int(specks.sum())} loose bodies of less than {_SPECK:.1%} of the volume")
            kept: Any = trimesh.util.concatenate(
                [body for body, speck in zip(bodies, specks, strict=True) if not speck]
            )
            mesh = kept
        outer = [body for body, volume, speck in zip(bodies, volumes, specks, strict=True) if volume > 0 and not speck]
        if len(outer) > 1:
            solids = [solid for body in outer if (solid := solid_of(body)) is not None]
            union = joined(solids)
            if len(union.decompose()) > 1:
                raise PartFileError(
                    f"{name}: expected one body, got {len(union.decompose())} that do not touch one another"
                )
            notes.append(f"joined {len(outer)} bodies that overlap")
            mesh = mesh_of(union)
    if solid_of(mesh) is None:
        raise PartFileError(f"{name}: expected a surface that bounds a solid, got one with edges of several sheets")
    return mesh, notes
