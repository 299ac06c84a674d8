"""What a calibration reached, as text, as JSON and as lines of a noise file."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.calibration.fit import Fit
from experiments.calibration.targets import Calibration, Prior, values_at

HARDLY = 0.9  # a parameter that keeps more of its prior's standard deviation than this is not determined


@dataclass(frozen=True, slots=True)
class Member:
    """A parameter set drawn around the fit: its values, its figures, whether it fits as well."""

    values: dict[str, float]
    figures: Mapping[tuple[str, str], float | None]
    accepted: bool


@dataclass(frozen=True, slots=True)
class Parameter:
    """A fitted parameter.

    Attributes:
        prior: what was believed before.
        value: the most probable one.
        interval: 95 % of what is believed after the fit.
        left: its standard deviation in units of the prior's, in (0, 1].
    """

    prior: Prior
    value: float
    interval: tuple[float, float]
    left: float

    @property
    def is_determined(self) -> bool:
        """Whether the targets say anything about it."""
        return self.left <= HARDLY


@dataclass(frozen=True, slots=True)
class Fitted:
    """A calibration's result.

    Attributes:
        calibration: targets and priors.
        fits: by section of the noise file.
        reached: the fit's figures, by group and figure.
        members: parameter sets drawn around it.
    """

    calibration: Calibration
    fits: dict[str, Fit]
    reached: Mapping[tuple[str, str], float | None]
    members: list[Member]

    @property
    def parameters(self) -> list[Parameter]:
        """Every fitted parameter."""
        rows = []
        for section, one in self.fits.items():
            priors = self.calibration.priors_of(section)
            ends = [values_at(priors, one.z + sign * 1.96 * one.sd) for sign in (-1.0, 1.0)]
            for prior, value, left in zip(priors, values_at(priors, one.z).values(), one.sd, strict=True):
                rows.append(Parameter(prior, value, (ends[0][prior.name], ends[1][prior.name]), float(left)))
        return rows

    def lines(self) -> dict[str, tuple[float, str]]:
        """Value and source of each fitted parameter, for the noise file."""
        return {
            one.prior.name: (
                one.value,
                f"fitted, {one.interval[0]:.2g} to {one.interval[1]:.2g}"
                + ("" if one.is_determined else ", hardly determined"),
            )
            for one in self.parameters
        }


def format_report(name: str, images: int, fitted: Fitted) -> str:
    """Target, reached and sd of each figure; each parameter before and after; what is not determined."""
    lines = [f"{name}: fitted on {images} images", "", f"{'target':24} {'paper':>8} {'reached':>8} {'sd':>7}"]
    for target in fitted.calibration.targets:
        value = fitted.reached[target.group, target.figure]
        found = "-" if value is None else f"{value:.3f}"
        lines.append(f"{f'{target.group} {target.figure}':24} {target.value:8.3f} {found:>8} {target.sd:7.4f}")
    lines += ["", f"{'parameter':36} {'before':>9} {'fitted':>9} {'95 %':>20}  sd left"]
    for one in fitted.parameters:
        ends = f"{one.interval[0]:.3g} to {one.interval[1]:.3g}"
        lines.append(f"{one.prior.name:36} {one.prior.center:9.4g} {one.value:9.4g} {ends:>20}  {one.left:7.0%}")
    free = [one.prior.name for one in fitted.parameters if not one.is_determined]
    combinations = {section: f"{one.determined} of {len(one.z)}" for section, one in fitted.fits.items()}
    lines += [
        "",
        "combinations that the targets say more about than the priors: "
        + ", ".join(f"{section} {count}" for section, count in combinations.items()),
        f"not determined by the targets: {', '.join(free) or 'none'}",
        f"parameter sets drawn around the fit that fit as well: {_accepted(fitted)} of {len(fitted.members)}",
    ]
    return "\n".join(lines)


def as_json(name: str, images: int, fitted: Fitted) -> dict[str, Any]:
    """The result for other programs; figures by "group figure"."""
    return {
        "object": name,
        "images": images,
        "targets": [
            {
                "group": target.group,
                "figure": target.figure,
                "value": target.value,
                "sd": target.sd,
                "reached": fitted.reached[target.group, target.figure],
            }
            for target in fitted.calibration.targets
        ],
        "parameters": [
            {
                "name": one.prior.name,
                "before": one.prior.center,
                "fitted": one.value,
                "interval": one.interval,
                "sd_left": one.left,
                "determined": one.is_determined,
            }
            for one in fitted.parameters
        ],
        "combinations_determined": {section: one.determined for section, one in fitted.fits.items()},
        "rounds": {section: one.rounds for section, one in fitted.fits.items()},
        "covariance": {section: np.round(one.covariance, 6).tolist() for section, one in fitted.fits.items()},
        "members": [
            {
                "values": member.values,
                "figures": {" ".join(key): value for key, value in member.figures.items()},
                "accepted": member.accepted,
            }
            for member in fitted.members
        ],
    }


def _accepted(fitted: Fitted) -> int:
    return sum(member.accepted for member in fitted.members)
