"""What an error model is fitted to: the targets and what was believed of its parameters before, from one TOML file."""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.errors import UsageError
from experiments.results.paper import calibration_text, parts_with_figures
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from sim.errors import NoiseFileError
from sim.networks.noise_model import PartNoise, bounds

FIGURES = {  # by group of targets: what `graspcell dataset` prints
    "mask": ("ap_50_95", "ap_50", "ar_100"),
    "maskval": ("spearman", "auc_ar", "u_tg"),
    "ensemble-add": ("spearman", "auc_ar", "u_tg"),
}
GROUPS = {"mask": ("mask",), "pose": ("maskval", "ensemble-add")}  # of targets, by the section of what they determine
_FORM = "expected [target.GROUP] with FIGURE = { value, sd } and [prior.SECTION] with KEY = { center, spread }"

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FitTarget:
    """A figure of the paper's tables.

    Attributes:
        group: "mask", or a method.
        figure: name of the figure.
        value: the paper's.
        sd: how far a fitted model may be from it, one standard deviation.
    """

    group: str
    figure: str
    value: float
    sd: float


@dataclass(frozen=True, slots=True)
class Prior:
    """What is believed of a parameter before the fit: normal in a coordinate that has no ends.

    The coordinate is the logarithm of what has no upper end, the logit of a share or probability, the artanh of a
    correlation.

    Attributes:
        name: "section.key" of the noise file.
        center: the parameter's value in the middle.
        spread: standard deviation of the coordinate.
    """

    name: str
    center: float
    spread: float

    @property
    def section(self) -> str:
        """Of the noise file."""
        return self.name.partition(".")[0]

    def value(self, z: float) -> float:
        """The parameter z standard deviations above the middle, held within its range."""
        low, high = bounds(self.name)
        x = _coordinate(self.center, low, high) + z * self.spread
        if low < 0.0:
            return math.tanh(x)
        return min(high, 1.0 / (1.0 + math.exp(-x)) if high <= 1.0 else math.exp(x))

    def z(self, value: float) -> float:
        """How many standard deviations above the middle a value is.

        Raises:
            ValueError: it lies at an end of the parameter's range.
        """
        ends = bounds(self.name)
        return (_coordinate(value, *ends) - _coordinate(self.center, *ends)) / self.spread


@dataclass(frozen=True, slots=True)
class Calibration:
    """Targets and priors of one kind of part."""

    targets: tuple[FitTarget, ...]
    priors: tuple[Prior, ...]

    def targets_of(self, *groups: str) -> tuple[FitTarget, ...]:
        """The targets of these groups."""
        return tuple(target for target in self.targets if target.group in groups)

    def priors_of(self, section: str) -> tuple[Prior, ...]:
        """The priors of the parameters of a section."""
        return tuple(prior for prior in self.priors if prior.section == section)


def values_at(priors: tuple[Prior, ...], z: Array) -> dict[str, float]:
    """The parameters' values at z, (D,), in standard deviations of their priors."""
    return {prior.name: prior.value(float(one)) for prior, one in zip(priors, z, strict=True)}


def load_calibration(name_or_file: str, noise: PartNoise) -> Calibration:
    """The preset of this name, or the TOML file.

    Args:
        name_or_file: What to read.
        noise: The error model whose parameters it is about.

    Raises:
        UsageError: there is no such preset or file, or it is malformed.
    """
    text = _read(name_or_file)
    try:
        table = tomllib.loads(text)
        targets = tuple(
            FitTarget(group, figure, _number(row, "value"), _positive(row, "sd"))
            for group, rows in table["target"].items()
            for figure, row in rows.items()
        )
        priors = tuple(
            Prior(f"{section}.{key}", _number(row, "center"), _positive(row, "spread"))
            for section, rows in table["prior"].items()
            for key, row in rows.items()
        )
        for target in targets:
            if target.figure not in FIGURES.get(target.group, ()):
                raise ValueError(f"unknown target {target.group}.{target.figure}")
        if not targets or not priors:
            raise ValueError("no targets or no priors")
        noise.changed({prior.name: prior.center for prior in priors})
        for prior in priors:
            groups = GROUPS.get(prior.section, ())
            if not any(target.group in groups for target in targets):
                asked = f"expected a target of {' or '.join(groups)}" if groups else "no target determines it"
                raise ValueError(f"prior {prior.name} has no target: {asked}")
        for prior in priors:
            _coordinate(prior.center, *bounds(prior.name))
    except KeyError as missing:
        raise UsageError(f"calibration {name_or_file}: the key {missing} is missing; {_FORM}") from missing
    except (tomllib.TOMLDecodeError, AttributeError, TypeError, ValueError, NoiseFileError) as error:
        raise UsageError(f"calibration {name_or_file}: {error}; {_FORM}") from error
    return Calibration(targets, priors)


def _read(name_or_file: str) -> str:
    if not name_or_file.endswith(".toml"):
        known = parts_with_figures()
        if name_or_file not in known:
            raise UsageError(
                f"no calibration for {name_or_file!r}: expected one of {', '.join(known)}, or --targets FILE.toml"
            )
        return calibration_text(name_or_file)
    try:
        return read_input_text(Path(name_or_file))
    except InvalidFileError as error:
        raise UsageError(f"calibration file {error}") from error


def _coordinate(value: float, low: float, high: float) -> float:
    """The coordinate without ends of a parameter within its bounds."""
    least = -1.0 if low < 0.0 else 0.0
    if not least < value < (1.0 if high <= 1.0 else math.inf):
        raise ValueError(f"expected a value inside its parameter's range, not at its end, got {value:g}")
    if low < 0.0:
        return math.atanh(value)
    return math.log(value / (1.0 - value)) if high <= 1.0 else math.log(value)


def _number(row: dict[str, Any], key: str) -> float:
    value = row[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"expected {key} to be a number, got {value!r}")
    return float(value)


def _positive(row: dict[str, Any], key: str) -> float:
    value = _number(row, key)
    if value <= 0.0:
        raise ValueError(f"expected {key} above 0, got {value:g}")
    return value
