"""Conditions such as `ap(maskval) >= 0.99`, upon which a run stops: read from text, and judged."""

import re
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from statistics import fmean
from typing import Literal

from experiments.errors import UsageError
from experiments.statistics.sequential import confidence_sequence, is_above, units_of
from maskval.inputs.spelling import number as parsed

Quantity = Literal["ap", "ar", "placed", "failed"]
RATES: tuple[Quantity, ...] = ("ap", "ar")
COUNTS: tuple[Quantity, ...] = ("placed", "failed")

_CALL = r"\s*(\w+)\s*\(\s*([^()\s]+)\s*\)\s*"
_FORM = re.compile(rf"\s*(?:([^()\s]+):)?{_CALL}(>=|<=|>|<)(?:{_CALL}|\s*([^()\s]+)\s*)")
_EXAMPLES = '"ap(maskval) >= 0.99", "placed(maskval) > placed(ensemble-add)" or "handle:failed(a) < failed(b)"'


@dataclass(frozen=True, slots=True)
class Condition:
    """What is asked: whether a mean over experiments is above or below a bound, or another method's.

    Attributes:
        quantity: ap, ar (rates of an experiment), placed or failed (parts of an experiment: TP, FP).
        method: name of the method, or package.module:Class.
        above: whether the condition is > or >=, which are the same here; else it is < or <=.
        bound: in the unit of the quantity; None if it is compared with another method.
        other: name of that method; None if it is compared with a bound.
        part: name of the part that it is about; None for every part by itself.
    """

    quantity: Quantity
    method: str
    above: bool
    bound: float | None
    other: str | None
    part: str | None


@dataclass(frozen=True, slots=True)
class Judgement:
    """What the experiments so far say about a condition.

    Attributes:
        holds: True or False once it is answered; None before.
        experiments: how many of the planned experiments, from the first one, the answer took; None before.
        observations: what it rests on, in the unit of the quantity: of each experiment, or round over all worlds.
        lowest: smallest possible observation.
        highest: largest possible one.
        alpha: error rate at all looks together.
    """

    holds: bool | None
    experiments: int | None
    observations: tuple[float, ...]
    lowest: float
    highest: float
    alpha: float

    @property
    def mean(self) -> float | None:
        """Of the observations; None without any."""
        return fmean(self.observations) if self.observations else None

    def interval(self) -> tuple[float, float]:
        """That of the true mean, which holds at every look; see `confidence_sequence`."""
        return confidence_sequence(self.observations, self.lowest, self.highest, self.alpha)


def parse_condition(text: str) -> Condition:
    """The condition that a text states.

    Raises:
        UsageError: it is none, or one that has no answer.
    """
    found = _FORM.fullmatch(text)
    if not found:
        raise UsageError(f'expected a condition such as {_EXAMPLES}, got "{text}"')
    part, name, method, relation, other_name, other, number = found.groups()
    quantity = next((known for known in RATES + COUNTS if known == name), None)
    if quantity is None:
        raise UsageError(f'expected ap, ar, placed or failed in "{text}", got {name}')
    if other is not None and (other_name != name or other == method):
        raise UsageError(f'expected {name} of another method on the right of "{text}", got {other_name}({other})')
    bound = None if number is None else _bound(quantity, number, text)
    return Condition(quantity, method, relation[0] == ">", bound, other, part)


def judge(
    condition: Condition,
    values: Sequence[float | None],
    others: Sequence[float | None] | None = None,
    *,
    worlds: Sequence[Hashable],
    parts: int,
    alpha: float = 0.05,
) -> Judgement:
    """Whether the condition holds, by the experiments so far; see `units_of` and `is_above`.

    The answer is false with probability `alpha` at most, for this condition and one part.

    Args:
        condition: What is asked.
        values: The quantity with `condition.method` of each experiment, in the order planned and without a gap; None
            for one that failed or in which a rate is undefined.
        others: The same with `condition.other`, on the same experiments; None if there is no other method.
        worlds: Label of each planned experiment's world; of those to come too.
        parts: Number of parts in an experiment, which no count exceeds.
        alpha: Error rate at all looks together, in (0, 1).
    """
    if (others is None) != (condition.other is None):
        raise ValueError(f"expected values of {condition.other or 'one method only'}, got {others}")
    most = 1.0 if condition.quantity in RATES else float(parts)
    if others is None:
        assert condition.bound is not None  # there is a bound or another method
        units, bound, lowest = units_of(values, worlds), condition.bound, 0.0
        if bound >= most:
            raise UsageError(f"expected {condition.quantity} held against less than {most:g}, got {bound:g}")
    else:
        units, bound, lowest = units_of(_differences(values, others), worlds), 0.0, -most
    answer = is_above(units.values, bound, lowest, most, alpha)
    used = units.values[: answer.units]
    if answer.above is None:
        return Judgement(None, None, used, lowest, most, alpha)
    holds, experiments = answer.above == condition.above, units.experiments[answer.units - 1]
    return Judgement(holds, experiments, used, lowest, most, alpha)


def _differences(values: Sequence[float | None], others: Sequence[float | None]) -> list[float | None]:
    return [None if a is None or b is None else a - b for a, b in zip(values, others, strict=True)]


def _bound(quantity: Quantity, number: str, text: str) -> float:
    most = 1.0 if quantity in RATES else float("inf")
    try:
        bound = parsed(number)
    except ValueError:
        raise UsageError(f'expected a number or {quantity}(METHOD) on the right of "{text}", got {number}') from None
    if not 0 < bound < most:
        limit = "a rate between 0 and 1" if quantity in RATES else "parts per experiment, above 0"
        raise UsageError(f'expected {limit}, on the right of "{text}", got {number}')
    return bound
