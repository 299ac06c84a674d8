"""A run's folder: what was asked for, and one file per experiment that has ended. One command at a time works in it."""

import contextlib
import fcntl
import hashlib
import os
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, Self

from experiments.errors import UsageError
from experiments.progress import SHOWN_AFTER, counted
from experiments.results.files import replacing
from experiments.results.provenance import write_json
from experiments.results.store import SCHEMAS
from experiments.setup.checks import writable_folder
from experiments.setup.options_file import NAME
from experiments.units.asked import ASKED, FORMAT, Asked, read_asked
from experiments.units.identity import Description, differences
from experiments.units.unit import Unit, content_digest, place, read_packed, unpacked

_LOCK, _UNITS, _FAILED = ".lock", "units", "failed"
_WRITTEN = (
    "table.json",
    "table.csv",
    "table.md",
    "table.tex",
    "manifest.json",
    *(f"{name}.parquet" for name in SCHEMAS),
)


@dataclass(slots=True)
class RunFolder:
    """The folder of a run; see `opened` and `read`."""

    path: Path
    asked: list[Asked] = field(default_factory=list)
    options: dict[str, Any] = field(default_factory=dict)  # of the command that asked last

    @classmethod
    @contextlib.contextmanager
    def opened(cls, path: Path, *, overwrite: bool = False) -> Iterator[Self]:
        """The folder, made if missing, and no other command's until the end.

        Raises:
            UsageError: it cannot be written to, or another command works in it, or it holds results of another kind.
        """
        writable_folder(path)
        with _locked(path):
            if overwrite:
                _empty(path)
            folder = cls(path, *read_asked(path))
            if not folder.asked and any((path / name).exists() for name in _WRITTEN):
                raise UsageError(
                    f"{path} holds results without {ASKED}, as version 0.2.0 and `run --out` write them: expected "
                    "another --out, or --overwrite"
                )
            _sweep(path)
            yield folder

    @classmethod
    def read(cls, path: Path) -> Self:
        """The folder as it is, for a reader: a command may be working in it.

        Raises:
            UsageError: it holds no run.
        """
        asked, options = read_asked(path)
        if not asked:
            raise UsageError(f"{path}: expected the folder of a run, as compare writes it, with {ASKED}")
        return cls(path, asked, options)

    def ask(self, cells: Sequence[Asked], options: dict[str, Any]) -> None:
        """Adds cells, or experiments of a cell; writes down what is asked for.

        Args:
            cells: what is asked for.
            options: of the command, see `Asked`; those of cells without any of their own.

        Raises:
            UsageError: the folder's experiments are of another kind; the message says what differs.
        """
        for asked in cells:
            cell = replace(asked, options=asked.options or options)
            if self.asked:
                self._check(self.asked[0].description["common"], cell.description["common"], "")
            at = next((at for at, one in enumerate(self.asked) if one.of == cell.of), None)
            if at is None:
                self.asked.append(cell)
                continue
            known = self.asked[at]
            for key in ("cell", "noise"):
                name = " × ".join(cell.of[key] for key in ("object", "method", "policy"))
                self._check({key: known.description[key]}, {key: cell.description[key]}, f" of {name}")
            self.asked[at] = replace(cell, experiments=max(known.experiments, cell.experiments))
        self.options = options
        self._write_asked()

    def content_with(self, cells: Sequence[Asked]) -> None:
        """Goes back to what was asked for, where a run has stopped early; the units beyond stay for later."""
        self.asked = list(cells)
        self._write_asked()

    def _write_asked(self) -> None:
        cells_asked = [asdict(one) for one in self.asked]
        write_json(self.path / ASKED, {"format": FORMAT, "options": self.options, "cells": cells_asked})

    def _check(self, there: dict[str, Any], here: dict[str, Any], what: str) -> None:
        lines = differences(there, here)
        if lines:
            raise UsageError(
                f"{self.path} holds experiments{what} of another kind: {'; '.join(lines)}: expected another --out, "
                "the same options and version, or --overwrite"
            )

    @property
    def expected(self) -> int:
        """How many experiments were asked for."""
        return sum(cell.experiments for cell in self.asked)

    def has(self, description: Description, *, failed: bool = False) -> bool:
        """Whether an experiment has ended: with a result, or, if asked for, without."""
        return self._file(place(description), ok=not failed).exists()

    def add(self, place: str, packed: bytes, *, ok: bool) -> None:
        """Writes a unit, once: whole or not at all.

        Raises:
            UsageError: it cannot be written, or there is one of this name with other content.
        """
        file = self._file(place, ok=ok)
        if ok and file.exists():
            self._compare(file, packed)
            return
        try:
            for folder in (file.parent.parent, file.parent):  # not the run's own, which somebody may have removed
                folder.mkdir(exist_ok=True)
        except OSError as error:
            raise UsageError(f"cannot write {file}: {error.strerror or error}") from error
        with replacing(file) as content:
            content.write(packed if ok else unpacked(packed))
        _sync(file.parent)
        if ok:
            self._file(place, ok=False).unlink(missing_ok=True)

    def _compare(self, file: Path, packed: bytes) -> None:
        there, here = content_digest(read_packed(file)), content_digest(packed)
        if there != here:
            other = file.with_name(f"{file.name.partition('.')[0]}.other-{here}.json.gz")
            with replacing(other) as content:
                content.write(packed)
            raise UsageError(
                f"the same experiment came to two results: {file} and {other}; expected equal ones: something decides "
                "them that their description does not say"
            )

    def _file(self, place: str, *, ok: bool) -> Path:
        """Of a unit with a result, compressed; one that failed is for a person to read."""
        return self.path / (f"{_UNITS}/{place}.json.gz" if ok else f"{_FAILED}/{place}.json")

    def units(self) -> Iterator[Unit]:
        """All units, cell by cell, by number; one at a time in memory. A terminal is told how far their user is.

        Raises:
            UsageError: a unit is damaged.
        """
        files = ((cell, file) for cell in self.asked for file in self._files_of(cell))
        for cell, file in counted(files, "experiment", "read", self.expected, after=SHOWN_AFTER):
            unit = Unit.from_bytes(read_packed(file), str(file))
            if unit.description["of"] == cell.of:
                yield unit

    def units_digest(self) -> str:
        """Says which units there are: equal for folders with equal units, whatever made them.

        A unit with a result is known by its name; one that failed, by its content too.
        """
        total = hashlib.sha256()
        for file in (file for cell in self.asked for file in self._files_of(cell)):
            failure = content_digest(read_packed(file)) if file.parts[-3] == _FAILED else ""
            total.update(f"{file.parent.name}/{file.name} {failure}\n".encode())
        return total.hexdigest()[:16]

    def files(self) -> Iterator[tuple[str, bool, bytes]]:
        """Of every unit its place, whether it has a result, and its bytes.

        Raises:
            UsageError: a unit is damaged.
        """
        for file in (file for cell in self.asked for file in self._files_of(cell)):
            packed = read_packed(file)
            unit = Unit.from_bytes(packed, str(file))
            yield unit.place, unit.failure is None, packed

    def _files_of(self, cell: Asked) -> list[Path]:
        """The files of the units asked for, by number; one with a result stands for one of its name that failed."""
        folder = place(cell.description).partition("/")[0]
        failed, finished = self.path / _FAILED / folder, self.path / _UNITS / folder
        files = [*failed.glob("[0-9]*.json"), *finished.glob("[0-9]*.json.gz")]
        named = {file.name.partition(".")[0]: file for file in files if ".other-" not in file.name}
        asked = [name for name in named if _number(name) < cell.experiments]
        return [named[name] for name in sorted(asked, key=lambda name: (_number(name), name))]


