"""A run's tables for a notebook or a program of one's own: as Arrow, or as pandas has them."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.parquet as pq

from experiments.errors import UsageError
from experiments.results.store import SCHEMA, SCHEMAS, UNITS
from experiments.units.asked import ASKED
from experiments.units.run_folder import RunFolder
from maskval import InvalidFileError
from maskval.inputs.files import check_input

if TYPE_CHECKING:
    import pandas as pd

Sources = Mapping[str, Callable[[], ds.Dataset]]


class Run:
    """The tables of a run, each with the columns object, method, policy and experiment; docs/logs.md has them all.

    `run.attempts` is `run["attempts"]`, an Arrow table, read when it is asked for and then kept.

    Args:
        path: the run's folder.
        sources: what each table is read from.
    """

    def __init__(self, path: Path, sources: Sources) -> None:
        self.path, self._sources = path, sources
        self._tables: dict[str, pa.Table] = {}

    def __getitem__(self, name: str) -> pa.Table:
        """The table of this name.

        Raises:
            KeyError: there is no such table.
        """
        if name not in self._tables:
            self._tables[name] = self.scanned(name).to_table()
        return self._tables[name]

    def __getattr__(self, name: str) -> pa.Table:
        """The table of this name."""
        if name not in SCHEMAS:
            raise AttributeError(f"a run has no {name!r}: expected one of {', '.join(SCHEMAS)}")
        return self[name]

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *SCHEMAS]

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r}: {', '.join(SCHEMAS)})"

    def scanned(self, name: str) -> ds.Dataset:
        """The table of this name for those who read it batch by batch, which a file of any size can be.

        Raises:
            KeyError: there is no such table.
        """
        if name not in self._sources:
            raise KeyError(f"expected one of {', '.join(SCHEMAS)}, got {name!r}")
        return self._sources[name]()

    def pandas(self, name: str) -> "pd.DataFrame":
        """The table of this name as pandas has it.

        Raises:
            KeyError: there is no such table.
            UsageError: pandas is not installed.
        """
        try:
            import pandas  # noqa: F401, PLC0415  # not among the package's own
        except ImportError:
            raise UsageError(f"expected pandas for run.pandas({name!r}), got none: pip install pandas") from None
        frame: pd.DataFrame = self[name].to_pandas()
        return frame


def load(folder: Path) -> Run:
    """The tables of a run, also of one that is still being computed: of the experiments that have ended.

    Args:
        folder: what compare or merge has written, or `run --out`.

    Raises:
        UsageError: it holds no run, a damaged one, or tables of another version.
    """
    if not (folder / ASKED).exists():
        return _of_files(folder)
    run = RunFolder.read(folder)
    return _of_files(folder) if _made_from(folder) == {run.units_digest()} else _of_units(run)


def _of_files(folder: Path) -> Run:
    files = {name: folder / f"{name}.parquet" for name in SCHEMAS}
    missing = [file.name for file in files.values() if not file.exists()]
    if missing:
        raise UsageError(
            f"{folder}: expected the folder of a run, as compare and run --out write it, with {ASKED} or "
            f"{len(files)} tables; it lacks {ASKED}, {', '.join(missing)}"
        )
    for name, file in files.items():
        schema = _schema_of(file)
        if not schema.equals(SCHEMAS[name]):
            writer = (schema.metadata or {}).get(b"graspcell", b"an earlier version").decode()
            raise UsageError(f"{file}: expected the columns of schema {SCHEMA}, got others, written by {writer}")
    return Run(folder, {name: partial(ds.dataset, file) for name, file in files.items()})


def _schema_of(file: Path) -> pa.Schema:
    try:
        return pq.read_schema(check_input(file))
    except InvalidFileError as error:
        raise UsageError(str(error)) from error
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"{file}: expected a table that compare or run has written: {error}") from error


def _made_from(folder: Path) -> set[str | None]:
    """The units that each of the folder's tables says it was made from; None for one that is missing or damaged."""
    found = set()
    for name in SCHEMAS:
        try:
            units = (pq.read_schema(check_input(folder / f"{name}.parquet")).metadata or {}).get(UNITS)
        except (OSError, InvalidFileError, pa.ArrowException):
            units = None
        found.add(None if units is None else units.decode())
    return found


def _of_units(run: RunFolder) -> Run:
    """The tables that the end of the run would write, made from its units."""
    pieces: dict[str, list[pa.Table]] = {name: [schema.empty_table()] for name, schema in SCHEMAS.items()}
    try:
        for unit in run.units():
            for name, schema in SCHEMAS.items():
                pieces[name].append(pa.Table.from_pylist(unit.tables.get(name, []), schema=schema))
    except FileNotFoundError as error:
        raise UsageError(f"{error.filename} was replaced while {run.path} was read: read it once more") from error
    tables = {name: pa.concat_tables(some) for name, some in pieces.items()}
    return Run(run.path, {name: partial(ds.dataset, table) for name, table in tables.items()})
