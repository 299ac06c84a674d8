"""How far a command is and how long it will take: on a terminal, and nowhere else."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from tqdm import tqdm

Item = TypeVar("Item")
SHOWN_AFTER = 1.0  # s: a bar of what mostly takes less would only flash


def counted(
    items: Iterable[Item], unit: str, what: str | None = None, total: int | None = None, *, after: float = 0.0
) -> Iterable[Item]:
    """The items, with a bar that counts them.

    Args:
        items: what is gone through.
        unit: what one of them is.
        what: what is done with them.
        total: how many there are, if they do not say it themselves.
        after: s that pass before the bar is shown; what is over sooner is not counted.
    """
    counting: Iterable[Item] = tqdm(items, total=total, delay=after, **_form(unit, what))
    return counting


def bar(unit: str, what: str | None = None, total: int | None = None, done: int = 0) -> "tqdm[Any]":
    """A bar to `update`, and to close; it opens as a context.

    Args:
        unit: what is counted.
        what: what is done.
        total: how many there will be, if that is known.
        done: how many there are before it begins.
    """
    return tqdm(total=total, initial=done, **_form(unit, what))


@contextmanager
def saying(what: str) -> Iterator[None]:
    """Says what is done while the block, of a few seconds, goes on; the line is gone afterwards."""
    is_shown = sys.stderr.isatty()
    if is_shown:
        print(f"{what} …", end="\r", flush=True, file=sys.stderr)
    try:
        yield
    finally:
        if is_shown:
            print(f"{' ' * (len(what) + 2)}\r", end="", flush=True, file=sys.stderr)


def _form(unit: str, what: str | None) -> dict[str, Any]:
    """`disable=None` is tqdm's for: not on a terminal."""
    return {"unit": unit, "desc": what, "disable": None, "dynamic_ncols": True, "file": sys.stderr}
