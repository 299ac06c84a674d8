"""Parts as data: one TOML file per kind, checked on the way in, with everything that physics needs to know of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from cell.part import Grasp, Part
from cell.rounding import rounded
from maskval import InvalidFileError, MaskvalError, Mesh, Pose, SymmetryAxis
from maskval.inputs.files import MOST_MESH, read_input, read_input_text
from maskval.inputs.spelling import nearest
from sim.errors import PartFileError
from sim.parts.mesh_files import check_face_count, check_mesh, convex_hull, read_mesh
from sim.parts.part_checks import check_part
from sim.parts.part_file import GraspRow, MeshRow, PartFile, read_part_file
from sim.parts.part_shapes import Curves, bow_curves, convex_pieces, fin_curves, join
from sim.parts.stable_poses import RestingPose, resting_poses
from sim.parts.turns import Turn, alike

_INERTIA_DIGITS = 12  # decimals of kg m²: parts have 1e-4
_PART_FOLDER = files("sim") / "assets" / "parts"
_GENERATORS: dict[str, Callable[..., Curves]] = {"fin": fin_curves, "bow": bow_curves}


@dataclass(frozen=True, slots=True, eq=False)
class PartModel:
    """A part with its physics; `part` is what the controller may know."""

    part: Part
    pieces: tuple[trimesh.Trimesh, ...]
    mass: float
    center_of_mass: NDArray[np.float64]
    inertia: NDArray[np.float64]
    friction: float
    rgba: tuple[float, float, float, float]
    specular: float
    shininess: float
    resting_poses: tuple[RestingPose, ...]
    noise: str
    symmetries: tuple[Turn, ...] = ()

    def __post_init__(self) -> None:
        for name in ("center_of_mass", "inertia"):
            object.__setattr__(self, name, _frozen(getattr(self, name)))
        for piece in self.pieces:
            piece.mutable = False  # trimesh then refuses whatever would change it


def part_names() -> list[str]:
    """Names of the parts that come with the package."""
    return sorted(Path(entry.name).stem for entry in _PART_FOLDER.iterdir() if entry.name.endswith(".toml"))


def load_part(name_or_file: str) -> PartModel:
    """The part of this name, or of this TOML file; the same one again while its files stay as they are.

    Raises:
        PartFileError: no such part, or its file or mesh is unfit; the message says why.
    """
    if name_or_file.endswith(".toml"):
        path = Path(name_or_file)
        try:
            return _read(read_input_text(path), path.parent, name_or_file)
        except InvalidFileError as error:
            raise PartFileError(f"part file {error}") from error
    if name_or_file not in part_names():
        raise PartFileError(
            f"unknown object {name_or_file!r}: expected one of {', '.join(part_names())}, or the path of a .toml file"
            f"{nearest(name_or_file, part_names())}"
        )
    return _read((_PART_FOLDER / f"{name_or_file}.toml").read_text(), Path(), name_or_file)


def _read(text: str, folder: Path, source: str) -> PartModel:
    try:
        rows = read_part_file(text)
        if source.endswith(".toml"):
            _check_name(rows.name, text)
        names = [rows.mesh.file, *(rows.mesh.pieces or ())] if rows.mesh.file else []
        meshes = tuple((name, read_input(folder / name, MOST_MESH)) for name in names)
        beside = folder / rows.noise  # an error model of its own is looked for beside the part's file first
        noise = str(beside) if rows.noise.endswith(".toml") and beside.is_file() else rows.noise
        return _build(text, meshes, source, noise)
    except (MaskvalError, PartFileError, TypeError, ValueError, ArithmeticError) as error:
        message = str(error)
        raise PartFileError(message if message.startswith(source) else f"{source}: {message}") from error


def _check_name(name: str, text: str) -> None:
    """Rejects the name of a shipped part, whose thresholds and figures are not those of another one."""
    if name in part_names() and text != (_PART_FOLDER / f"{name}.toml").read_text():
        raise PartFileError(
            f"name: expected another one than those of the shipped parts ({', '.join(part_names())}), got {name!r}: "
            "its thresholds and the paper's figures would be taken for this part's"
        )


@lru_cache(maxsize=16)  # by all that a part is made from: a tenth of a second goes into its resting poses and hulls
def _build(text: str, meshes: tuple[tuple[str, bytes], ...], source: str, noise: str) -> PartModel:
    rows = read_part_file(text)
    mesh, pieces = _shape(rows.mesh, dict(meshes), source)
    mesh.density = rows.mass_kg / mesh.volume
    red, green, blue, alpha = rows.rgba
    slot_x, slot_y = np.asarray(rows.slot_mm) / 1000.0
    symmetries = tuple(
        Turn(SymmetryAxis(np.array(row.axis), np.array(row.point_mm) / 1000.0), row.fold) for row in rows.symmetries
    )
    model = PartModel(
        part=Part(
            name=rows.name,
            mesh=Mesh(mesh.vertices, mesh.faces),
            grasps=tuple(_grasp(row) for row in rows.grasps),
            slot_size=(float(slot_x), float(slot_y)),
            symmetries=alike(symmetries),
        ),
        pieces=pieces,
        mass=rows.mass_kg,
        center_of_mass=rounded(mesh.center_mass),
        inertia=rounded(mesh.moment_inertia, _INERTIA_DIGITS),
        friction=rows.friction,
        rgba=(red, green, blue, alpha),
        specular=rows.specular,
        shininess=rows.shininess,
        resting_poses=_resting_poses(rows, mesh),
        noise=noise,
        symmetries=symmetries,
    )
    check_part(model.part, model.resting_poses, pieces, model.center_of_mass)
    return model


def _frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    copied = np.array(array)
    copied.flags.writeable = False
    return copied


def _resting_poses(rows: PartFile, mesh: trimesh.Trimesh) -> tuple[RestingPose, ...]:
    """Those of the file, or what the mesh's hull says."""
    if not rows.poses:
        return resting_poses(mesh)
    total = sum(row.probability for row in rows.poses)
    return tuple(
        RestingPose.from_up(_unit(row.up), mesh.vertices, float(rounded(row.probability / total))) for row in rows.poses
    )


