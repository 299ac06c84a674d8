"""`graspcell query`: questions to a run's tables in SQL."""

import contextlib
import csv
import json
import math
import re
import shutil
import sys
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import pyarrow as pa

from experiments.errors import UsageError
from experiments.reading.aligned import aligned
from experiments.reading.config import Query
from experiments.reading.run import Run, load
from experiments.results.store import SCHEMAS

if TYPE_CHECKING:
    import duckdb

Rows = Iterator[list[tuple[Any, ...]]]  # some at a time

_MOST = 100  # rows that are printed for a person
_AT_ONCE = 10_000
# Tables from the run alone: no files, no network, no variables of this program, and no way to change that.
_CLOSED: dict[str, Any] = {
    "autoinstall_known_extensions": False,
    "autoload_known_extensions": False,
    "python_enable_replacements": False,
}
_LOCKS = ("SET enable_external_access = false", "SET lock_configuration = true")


def query(config: Query) -> int:
    """Prints the answer; returns the exit code.

    Raises:
        UsageError: an invalid argument, a folder without a run, or SQL that fails.
    """
    config.check()
    run, width = load(config.run), shutil.get_terminal_size().columns
    if config.sql is None:
        print(listing(run, width))
        return 0
    with opened(run) as database:
        names, rows = ask(database, config.sql)
        if config.csv:
            _print_csv(names, rows)
        elif config.json:
            _print_json(names, rows)
        else:
            _print_text(names, rows, width)
    return 0


def listing(run: Run, width: int) -> str:
    """The tables with their numbers of rows, and their columns with types and meanings."""
    lines = []
    for name, schema in SCHEMAS.items():
        lines.append(f"{name} ({run.scanned(name).count_rows()} rows)")
        kinds = [_in_words(field.type) for field in schema]
        longest, widest = max(map(len, schema.names)), max(map(len, kinds))
        for field, kind in zip(schema, kinds, strict=True):
            begin = f"  {field.name.ljust(longest)}  {kind.ljust(widest)}  "
            meaning = (field.metadata or {})[b"meaning"].decode()
            lines += textwrap.wrap(f"{begin}{meaning}", max(width, 60), subsequent_indent=" " * len(begin))
    return "\n".join(lines)


def _in_words(kind: pa.DataType) -> str:
    """A column's type as docs/logs.md has it."""
    if pa.types.is_fixed_size_list(kind):
        return f"{kind.list_size} {kind.value_type}s"
    return f"{kind.value_type}s" if pa.types.is_list(kind) else str(kind)


@contextlib.contextmanager
def opened(run: Run) -> Iterator["duckdb.DuckDBPyConnection"]:
    """A database in memory that holds the run's tables as views and can reach nothing else.

    Raises:
        UsageError: DuckDB is not installed.
    """
    try:
        import duckdb  # noqa: PLC0415  # an extra
    except ImportError:
        raise UsageError("query needs DuckDB; expected the extra: pip install 'graspcell[query]'") from None
    with duckdb.connect(":memory:", config=_CLOSED) as database:
        for name in SCHEMAS:
            database.register(name, run.scanned(name))
        for lock in _LOCKS:
            database.execute(lock)
        yield database


def ask(database: "duckdb.DuckDBPyConnection", sql: str) -> tuple[list[str], Rows]:
    """The names of the answer's columns, and its rows, some at a time.

    Raises:
        UsageError: the SQL is not one SELECT, or fails; also while the rows are read.
    """
    import duckdb  # noqa: PLC0415  # an extra

    with _told(duckdb.Error):
        statements = database.extract_statements(sql)
        kinds = [statement.type for statement in statements]
        if kinds != [duckdb.StatementType.SELECT]:
            got = ", ".join(kind.name for kind in kinds) or "none"
            raise UsageError(f"expected one SELECT, got {got}: the tables can only be read")
        database.execute(statements[0])
        names = [column[0] for column in database.description or ()]

    def rows() -> Rows:
        with _told(duckdb.Error):
            while some := database.fetchmany(_AT_ONCE):
                yield some

    return names, rows()


@contextlib.contextmanager
def _told(kind: type[Exception]) -> Iterator[None]:
    """Says what DuckDB says in one line, without the excerpt of the SQL."""
    try:
        yield
    except kind as error:
        message = " ".join(re.split(r"\n\nLINE \d+:", str(error))[0].split()).rstrip("!")
        if message.startswith("Catalog Error: Table"):
            message = f"{message.partition('! ')[0]}; expected one of {', '.join(SCHEMAS)}"
        raise UsageError(f"{message}; `graspcell query RUN` lists the tables and their columns") from error


def _print_text(names: Sequence[str], rows: Rows, width: int) -> None:
    first = next(rows, [])
    print(aligned(names, first[:_MOST], width))
    if len(first) > _MOST:
        print(f"the first {_MOST} rows: --csv or --json prints all")


def _print_csv(names: Sequence[str], rows: Rows) -> None:
    writer = csv.writer(sys.stdout, lineterminator="\n")
    writer.writerow(names)
    for some in rows:
        writer.writerows([_in_csv(value) for value in row] for row in some)


def _in_csv(value: Any) -> Any:
    return json.dumps(value, default=str) if isinstance(value, list | tuple | dict) else value


def _print_json(names: Sequence[str], rows: Rows) -> None:
    twice = sorted({name for name in names if list(names).count(name) > 1})
    if twice:
        raise UsageError(f"expected columns of different names for --json, got {', '.join(twice)} twice: use AS")
    before = "[\n"
    for some in rows:
        for row in some:
            fields = {name: _in_json(name, value) for name, value in zip(names, row, strict=True)}
            print(before + json.dumps(fields, ensure_ascii=False, default=str), end="")
            before = ",\n"
    print("\n]" if before != "[\n" else "[]")


def _in_json(name: str, value: Any) -> Any:
    if isinstance(value, float) and not math.isfinite(value):
        raise UsageError(f"expected finite numbers for --json, got {value} in {name}: take --csv")
    return value
