"""Where a value stands in a JSON file; looked for only when there is an error to report."""

import json
import re
from dataclasses import dataclass
from typing import cast

_DECODER = json.JSONDecoder()
_SPACE = re.compile(r"[ \t\n\r]*")


@dataclass(frozen=True, slots=True)
class Place:
    """A value of a JSON text; printed, the file, line and column (from 1), and the way to the value.

    Args:
        path: The file.
        text: Its content, which is JSON.
        steps: The keys and indices that lead to the value.
    """

    path: str
    text: str
    steps: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        try:
            return self._printed()
        except RecursionError:  # lists in lists, a thousand deep
            return self.path

    def _printed(self) -> str:
        position = _skip(self.text, 0)
        for step in self.steps:
            position = _member(self.text, position, step)
        line = self.text.count("\n", 0, position) + 1
        column = position - self.text.rfind("\n", 0, position)
        way = (f"[{step}]" if isinstance(step, int) else step for step in self.steps)
        return ": ".join((f"{self.path}:{line}:{column}", *way))

    def at(self, step: str | int) -> "Place":
        """The place of a member of this value."""
        return Place(self.path, self.text, (*self.steps, step))


def _member(text: str, position: int, step: str | int) -> int:
    """Where a member of the object or list at a position begins."""
    found = -1
    index = 0
    position = _skip(text, position + 1)
    while text[position] not in "}]":
        key: str | int = index
        if isinstance(step, str):
            key, position = _DECODER.raw_decode(text, position)
            position = _skip(text, _skip(text, position) + 1)
        if key == step:
            found = position  # of a key that is given twice, JSON means the last
        _, position = _DECODER.raw_decode(text, position)
        position = _skip(text, position)
        if text[position] == ",":
            position = _skip(text, position + 1)
        index += 1
    return found


def _skip(text: str, position: int) -> int:
    return cast(re.Match[str], _SPACE.match(text, position)).end()