def _unit(direction: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
    vector = np.asarray(direction, dtype=np.float64)
    unit: NDArray[np.float64] = vector / np.linalg.norm(vector)
    return unit


def _shape(
    row: MeshRow, meshes: Mapping[str, bytes], source: str
) -> tuple[trimesh.Trimesh, tuple[trimesh.Trimesh, ...]]:
    """The surface and its convex pieces, from a generator or from mesh files beside the TOML file."""
    if row.generator is not None:
        if row.generator not in _GENERATORS:
            raise ValueError(f"mesh.generator is {row.generator!r}, expected one of {', '.join(_GENERATORS)}")
        # Rounded: otherwise the last bit decides which triangles the hulls have, and so how likely a side is.
        curves = rounded(_curves(row.generator, row.arguments))
        mesh = join(curves)
        check_face_count(mesh, source)
        check_mesh(mesh, source)
        return mesh, convex_pieces(curves)
    file = str(row.file)
    surface = read_mesh(file, meshes[file])
    check_face_count(surface, source)
    check_mesh(surface, source)
    if row.pieces is None:
        return surface, (convex_hull(file, surface),)
    return surface, tuple(convex_hull(name, read_mesh(name, meshes[name])) for name in row.pieces)


def _curves(generator: str, arguments: dict[str, Any]) -> Curves:
    try:
        return _GENERATORS[generator](**arguments)
    except (TypeError, ValueError, IndexError) as error:
        raise PartFileError(f"mesh: unfit arguments of the generator {generator}: {error}") from error


def _grasp(row: GraspRow) -> Grasp:
    approach = _unit(row.approach)  # the file's numbers are rounded
    closing = np.array(row.closing)
    closing = _unit(closing - (closing @ approach) * approach)
    X_OT = Pose(np.column_stack([np.cross(closing, approach), closing, approach]), np.array(row.tcp_mm) / 1000.0)
    return Grasp(row.name, X_OT, row.half_opening_mm / 1000.0, float(np.radians(row.max_tilt_deg)))
