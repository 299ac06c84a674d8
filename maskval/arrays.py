"""Numbers and records that a caller gives: what is none of them is an error of this package, in one line."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from maskval.errors import MaskvalError
from maskval.spelling import shown

_REAL = "fiub"  # kinds of NumPy's


def floats(value: object, name: str, error: type[MaskvalError]) -> NDArray[np.float64]:
    """An array of float64 with what array-like numbers hold; it may be what was given.

    Args:
        value: what was given.
        name: what it is, for the message.
        error: the kind to raise.

    Raises:
        MaskvalError: it has texts, complex numbers, other objects, or rows of different lengths.
    """
    try:
        given = np.asarray(value)
        if given.dtype.kind in _REAL:
            return np.asarray(given, dtype=np.float64)
    except (ValueError, TypeError, OverflowError):
        pass
    raise error(f"{name} must be numbers, all rows of one length, but is {shown(value)}")


def check_kind(value: object, kind: type[Any], name: str, error: type[MaskvalError]) -> None:
    """Raises the error unless the value is of this kind."""
    if not isinstance(value, kind):
        raise error(f"{name} must be a maskval.{kind.__name__}, but is {shown(value)}")
