"""Arguments as arrays of numbers: text, gaps and ragged lists are errors of this package, not NumPy's."""

import math
from numbers import Real
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidArgumentError, MaskvalError
from maskval.inputs.spelling import shown


def floats(name: str, value: ArrayLike, error: type[MaskvalError] = InvalidArgumentError) -> NDArray[np.float64]:
    """An argument as a new array of 64-bit numbers, which need not be finite.

    Args:
        name: Of the argument, for the error.
        value: What was given.
        error: The class of the error.

    Raises:
        MaskvalError: If it does not hold real numbers only, or is ragged.
    """
    array = _array(name, value, error)
    if array.dtype == np.float64:
        return array
    if array.dtype.kind not in "biuf":
        _refuse(name, value, error)
    return array.astype(np.float64)


def wholes(name: str, value: ArrayLike, error: type[MaskvalError] = InvalidArgumentError) -> NDArray[np.int64]:
    """An argument as a new array of whole numbers; see `floats`."""
    array = floats(name, value, error)
    if not (np.abs(array) < 2**53).all() or (array != np.floor(array)).any():
        raise error(f"{name} must be whole numbers, but is {shown(value)}")
    return array.astype(np.int64)


def check_number(
    name: str,
    value: Any,
    error: type[MaskvalError] = InvalidArgumentError,
    *,
    least: float = -math.inf,
    most: float = math.inf,
    ends: str = "[]",
) -> None:
    """Raises `error` unless an argument is a number of a range; [ and ] say that an end belongs to it."""
    is_number = isinstance(value, Real | np.number) and not isinstance(value, bool | np.complexfloating)
    if (
        not is_number
        or not least <= value <= most
        or (value, ends[0]) == (least, "(")
        or (value, ends[1]) == (most, ")")
    ):
        span = "a number" if least == -math.inf else f">= {least:g}"
        if most < math.inf:
            span = f"in {ends[0]}{least:g}, {most:g}{ends[1]}"
        raise error(f"{name} must be {span}, but is {shown(value)}")


def check_kind(name: str, value: object, kind: type[Any], error: type[MaskvalError]) -> None:
    """Raises the error unless the value is of this kind."""
    if not isinstance(value, kind):
        raise error(f"{name} must be a maskval.{kind.__name__}, but is {shown(value)}")


def _array(name: str, value: ArrayLike, error: type[MaskvalError]) -> NDArray[Any]:
    try:
        return np.array(value)
    except (TypeError, ValueError):
        _refuse(name, value, error)


def _refuse(name: str, value: object, error: type[MaskvalError]) -> NoReturn:
    raise error(f"{name} must be real numbers, but is {shown(value)}")
