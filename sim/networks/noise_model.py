"""The error models' parameters: one commented TOML file per part, checked on the way in.

What each parameter means, its unit and its source stand in the files, `sim/assets/noise/*.toml`; how it acts stands
in `sim.networks.pose_noise` and `sim.networks.mask_noise`. The records have the files' sections and keys, one to one.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from maskval.inputs.spelling import nearest, shown
from sim.errors import NoiseFileError

_NOISE_FOLDER = files("sim") / "assets" / "noise"
_LARGEST = 1e3  # what has no natural upper end is still no larger than this
T = TypeVar("T")


def _number(low: float, high: float) -> Any:
    """A field that must be a number in [low, high]; it has no default: the file says every value."""
    return field(metadata={"low": low, "high": high})


@dataclass(frozen=True, slots=True)
class ViewNoise:
    """How fast errors change from view to view, and how much of them from picture to picture."""

    direction_length_deg: float = _number(0.1, _LARGEST)
    distance_length: float = _number(0.01, _LARGEST)
    camera_length_mm: float = _number(1.0, 1e6)
    renewed_share: float = _number(0.0, 1.0)

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True, slots=True)
class PoseNoise:
    """Errors of the pose estimators S1 (number 0) and S2 (number 1)."""

    flip_axis: tuple[float, float, float]
    reference_distance_mm: float = _number(1.0, 1e5)
    lateral_mm: float = _number(0.0, _LARGEST)
    depth_ratio: float = _number(0.0, 100.0)
    rotation_deg: float = _number(0.0, 180.0)
    in_plane_ratio: float = _number(0.0, 100.0)
    difficulty_gain: float = _number(0.0, 10.0)
    hidden_gain: float = _number(0.0, 10.0)
    outlier_probability: float = _number(0.0, 0.999)
    outlier_difficulty_gain: float = _number(0.0, 10.0)
    outlier_hidden_gain: float = _number(0.0, 100.0)
    flip_share: float = _number(0.0, 1.0)
    gross_rotation_deg: float = _number(0.0, 180.0)
    gross_depth_mm: float = _number(0.0, _LARGEST)
    gross_lateral_mm: float = _number(0.0, _LARGEST)
    second_scale: float = _number(0.0, 100.0)
    second_outlier_odds_ratio: float = _number(0.0, _LARGEST)
    second_difficulty_correlation: float = _number(-1.0, 1.0)
    second_core_correlation: float = _number(-1.0, 1.0)
    second_outlier_correlation: float = _number(-1.0, 1.0)
    second_same_content_share: float = _number(0.0, 1.0)

    def __post_init__(self) -> None:
        _check(self)
        axis: Any = self.flip_axis
        numbers = isinstance(axis, tuple) and len(axis) == 3 and all(_is_number(x) for x in axis)
        if not numbers or not math.isclose(math.hypot(*axis), 1.0):
            raise NoiseFileError(f"flip_axis: expected three numbers of norm 1, got {axis!r}")


@dataclass(frozen=True, slots=True)
class MaskNoise:
    """Errors of the instance segmentation."""

    difficulty_correlation: float = _number(-1.0, 1.0)
    difficulty_gain: float = _number(0.0, 10.0)
    field_cells: float = _number(0.0, 14.0)
    bias_cells: float = _number(-14.0, 14.0)
    box_share: float = _number(0.0, 0.5)
    leak_cells: float = _number(0.0, 14.0)
    drop_probability: float = _number(0.0, 1.0)
    drop_share_min: float = _number(0.0, 1.0)
    drop_share_max: float = _number(0.0, 1.0)
    miss_probability: float = _number(0.0, 1.0)
    miss_visibility: float = _number(0.0, 1.0)
    score_sd: float = _number(0.0, 1.0)
    false_alarms_per_image: float = _number(0.0, 1.0)
    false_alarm_radius_px: float = _number(1.0, 1e4)
    false_alarm_score: float = _number(0.0, 1.0)

    def __post_init__(self) -> None:
        _check(self)
        low, high = self.drop_share_min, self.drop_share_max
        if low > high:
            raise NoiseFileError(f"drop_share_min: expected at most drop_share_max = {high:g}, got {low:g}")


@dataclass(frozen=True, slots=True)
class Timing:
    """What the networks cost of the cell's clock, s per frame."""

    detector_s: float = _number(0.0, 60.0)
    pose_s: float = _number(0.0, 60.0)

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True, slots=True)
class PartNoise:
    """The error model of one kind of part."""

    view: ViewNoise
    pose: PoseNoise
    mask: MaskNoise
    timing: Timing

    def number(self, name: str) -> float:
        """The value of a parameter that is a number.

        Args:
            name: "section.key" as in the file, "pose.lateral_mm" for example.

        Raises:
            NoiseFileError: there is no such parameter, or it is not a number.
        """
        section, key = _numeric(name)
        value: float = getattr(getattr(self, section), key)
        return value

    def changed(self, values: Mapping[str, float]) -> "PartNoise":
        """The model with other values of some parameters.

        Args:
            values: By name, "section.key" as in the file.

        Raises:
            NoiseFileError: there is no such parameter, or its value is out of range.
        """
        rows: dict[str, dict[str, float]] = {}
        for name, value in values.items():
            section, key = _numeric(name)
            rows.setdefault(section, {})[key] = value
        try:
            return replace(self, **{section: replace(getattr(self, section), **row) for section, row in rows.items()})
        except NoiseFileError as error:
            raise NoiseFileError(f"changed noise: {error}") from error


