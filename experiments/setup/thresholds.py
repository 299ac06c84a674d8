"""Thresholds per object and method, from a preset of the package or a TOML file of the same form."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Self

from experiments.errors import UsageError
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from maskval.inputs.spelling import nearest, number
from maskval.methods.ensemble import ENSEMBLE_MAXIMUM_M

_PRESETS = files("experiments") / "presets"
_FORM = (
    "expected refine = u, [grasp.OBJECT] with METHOD = u, [ensemble_add_minimum_m] with OBJECT = m, "
    "and optionally [least_error.OBJECT] with METHOD = u"
)

_OF_SIMULATED = "it is that of the simulated networks; graspcell dataset --estimator networks derives your own"


@dataclass(frozen=True, slots=True)
class Thresholds:
    """One threshold table.

    Attributes:
        source: the preset's or the file's name.
        refine: u_t,r of all objects and methods.
        grasp: u_t,g by object, then by method.
        ensemble_add_minimum: m by object, where Ensemble-ADD's scale begins.
        least_error: u_t,g by object and method where none reaches the demanded AP: the u of the fewest errors.
        told: u_t,g by method, for all objects; takes precedence.
        caution: what to know about all that were not told.
    """

    source: str
    refine: float
    grasp: dict[str, dict[str, float]]
    ensemble_add_minimum: dict[str, float]
    least_error: dict[str, dict[str, float]] = field(default_factory=dict)
    told: dict[str, float] = field(default_factory=dict)
    caution: str | None = None

    def of(self, part: str, method: str, own: float | None = None, *, source: str | None = None) -> float:
        """u_t,g of one object and method.

        Args:
            part: the object's name.
            method: the method's name.
            own: the method's own, where there is no other.
            source: name or file of the object, for the message; its name by default.

        Raises:
            UsageError: there is none.
        """
        for found in (
            self.told.get(method),
            self.grasp.get(part, {}).get(method),
            self.least_error.get(part, {}).get(method),
            own,
        ):
            if found is not None:
                return found
        has = ", ".join(f"{one} × {other}" for one, row in self.grasp.items() for other in row)
        raise UsageError(
            f"the thresholds {self.source} have no grasp.{part}.{method}; they have {has}; "
            f"give one with --u-grasp {method}=U, or derive it with graspcell dataset --objects {source or part} "
            f"--methods {method} and add --thresholds out/dataset/thresholds.toml"
        )

    def caveat(self, part: str, method: str) -> str | None:
        """A caveat about an object's and method's u_t,g; None if it was given, or reaches the demanded AP."""
        if method in self.told:
            return None
        if self.caution is not None:
            return self.caution
        if method in self.grasp.get(part, {}):
            return None
        if method in self.least_error.get(part, {}):
            return "no u reaches the AP on the test images; it is the u of least error"
        return f"the thresholds {self.source} have none; it is the method's own"

    def with_told(self, options: Sequence[str], methods: Sequence[str]) -> Self:
        """These thresholds, with those that options METHOD=U give.

        Raises:
            UsageError: an option is malformed, or names a method that is not used.
        """
        told = {}
        for option in options:
            method, _, value = option.rpartition("=")
            if method in told:
                raise UsageError(f"expected --u-grasp {method}=U once, got it twice")
            if method not in methods:
                raise UsageError(f"expected --u-grasp METHOD=U of {', '.join(methods)}, got {option!r}")
            try:
                told[method] = _in_unit_interval(f"--u-grasp {method}", number(value))
            except ValueError:
                raise UsageError(f"expected --u-grasp {method}=U with U in [0, 1], got {option!r}") from None
        return replace(self, told=told)


def load_thresholds(name_or_file: str, *, networks: bool = False) -> Thresholds:
    """The preset of this name, or the TOML file.

    Args:
        name_or_file: which.
        networks: whether they are for trained networks; the presets are those of the simulated ones, which is said.

    Raises:
        UsageError: there is no such preset or file, or it is malformed.
    """
    if name_or_file.endswith(".toml"):
        try:
            text = read_input_text(Path(name_or_file))
        except InvalidFileError as error:
            raise UsageError(f"threshold file {error}") from error
    else:
        known = sorted(Path(entry.name).stem for entry in _PRESETS.iterdir() if entry.name.endswith(".toml"))
        if name_or_file not in known:
            raise UsageError(
                f"unknown thresholds {name_or_file!r}: expected one of {', '.join(known)}, or the path of a .toml file"
                f"{nearest(name_or_file, known)}"
            )
        text = (_PRESETS / f"{name_or_file}.toml").read_text()
    preset = not name_or_file.endswith(".toml")
    try:
        table = tomllib.loads(text)
        return Thresholds(
            source=name_or_file,
            refine=_in_unit_interval("refine", table["refine"]),
            grasp=_by_object("grasp", table["grasp"]),
            ensemble_add_minimum={
                part: _minimum(f"ensemble_add_minimum_m.{part}", value)
                for part, value in table["ensemble_add_minimum_m"].items()
            },
            least_error=_by_object("least_error", table.get("least_error", {})),
            caution=_OF_SIMULATED if networks and preset else None,
        )
    except KeyError as missing:
        raise UsageError(f"thresholds {name_or_file}: the key {missing} is missing; {_FORM}") from missing
    except (tomllib.TOMLDecodeError, AttributeError, ValueError) as error:
        what = "expected a table, got a value" if isinstance(error, AttributeError) else error
        raise UsageError(f"thresholds {name_or_file}: {what}; {_FORM}") from error


def _by_object(key: str, table: dict[str, Any]) -> dict[str, dict[str, float]]:
    return {
        part: {method: _in_unit_interval(f"{key}.{part}.{method}", u) for method, u in row.items()}
        for part, row in table.items()
    }


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