def _number(name: str) -> int:
    """The number of the experiment in a unit's name."""
    return int(name.partition("-")[0])


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Holds the folder's lock, which ends with the process, however that ends.

    Raises:
        UsageError: another command holds it.
    """
    with (path / _LOCK).open("a+") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            file.seek(0)
            raise UsageError(
                f"another command works in {path} (process {file.read().strip() or 'unknown'}): wait for its end, "
                "or take another --out"
            ) from None
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        yield


def _empty(path: Path) -> None:
    """Removes what runs write, and nothing else. What was asked for goes first: what is left then means nothing."""
    for name in (ASKED, *_WRITTEN, NAME):
        (path / name).unlink(missing_ok=True)
    for name in (_UNITS, _FAILED):
        shutil.rmtree(path / name, ignore_errors=True)


def _sweep(path: Path) -> None:
    """Removes what a killed command left half-written; nobody else writes here."""
    for file in _asides(path):
        file.unlink(missing_ok=True)


def _asides(path: Path) -> Iterable[Path]:
    yield from path.glob(".*.part")
    for kind in (_UNITS, _FAILED):
        yield from (path / kind).glob("*/.*.part")


def _sync(folder: Path) -> None:
    """Has the disk keep a folder's new entry, so that a power loss does not take it back."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
