"""Reading JSON with errors that say where: the file, the entry in it, and what was expected there."""

import gzip
import io
import json
import sys
import warnings
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maskval.bop.places import Place
from maskval.errors import ImplausibleInputWarning, InvalidFileError
from maskval.inputs.files import MOST_RESULTS, read_input

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

    def identifier(self) -> int:
        """A whole number >= 0."""
        if self.integer() < 0:
            raise self.error("a whole number >= 0")
        return self.integer()

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
    """Whether a text is a whole number >= 0 that 64 bits hold: at most 18 digits from 0 to 9, and no other letters."""
    return text.isascii() and text.isdecimal() and len(text) <= 18


def numbers_of(text: str) -> list[float] | None:
    """The numbers of a text, parted by spaces; None where a word is none.

    Python's own reading is wider than any file's: it takes 1_000 and the digits of other scripts.
    """
    if "_" in text or not text.isascii():
        return None
    try:
        return [float(word) for word in text.split()]
    except ValueError:
        return None


def read_json(path: Path) -> Entry:
    """The value of a JSON file, as it is or compressed by gzip, as BOP's tools write large ones.

    Args:
        path: The file; what it begins with tells whether it is compressed, whatever its name.

    Raises:
        InvalidFileError: If it is no JSON, an object has a key twice, or it is no regular file of at most 2 GiB.
    """
    content = read_input(path, MOST_RESULTS)
    if content.startswith(_GZIP):
        content = _unpacked(path, content)
    try:
        text = content.decode("utf-8")
        return Entry(json.loads(text, object_pairs_hook=_object), Place(str(path), text))
    except json.JSONDecodeError as error:
        raise InvalidFileError(f"{path}:{error.lineno}:{error.colno}: expected JSON: {error.msg}") from error
    except (ValueError, RecursionError) as error:  # no UTF-8, a key twice, a number of thousands of digits, depth
        raise InvalidFileError(f"{path}: expected JSON: {error}") from error


def _unpacked(path: Path, content: bytes) -> bytes:
    """The content of a gzip file; a small one may hold more than any memory."""
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(content)) as file:
            unpacked = file.read(MOST_RESULTS + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InvalidFileError(f"{path}: expected a whole gzip file: {error}") from error
    if len(unpacked) > MOST_RESULTS:
        raise InvalidFileError(f"{path}: expected at most {MOST_RESULTS} bytes once unpacked, but there are more")
    return unpacked


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object, of whose equal keys Python would silently keep the last."""
    made = dict(pairs)
    if len(made) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for index, key in enumerate(keys) if key in keys[:index])
        raise ValueError(f"an object with each key once, but {twice[:60]!r} stands there twice")
    return made


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
    try:
        text = json.dumps(value)
    except RecursionError:
        return "lists in lists, a thousand deep"
    return text if len(text) <= 60 else text[:57] + "..."


def warn_of_scores(path: Path, scores: Sequence[float]) -> None:
    """Warns, once a file, of scores that are no confidences: BOP allows any, but they may stand in a wrong column."""
    if scores and not 0 <= min(scores) <= max(scores) <= 1:
        warnings.warn(
            f"{path}: expected scores in 0..1, got {min(scores):g} to {max(scores):g}; they only rank poses",
            ImplausibleInputWarning,
            stacklevel=3,  # where the file was asked for
        )
