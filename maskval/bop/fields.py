"""Reading JSON with errors that say where: the file, the entry in it, and what was expected there."""

import gzip
import json
import sys
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maskval.bop.places import Place
from maskval.errors import InvalidFileError

M_PER_MM = 1e-3
_GREATEST = sys.float_info.max
_GZIP = b"\x1f\x8b"


class Entry:
    """A JSON value and where it stands.

    Args:
        value: The value.
        place: Where it stands in its file.
    """

    __slots__ = ("place", "value")

    def __init__(self, value: Any, place: Place) -> None:
        self.value = value
        self.place = place

    def error(self, expected: str) -> InvalidFileError:
        """The error of a value that is not as expected."""
        return InvalidFileError(f"{self.place}: expected {expected}, but found {_shown(self.value)}")

    def __getitem__(self, key: str) -> "Entry":
        if not isinstance(self.value, dict):
            raise self.error("an object")
        if key not in self.value:
            available = ", ".join(sorted(self.value)) or "nothing"
            raise InvalidFileError(f"{self.place}: expected the field {key!r}, but found only {available}")
        return Entry(self.value[key], self.place.at(key))

    def __contains__(self, key: str) -> bool:
        return isinstance(self.value, dict) and key in self.value

    def items(self) -> Iterator[tuple[int, "Entry"]]:
        """The entries of an object whose keys are identifiers, in their order."""
        if not isinstance(self.value, dict):
            raise self.error("an object of entries by their id")
        for key, value in self.value.items():
            if not is_whole(key):
                raise InvalidFileError(f"{self.place}: expected whole numbers as keys, but found {key!r}")
            yield int(key), Entry(value, self.place.at(key))

    def elements(self) -> Iterator["Entry"]:
        """The elements of a list."""
        if not isinstance(self.value, list):
            raise self.error("a list")
        for index, value in enumerate(self.value):
            yield Entry(value, self.place.at(index))

    def integer(self) -> int:
        """A whole number, of 64 bits."""
        if isinstance(self.value, bool) or not isinstance(self.value, int) or not -(2**63) <= self.value < 2**63:
            raise self.error("a whole number")
        return self.value

    def number(self) -> float:
        """A finite number."""
        number = self.value
        if isinstance(number, bool) or not isinstance(number, int | float) or not -_GREATEST <= number <= _GREATEST:
            raise self.error("a finite number")
        return float(number)

    def numbers(self, count: int) -> NDArray[np.float64]:
        """So many finite numbers."""
        if not isinstance(self.value, list) or len(self.value) != count:
            raise self.error(f"a list of {count} numbers")
        return np.array([element.number() for element in self.elements()])


def is_whole(text: str) -> bool:
    """Whether a text is a whole number >= 0 that 64 bits hold: at most 18 digits, and no other letters."""
    return text.isdecimal() and len(text) <= 18


def read_json(path: Path) -> Entry:
    """The value of a JSON file, as it is or compressed by gzip, as BOP's tools write large ones.

    Args:
        path: The file; what it begins with tells whether it is compressed, whatever its name.

    Raises:
        InvalidFileError: If it is no JSON.
    """
    content = path.read_bytes()
    if content.startswith(_GZIP):
        try:
            content = gzip.decompress(content)
        except (OSError, EOFError, zlib.error) as error:
            raise InvalidFileError(f"{path}: expected a whole gzip file: {error}") from error
    try:
        text = content.decode("utf-8")
        return Entry(json.loads(text), Place(str(path), text))
    except json.JSONDecodeError as error:
        raise InvalidFileError(f"{path}:{error.lineno}:{error.colno}: expected JSON: {error.msg}") from error
    except (ValueError, RecursionError) as error:  # no UTF-8, a number of thousands of digits, lists a thousand deep
        raise InvalidFileError(f"{path}: expected JSON: {error}") from error


def write_entries(path: Path, entries: dict[str, Any] | Sequence[Any]) -> None:
    """Writes a JSON object or list with an entry on each line, as BOP's files are.

    Args:
        path: The file.
        entries: What JSON can hold.
    """
    if isinstance(entries, dict):
        lines = [f"  {json.dumps(key)}: {json.dumps(value)}" for key, value in entries.items()]
        opening, closing = "{", "}"
    else:
        lines = [f"  {json.dumps(value)}" for value in entries]
        opening, closing = "[", "]"
    path.write_text("\n".join((opening, ",\n".join(lines), closing, "")), encoding="utf-8")


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else text[:57] + "..."