def bounds(name: str) -> tuple[float, float]:
    """The least and the largest value that a parameter may have.

    Args:
        name: "section.key" as in the file.

    Raises:
        NoiseFileError: there is no such parameter, or it is not a number.
    """
    section, key = _numeric(name)
    metadata = next(entry.metadata for entry in fields(SECTIONS[section]) if entry.name == key)
    return metadata["low"], metadata["high"]


def _numeric(name: str) -> tuple[str, str]:
    """Section and key of a parameter that is a number."""
    known = [f"{one}.{entry.name}" for one, record in SECTIONS.items() for entry in fields(record) if entry.metadata]
    if not isinstance(name, str) or name not in known:
        hint = nearest(name, known) if isinstance(name, str) else ""
        raise NoiseFileError(f"unknown noise parameter {shown(name)}: expected one of {', '.join(known)}{hint}")
    section, _, key = name.partition(".")
    return section, key


SECTIONS: dict[str, Any] = {"view": ViewNoise, "pose": PoseNoise, "mask": MaskNoise, "timing": Timing}


def noise_names() -> list[str]:
    """Names of the error models that come with the package."""
    return sorted(Path(entry.name).stem for entry in _NOISE_FOLDER.iterdir() if entry.name.endswith(".toml"))


def load_noise(name_or_file: str) -> PartNoise:
    """The error model of this name, or of this TOML file.

    Raises:
        NoiseFileError: no such model, or a key of its file is unknown, missing, of a wrong type or out of range.
    """
    return read_noise(noise_text(name_or_file), name_or_file)


def noise_text(name_or_file: str) -> str:
    """The text of the error model of this name, or of this TOML file.

    Raises:
        NoiseFileError: there is none, or it cannot be read.
    """
    if name_or_file.endswith(".toml"):
        try:
            return read_input_text(Path(name_or_file))
        except InvalidFileError as error:
            raise NoiseFileError(f"noise file {error}") from error
    if name_or_file not in noise_names():
        raise NoiseFileError(
            f"unknown noise {name_or_file!r}: expected one of {', '.join(noise_names())}, or the path of a .toml file"
            f"{nearest(name_or_file, noise_names())}"
        )
    return (_NOISE_FOLDER / f"{name_or_file}.toml").read_text(encoding="utf-8")


def read_noise(text: str, source: str) -> PartNoise:
    """The error model that a TOML text holds; `source` names it in messages.

    Raises:
        NoiseFileError: see `load_noise`.
    """
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise NoiseFileError(f"{source}: no TOML: {error}") from error
    _check_keys(table, set(SECTIONS), source, "section")
    return PartNoise(
        view=_section(ViewNoise, table, "view", source),
        pose=_section(PoseNoise, table, "pose", source),
        mask=_section(MaskNoise, table, "mask", source),
        timing=_section(Timing, table, "timing", source),
    )


def _section(record: type[T], table: dict[str, Any], section: str, source: str) -> T:
    rows = table[section]
    if not isinstance(rows, dict):
        raise NoiseFileError(f"{source}: {section}: expected a section, got {rows!r}")
    _check_keys(rows, {entry.name for entry in fields(record)}, source, f"key of [{section}]")  # type: ignore[arg-type]
    try:
        return record(**{key: tuple(value) if isinstance(value, list) else value for key, value in rows.items()})
    except NoiseFileError as error:
        raise NoiseFileError(f"{source}: {section}.{error}") from error


def _check_keys(table: dict[str, Any], expected: set[str], source: str, what: str) -> None:
    for key in sorted(set(table) - expected):
        raise NoiseFileError(f"{source}: unknown {what} {key!r}: expected {', '.join(sorted(expected))}")
    for key in sorted(expected - set(table)):
        raise NoiseFileError(f"{source}: missing {what} {key!r}")


def _check(record: Any) -> None:
    """Rejects a value that is not a number in its field's range."""
    for entry in fields(record):
        if "low" not in entry.metadata:
            continue
        value, low, high = getattr(record, entry.name), entry.metadata["low"], entry.metadata["high"]
        if not _is_number(value) or not low <= value <= high:
            raise NoiseFileError(f"{entry.name}: expected a number in [{low:g}, {high:g}], got {value!r}")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
