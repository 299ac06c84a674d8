"""BOP's object models: PLY meshes in millimetres, and their diameters and symmetries."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from maskval.bop.fields import M_PER_MM, Entry, read_json, write_entries
from maskval.bop.ply import read_ply, write_ply
from maskval.bop.poses import PoseReader
from maskval.errors import InvalidFileError, MaskvalError
from maskval.geometry import Pose, as_poses
from maskval.mesh import Mesh
from maskval.symmetry import MAXIMUM_STEP, SymmetryAxis, symmetry_poses


@dataclass(frozen=True, slots=True)
class ModelInfo:
    """What BOP knows of a model.

    Args:
        diameter_m: Greatest distance of two vertices, metres.
        symmetries: Poses that the object looks alike in, without the identity.
        axes: Axes of continuous symmetry.
    """

    diameter_m: float
    symmetries: tuple[Pose, ...] = ()
    axes: tuple[SymmetryAxis, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "symmetries", as_poses(self.symmetries))

    def symmetry_poses(self, maximum_step: float = MAXIMUM_STEP) -> tuple[Pose, ...]:
        """All poses that the object looks alike in, the identity first (see `maskval.symmetry_poses`)."""
        return symmetry_poses(self.symmetries, self.axes, maximum_step=maximum_step)


def read_model(path: Path) -> Mesh:
    """The mesh of a PLY file, turned from millimetres to metres.

    Raises:
        InvalidFileError: If the file is malformed or holds no mesh that can be drawn.
    """
    vertices_mm, faces = read_ply(path)
    try:
        return Mesh(vertices_mm * M_PER_MM, faces)
    except MaskvalError as error:
        raise InvalidFileError(f"{path}: {error}") from error


def write_model(path: Path, mesh: Mesh) -> None:
    """Writes a mesh as a PLY file of text, in millimetres."""
    write_ply(path, mesh.vertices / M_PER_MM, mesh.faces)


def read_models_info(path: Path) -> dict[int, ModelInfo]:
    """What `models_info.json` knows of each object, in metres."""
    with PoseReader(path) as poses:
        return {obj_id: _info(entry, poses) for obj_id, entry in read_json(path).items()}


def write_models_info(path: Path, models: Mapping[int, tuple[Mesh, ModelInfo]]) -> None:
    """Writes `models_info.json` with the box of each mesh, in millimetres."""
    write_entries(path, {str(obj_id): _fields(mesh, info) for obj_id, (mesh, info) in models.items()})


def _info(entry: Entry, poses: PoseReader) -> ModelInfo:
    diameter = entry["diameter"]
    if diameter.number() <= 0:
        raise diameter.error("a diameter > 0 mm")
    symmetries = []
    for symmetry in entry["symmetries_discrete"].elements() if "symmetries_discrete" in entry else ():
        X = symmetry.numbers(16).reshape(4, 4)
        if X[3].tolist() != [0, 0, 0, 1]:
            raise symmetry.error("a symmetry whose last row is 0 0 0 1")
        symmetries.append(poses.pose(X[:3, :3].ravel(), X[:3, 3], symmetry.place))
    axes = []
    for axis in entry["symmetries_continuous"].elements() if "symmetries_continuous" in entry else ():
        direction, offset = axis["axis"].numbers(3), axis["offset"].numbers(3) * M_PER_MM
        if not direction.any():
            raise axis["axis"].error("a direction")
        axes.append(SymmetryAxis(direction, offset))
    return ModelInfo(diameter.number() * M_PER_MM, tuple(symmetries), tuple(axes))


def _fields(mesh: Mesh, info: ModelInfo) -> dict[str, Any]:
    low, high = mesh.bounds / M_PER_MM
    fields: dict[str, Any] = {"diameter": info.diameter_m / M_PER_MM}
    for axis, least, size in zip("xyz", low.tolist(), (high - low).tolist(), strict=True):
        fields |= {f"min_{axis}": least, f"size_{axis}": size}
    if info.symmetries:
        scale = np.ones((4, 4))
        scale[:3, 3] = 1 / M_PER_MM
        fields["symmetries_discrete"] = [(X.matrix * scale).ravel().tolist() for X in info.symmetries]
    if info.axes:
        fields["symmetries_continuous"] = [
            {"axis": axis.axis_O.tolist(), "offset": (axis.offset_O / M_PER_MM).tolist()} for axis in info.axes
        ]
    return fields
