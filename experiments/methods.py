"""The methods under comparison: an uncertainty and the policy that acts upon it, by name."""

from collections.abc import Callable
from dataclasses import dataclass

from cell.interfaces import Policy
from experiments.errors import UsageError
from experiments.thresholds import Thresholds
from maskval import EnsembleAdd, MaskVal, NoUncertainty, UncertaintyMethod
from policies import Always, Threshold


@dataclass(frozen=True, slots=True)
class Method:
    """What decides in one experiment."""

    uncertainty: UncertaintyMethod
    policy: Policy


def _none(part: str, thresholds: Thresholds) -> Method:
    return Method(NoUncertainty(), Always())


def _maskval(part: str, thresholds: Thresholds) -> Method:
    return Method(MaskVal(), Threshold(thresholds.of(part, "maskval"), thresholds.refine))


def _ensemble_add(part: str, thresholds: Thresholds) -> Method:
    if part not in thresholds.ensemble_add_minimum:
        raise UsageError(f"the thresholds {thresholds.source} have no ensemble_add_minimum_m.{part}")
    return Method(
        EnsembleAdd(minimum_m=thresholds.ensemble_add_minimum[part]),
        Threshold(thresholds.of(part, "ensemble-add"), thresholds.refine),
    )


METHODS: dict[str, Callable[[str, Thresholds], Method]] = {
    "none": _none,
    "ensemble-add": _ensemble_add,
    "maskval": _maskval,
}


def make_method(name: str, part: str, thresholds: Thresholds) -> Method:
    """The method of this name for one kind of part.

    Raises:
        UsageError: there is none, or no threshold for it.
    """
    if name not in METHODS:
        raise UsageError(f"unknown method {name!r}: expected one of {', '.join(METHODS)}")
    return METHODS[name](part, thresholds)
