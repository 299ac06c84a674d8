"""Parts as data: one TOML file per kind, checked on the way in, with everything that physics needs to know of it."""

import io
import tomllib
from collections.abc import Callable, Mapping
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
from maskval import InvalidFileError, MaskvalError, Mesh, Pose
from maskval.input_files import MOST_MESH, read_input, read_input_text
from sim.errors import PartFileError
from sim.model.part_shapes import Curves, bow_curves, convex_pieces, fin_curves, join

RAREST_RESTING_POSE = 0.02  # poses less likely than this are facets of a rounded edge, on which no real part stays
_INERTIA_DIGITS = 12  # decimals of kg m²: parts have 1e-4
_LARGEST_PART = 0.5  # m; nothing larger fits the gripper and the belt
_PART_FOLDER = files("sim") / "assets" / "parts"
_GENERATORS: dict[str, Callable[..., Curves]] = {"fin": fin_curves, "bow": bow_curves}


@dataclass(frozen=True, slots=True, eq=False)
class RestingPose:
    """One way to lie on a flat surface: the rotation R_WO, the height of O's origin (m) and how likely it is."""

    rotation: NDArray[np.float64]
    height: float
    probability: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotation", _frozen(self.rotation))


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
        )
    return _read((_PART_FOLDER / f"{name_or_file}.toml").read_text(), Path(), name_or_file)


def _read(text: str, folder: Path, source: str) -> PartModel:
    try:
        shape = tomllib.loads(text)["mesh"]
        names = [shape["file"], *shape.get("pieces", ())] if "generator" not in shape else []
        return _build(text, tuple((name, read_input(folder / name, MOST_MESH)) for name in names), source)
    except KeyError as missing:
        raise PartFileError(f"{source}: the key {missing} is missing") from missing
    except (tomllib.TOMLDecodeError, MaskvalError, TypeError, ValueError) as error:
        raise error if isinstance(error, PartFileError) else PartFileError(f"{source}: {error}") from error


@lru_cache(maxsize=16)  # by all that a part is made from: a tenth of a second goes into its resting poses and hulls
def _build(text: str, meshes: tuple[tuple[str, bytes], ...], source: str) -> PartModel:
    table = tomllib.loads(text)
    mesh, pieces = _shape(table["mesh"], dict(meshes))
    check_mesh(mesh, source)
    mass = _positive("mass_kg", table["mass_kg"])
    mesh.density = mass / mesh.volume
    slot_x, slot_y = _vector("slot.size_mm", table["slot"]["size_mm"], 2) / 1000.0
    red, green, blue, alpha = _vector("rgba", table["rgba"], 4)
    return PartModel(
        part=Part(
            name=table["name"],
            mesh=Mesh(mesh.vertices, mesh.faces),
            grasps=tuple(_grasp(row) for row in table["grasps"]),
            slot_size=(_positive("slot.size_mm", slot_x), _positive("slot.size_mm", slot_y)),
        ),
        pieces=pieces,
        mass=mass,
        center_of_mass=rounded(mesh.center_mass),
        inertia=rounded(mesh.moment_inertia, _INERTIA_DIGITS),
        friction=_positive("friction", table["friction"]),
        rgba=(float(red), float(green), float(blue), float(alpha)),
        specular=float(table["specular"]),
        shininess=float(table["shininess"]),
        resting_poses=resting_poses(mesh),
        noise=table.get("noise", table["name"]),
    )


def _frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    copied = np.array(array)
    copied.flags.writeable = False
    return copied


def _positive(key: str, value: float) -> float:
    if not value > 0:
        raise ValueError(f"expected {key} above 0, got {value:g}")
    return float(value)


def _vector(key: str, values: Any, length: int) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (length,) or not np.isfinite(array).all():
        raise ValueError(f"expected {key} to be {length} numbers, got {values}")
    return array


