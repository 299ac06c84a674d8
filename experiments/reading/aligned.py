"""Rows as aligned text that fits a terminal."""

import textwrap
from collections.abc import Sequence
from decimal import Decimal
from typing import Any

NULL = "–"
_GAP = "  "
_NARROWEST = 8  # characters that a column of words is shortened to before columns are left out


def aligned(names: Sequence[str], rows: Sequence[Sequence[Any]], width: int) -> str:
    """A table with a header. Words are shortened to fit, numbers are not; a last line names columns without room.

    Args:
        names: of the columns.
        rows: of values.
        width: characters per line.
    """
    numeric = [all(row[column] is None or _is_number(row[column]) for row in rows) for column in range(len(names))]
    cells = [list(names), *([text_of(value) for value in row] for row in rows)]
    widths = [max(len(row[column]) for row in cells) for column in range(len(names))]
    shown = _fitted(widths, numeric, width)
    lines = []
    for row in cells:
        texts = [_shortened(row[column], widths[column]) for column in range(shown)]
        placed = [
            text.rjust(size) if number else text.ljust(size)
            for text, size, number in zip(texts, widths, numeric, strict=False)  # those that are shown
        ]
        lines.append(_GAP.join(placed).rstrip())
    lines.insert(1, "-" * max(map(len, lines)))
    if shown < len(names):
        lines += textwrap.wrap(f"no room for {', '.join(names[shown:])}: --csv or --json prints all", width)
    return "\n".join(lines)


def text_of(value: Any) -> str:
    """A value as a person reads it: numbers to six digits, in one line."""
    match value:
        case None:
            return NULL
        case bool():
            return str(value).lower()
        case float() | Decimal():
            return f"{value:.6g}"
        case list() | tuple():
            return f"[{', '.join(map(text_of, value))}]"
    return " ".join(str(value).split())


def _fitted(widths: list[int], numeric: Sequence[bool], width: int) -> int:
    """Shortens the widest columns of words until the line fits; returns how many columns then have room."""
    while _line(widths) > width:
        wide = [column for column, number in enumerate(numeric) if not number and widths[column] > _NARROWEST]
        if not wide:
            break
        widths[max(wide, key=lambda column: widths[column])] -= 1
    shown = len(widths)
    while shown > 1 and _line(widths[:shown]) > width:
        shown -= 1
    return shown


def _line(widths: Sequence[int]) -> int:
    return sum(widths) + len(_GAP) * (len(widths) - 1)


def _shortened(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: width - 1]}…"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | Decimal) and not isinstance(value, bool)
