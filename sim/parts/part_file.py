"""A part's file as checked rows: every key known, of its type and in its range, or one line says what is wrong."""

import math
import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from cell.layout import Gripper
from cell.part import MAX_TILT_DEG
from sim.errors import PartFileError

MASS_KG = (0.001, 8.0)  # the UR10 carries 10 kg, of which the gripper takes 1.6
FRICTION = (0.05, 2.0)  # Teflon on steel 0.04, rubber on dry concrete 1
SLOT_MM = (20.0, 500.0)
PLACE_MM = 1000.0  # of numbers that the mesh bounds later on
MOST_PIECES, MOST_GRASPS, MOST_POSES, MOST_TURNS = 128, 64, 64, 16
MOST_FOLD = 360
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,59}")
_UNIT = 1e-4  # by how much a direction's length may differ from 1

Row = dict[str, Any]
Vector = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class GraspRow:
    """A grasp as the file has it."""

    name: str
    tcp_mm: Vector
    approach: Vector
    closing: Vector
    half_opening_mm: float
    max_tilt_deg: float


@dataclass(frozen=True, slots=True)
class PoseRow:
    """A stable pose as the file has it: the direction in O that points up, and how likely it is."""

    up: Vector
    probability: float


@dataclass(frozen=True, slots=True)
class TurnRow:
    """A symmetry as the file has it: an axis, a point on it, and equal turns that make a full one; 0 for any angle."""

    axis: Vector
    point_mm: Vector
    fold: int


@dataclass(frozen=True, slots=True)
class MeshRow:
    """Where the shape comes from: a generator with its arguments, or a file with convex pieces."""

    file: str | None
    pieces: tuple[str, ...] | None
    generator: str | None
    arguments: Row


@dataclass(frozen=True, slots=True)
class PartFile:
    """All of a part's file."""

    name: str
    mass_kg: float
    friction: float
    rgba: Vector
    specular: float
    shininess: float
    noise: str
    mesh: MeshRow
    slot_mm: Vector
    grasps: tuple[GraspRow, ...]
    poses: tuple[PoseRow, ...]
    symmetries: tuple[TurnRow, ...]