def _shape(table: dict[str, Any], meshes: Mapping[str, bytes]) -> tuple[trimesh.Trimesh, tuple[trimesh.Trimesh, ...]]:
    """The surface and its convex pieces, from a generator or from mesh files beside the TOML file."""
    generator = table.get("generator")
    if generator is not None:
        if generator not in _GENERATORS:
            raise ValueError(f"mesh.generator is {generator!r}, expected one of {', '.join(_GENERATORS)}")
        # Rounded: otherwise the last bit decides which triangles the hulls have, and so how likely a side is.
        curves = rounded(_GENERATORS[generator](**{key: value for key, value in table.items() if key != "generator"}))
        return join(curves), convex_pieces(curves)
    surface = _mesh(table["file"], meshes)
    if "pieces" not in table:
        return surface, (surface.convex_hull,)
    return surface, tuple(_mesh(name, meshes).convex_hull for name in table["pieces"])


def _mesh(name: str, meshes: Mapping[str, bytes]) -> trimesh.Trimesh:
    """The mesh of a file, which holds all of it: no other file is opened."""
    kind = Path(name).suffix.removeprefix(".")
    try:
        loaded = trimesh.load(io.BytesIO(meshes[name]), file_type=kind, force="mesh")
    except Exception as error:  # trimesh's readers raise whatever they stumble over
        raise ValueError(
            f"mesh file {name}: expected one file with the whole mesh, .stl, .ply, .obj or .glb: {error}"
        ) from error
    if not isinstance(loaded, trimesh.Trimesh) or len(loaded.faces) == 0:
        raise ValueError(f"mesh file {name} has no triangles")
    return loaded


def check_mesh(mesh: trimesh.Trimesh, source: str) -> None:
    """Rejects a surface that encloses no volume or is not in metres.

    Raises:
        PartFileError: says what is wrong and how to see it.
    """
    if len(mesh.faces) == 0:
        raise PartFileError(f"{source}: the mesh has no faces")
    if not np.isfinite(mesh.vertices).all():
        raise PartFileError(f"{source}: the mesh has vertices that are not finite")
    extent = float(mesh.extents.max())
    if extent > _LARGEST_PART:
        hint = " (is it in millimetres? expected metres)" if extent > 10 * _LARGEST_PART else ""
        raise PartFileError(f"{source}: the mesh is {extent:g} m large, expected at most {_LARGEST_PART} m{hint}")
    if not mesh.is_watertight:
        edges, counts = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
        raise PartFileError(
            f"{source}: the mesh is open: {int((counts != 2).sum())} of {len(edges)} edges do not have two faces"
        )
    if mesh.volume <= 0:
        raise PartFileError(f"{source}: the mesh is inside out: its volume is {mesh.volume:g} m³")


def resting_poses(mesh: trimesh.Trimesh) -> tuple[RestingPose, ...]:
    """Every way in which the part lies still on a plane, likeliest first; the probabilities add up to 1.

    All numbers are rounded. Of equally likely poses, as a mirrored part has, the first is the one whose rotation has
    the lesser entries, row by row.
    """
    transforms, probabilities = trimesh.poses.compute_stable_poses(mesh, n_samples=1, sigma=0.0)
    kept = probabilities >= RAREST_RESTING_POSE
    shares = rounded(probabilities[kept] / probabilities[kept].sum())
    poses = [
        RestingPose(transform[:3, :3], float(transform[2, 3]), float(share))
        for transform, share in zip(rounded(transforms[kept]), shares, strict=True)
    ]
    return tuple(sorted(poses, key=lambda pose: (-pose.probability, *pose.rotation.ravel())))


def _grasp(row: dict[str, Any]) -> Grasp:
    approach, closing, tcp_mm = (_vector(key, row[key], 3) for key in ("approach", "closing", "tcp_mm"))
    X_OT = Pose(np.column_stack([np.cross(closing, approach), closing, approach]), tcp_mm / 1000.0)
    return Grasp(row["name"], X_OT, _positive("half_opening_mm", row["half_opening_mm"]) / 1000.0)
