"""Thresholds per object and method, from a preset of the package or a TOML file of the same form."""

import tomllib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from maskval.ensemble import ENSEMBLE_MAXIMUM_M

_PRESETS = files("experiments") / "presets"
_FORM = "expected refine = u, [grasp.OBJECT] with METHOD = u and [ensemble_add_minimum_m] with OBJECT = m"


@dataclass(frozen=True, slots=True)
class Thresholds:
    """One threshold table.

    Attributes:
        source: the preset's or the file's name.
        refine: u_t,r of all objects and methods.
        grasp: u_t,g by object, then by method.
        ensemble_add_minimum: m by object, where Ensemble-ADD's scale begins.
    """

    source: str
    refine: float
    grasp: dict[str, dict[str, float]]
    ensemble_add_minimum: dict[str, float]

    def of(self, part: str, method: str) -> float:
        """u_t,g of one object and method.

        Raises:
            UsageError: the table has none.
        """
        try:
            return self.grasp[part][method]
        except KeyError:
            has = ", ".join(f"{one} × {other}" for one, row in self.grasp.items() for other in row)
            raise UsageError(f"the thresholds {self.source} have no grasp.{part}.{method}; they have {has}") from None


def load_thresholds(name_or_file: str) -> Thresholds:
    """The preset of this name, or the TOML file.

    Raises:
        UsageError: there is no such preset or file, or it is malformed.
    """
    if name_or_file.endswith(".toml"):
        path = Path(name_or_file)
        if not path.is_file():
            raise UsageError(f"threshold file {name_or_file} does not exist")
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"threshold file {name_or_file} cannot be read: {error}") from error
    else:
        known = sorted(Path(entry.name).stem for entry in _PRESETS.iterdir() if entry.name.endswith(".toml"))
        if name_or_file not in known:
            raise UsageError(
                f"unknown thresholds {name_or_file!r}: expected one of {', '.join(known)}, or the path of a .toml file"
            )
        text = (_PRESETS / f"{name_or_file}.toml").read_text()
    try:
        table = tomllib.loads(text)
        return Thresholds(
            source=name_or_file,
            refine=_in_unit_interval("refine", table["refine"]),
            grasp={
                part: {method: _in_unit_interval(f"grasp.{part}.{method}", u) for method, u in row.items()}
                for part, row in table["grasp"].items()
            },
            ensemble_add_minimum={
                part: _minimum(f"ensemble_add_minimum_m.{part}", value)
                for part, value in table["ensemble_add_minimum_m"].items()
            },
        )
    except KeyError as missing:
        raise UsageError(f"thresholds {name_or_file}: the key {missing} is missing; {_FORM}") from missing
    except (tomllib.TOMLDecodeError, AttributeError, ValueError) as error:
        what = "a table is no table" if isinstance(error, AttributeError) else error
        raise UsageError(f"thresholds {name_or_file}: {what}; {_FORM}") from error


def _in_unit_interval(key: str, value: Any) -> float:
    if not _is_number(value) or not 0.0 <= value <= 1.0:
        raise ValueError(f"expected {key} in [0, 1], got {value!r}")
    return float(value)


def _minimum(key: str, value: Any) -> float:
    if not _is_number(value) or not 0.0 <= value < ENSEMBLE_MAXIMUM_M:
        raise ValueError(f"expected {key} in [0, {ENSEMBLE_MAXIMUM_M:g}) m, got {value!r}")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
