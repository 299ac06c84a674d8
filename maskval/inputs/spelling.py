"""Numbers and names as people type them: what Python would accept beyond that is a slip, and the nearest name helps."""

import difflib
from collections.abc import Callable, Iterable
from math import isfinite
from numbers import Real
from typing import TypeVar

Number = TypeVar("Number", int, float)

_ALIKE = 0.6  # share of letters in common, difflib's own default


def whole_number(text: str) -> int:
    """The whole number that a text spells with the digits 0 to 9 and a sign: no 1_000, no blanks, no other digits.

    Raises:
        ValueError: it does not.
    """
    return _read(text, int, "a whole number such as 12")


def number(text: str) -> float:
    """The number that a text spells with the digits 0 to 9, a point, a sign and an exponent; also inf and nan.

    Raises:
        ValueError: it does not.
    """
    return _read(text, float, "a number such as 0.12")


def nearest(name: str, valid: Iterable[str]) -> str:
    """A question after the valid name that is most alike, to end a message with; empty if none is."""
    found = difflib.get_close_matches(name, list(valid), 1, _ALIKE)
    return f"; did you mean {found[0]}?" if found else ""


def shown(value: object) -> str:
    """A value as Python writes it, in one line, shortened to what fits it."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # an integer of thousands of digits, or an object whose own repr fails
        return f"a {type(value).__name__} that cannot be shown"
    return text if len(text) <= 80 else f"{text[:77]}..."


def is_finite(value: object) -> bool:
    """Whether a value is a number that a float holds: not infinite, nan or True, nor of hundreds of digits."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:
        return False


def _read(text: str, kind: Callable[[str], Number], what: str) -> Number:
    try:
        if text.isascii() and "_" not in text and text == text.strip():
            return kind(text)
    except ValueError:
        pass
    raise ValueError(f"expected {what}, got {shown(text)}")