def read_part_file(text: str) -> PartFile:
    """The rows of a part's file.

    Raises:
        PartFileError: no TOML, or a key is missing, unknown, of a wrong type or out of its range.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise PartFileError(f"no TOML: {error}") from error
    except RecursionError as error:
        raise PartFileError("no TOML of a part: expected tables and lists of a few levels, got a deep nest") from error
    needed = ("name", "mass_kg", "friction", "rgba", "specular", "shininess", "mesh", "slot", "grasps")
    _check_keys("", table, needed, ("noise", "poses", "symmetries"))
    slot = _table("slot", table["slot"])
    _check_keys("slot.", slot, ("size_mm",))
    name = _name("name", table["name"])
    return PartFile(
        name=name,
        mass_kg=_number("mass_kg", table["mass_kg"], *MASS_KG),
        friction=_number("friction", table["friction"], *FRICTION),
        rgba=_vector("rgba", table["rgba"], 4, 0.0, 1.0),
        specular=_number("specular", table["specular"], 0.0, 1.0),
        shininess=_number("shininess", table["shininess"], 0.0, 1.0),
        noise=_text("noise", table.get("noise", name)),
        mesh=_mesh(_table("mesh", table["mesh"])),
        slot_mm=_vector("slot.size_mm", slot["size_mm"], 2, *SLOT_MM),
        grasps=_grasps(_rows("grasps", table["grasps"], 1, MOST_GRASPS)),
        poses=_poses(_rows("poses", table.get("poses", []), 0, MOST_POSES)),
        symmetries=_turns(_rows("symmetries", table.get("symmetries", []), 0, MOST_TURNS)),
    )


def _mesh(table: Row) -> MeshRow:
    if "generator" in table:
        generator = _text("mesh.generator", table["generator"])
        return MeshRow(None, None, generator, {key: value for key, value in table.items() if key != "generator"})
    _check_keys("mesh.", table, ("file",), ("pieces",))
    pieces = table.get("pieces")
    if pieces is not None:
        if not isinstance(pieces, list) or not 1 <= len(pieces) <= MOST_PIECES:
            raise _wrong("mesh.pieces", f"1 to {MOST_PIECES} names of files", _shown(pieces))
        pieces = tuple(_inside(f"mesh.pieces[{index}]", piece) for index, piece in enumerate(pieces))
    return MeshRow(_inside("mesh.file", table["file"]), pieces, None, {})


def _grasps(rows: Sequence[tuple[str, Row]]) -> tuple[GraspRow, ...]:
    grasps: dict[str, GraspRow] = {}
    widest_mm = 1000.0 * Gripper().max_half_opening
    for key, row in rows:
        _check_keys(key, row, ("name", "tcp_mm", "approach", "closing", "half_opening_mm"), ("max_tilt_deg",))
        grasp = GraspRow(
            name=_name(f"{key}name", row["name"]),
            tcp_mm=_vector(f"{key}tcp_mm", row["tcp_mm"], 3, -PLACE_MM, PLACE_MM),
            approach=_direction(f"{key}approach", row["approach"]),
            closing=_direction(f"{key}closing", row["closing"]),
            half_opening_mm=_number(f"{key}half_opening_mm", row["half_opening_mm"], 1.0, widest_mm),
            max_tilt_deg=_number(f"{key}max_tilt_deg", row.get("max_tilt_deg", MAX_TILT_DEG), 1.0, MAX_TILT_DEG),
        )
        if abs(sum(a * c for a, c in zip(grasp.approach, grasp.closing, strict=True))) > _UNIT:
            raise PartFileError(
                f"{key}closing: expected a direction at a right angle to the approach (orthonormal axes), "
                f"got {row['closing']} with {row['approach']}"
            )
        if grasp.name in grasps:
            raise _wrong(f"{key}name", "another name than those of the other grasps", repr(grasp.name))
        grasps[grasp.name] = grasp
    return tuple(grasps.values())


def _poses(rows: Sequence[tuple[str, Row]]) -> tuple[PoseRow, ...]:
    poses = []
    for key, row in rows:
        _check_keys(key, row, ("up", "probability"))
        probability = _number(f"{key}probability", row["probability"], 1e-6, 1.0)
        poses.append(PoseRow(_direction(f"{key}up", row["up"]), probability))
    total = sum(pose.probability for pose in poses)
    if poses and not 0.5 <= total <= 1.001:
        raise _wrong("poses", "probabilities that add up to 0.5 to 1", f"{total:g}")
    return tuple(poses)


def _turns(rows: Sequence[tuple[str, Row]]) -> tuple[TurnRow, ...]:
    turns = []
    for key, row in rows:
        _check_keys(key, row, ("axis", "point_mm", "fold"))
        fold = row["fold"]
        if isinstance(fold, bool) or not isinstance(fold, int) or not (fold == 0 or 2 <= fold <= MOST_FOLD):
            raise _wrong(f"{key}fold", f"0 for any angle, or a whole number in 2..{MOST_FOLD}", _shown(fold))
        point = _vector(f"{key}point_mm", row["point_mm"], 3, -PLACE_MM, PLACE_MM)
        turns.append(TurnRow(_direction(f"{key}axis", row["axis"]), point, fold))
    return tuple(turns)


def _check_keys(where: str, table: Row, needed: Sequence[str], optional: Sequence[str] = ()) -> None:
    for key in needed:
        if key not in table:
            raise PartFileError(f"{where}the key {key!r} is missing" if not where else f"{where}{key} is missing")
    for key in table:
        if key not in (*needed, *optional):
            raise PartFileError(f"unknown key {where + key!r}: expected {', '.join((*needed, *optional))}")


def _table(key: str, value: Any) -> Row:
    if not isinstance(value, dict):
        raise _wrong(key, "a table", _shown(value))
    return value


def _rows(key: str, value: Any, least: int, most: int) -> list[tuple[str, Row]]:
    if not isinstance(value, list) or not least <= len(value) <= most:
        raise _wrong(key, f"{least} to {most} rows", _shown(value))
    return [(f"{key}[{index}].", _table(f"{key}[{index}]", row)) for index, row in enumerate(value)]


def _number(key: str, value: Any, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise _wrong(key, f"a number in {low:g}..{high:g}", _shown(value))
    return float(value)


def _vector(key: str, value: Any, length: int, low: float, high: float) -> Vector:
    if not isinstance(value, list) or len(value) != length:
        raise _wrong(key, f"{length} numbers", _shown(value))
    return tuple(_number(f"{key}[{index}]", entry, low, high) for index, entry in enumerate(value))


def _direction(key: str, value: Any) -> Vector:
    axis = _vector(key, value, 3, -2.0, 2.0)
    length = math.hypot(*axis)
    if abs(length - 1.0) > _UNIT:
        raise _wrong(key, "a direction of length 1 (orthonormal axes)", f"{value} of length {length:.4g}")
    return axis


def _text(key: str, value: Any) -> str:
    if not isinstance(value, str) or not 1 <= len(value) <= 1000 or not value.isprintable():
        raise _wrong(key, "a printable text of 1 to 1000 characters", _shown(value))
    return value


def _inside(key: str, value: Any) -> str:
    """A path that stays in the folder of the part's file, which is then all that a part is made from."""
    path = PurePath(_text(key, value))
    if path.is_absolute() or ".." in path.parts:
        raise _wrong(key, "a file in the folder of the part's file", _shown(value))
    return str(value)


def _name(key: str, value: Any) -> str:
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise _wrong(key, "1 to 60 letters, digits, _ . or -, the first a letter or digit", _shown(value))
    return value


def _wrong(key: str, expected: str, got: str) -> PartFileError:
    return PartFileError(f"{key}: expected {expected}, got {got}")


def _shown(value: object) -> str:
    try:
        shown = repr(value)
    except ValueError:  # of an integer of thousands of digits
        return "a number of too many digits"
    return shown if len(shown) <= 80 else f"{shown[:77]}..."
