"""What a person sets for `graspcell query`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from experiments.errors import UsageError


@dataclass(frozen=True)
class Query:
    """Answer a question to a run's tables in SQL; without a question, list the tables and what their columns mean.

    The tables are those of docs/logs.md, of the experiments that have ended: the run may still be going on. Nothing is
    written, and nothing but these tables can be read. Needs the extra query (DuckDB).
    """

    run: Annotated[Path, tyro.conf.Positional]
    """Folder of a run, as compare, merge or run --out writes it."""
    sql: Annotated[str | None, tyro.conf.Positional] = None
    """A SELECT in DuckDB's SQL."""
    csv: bool = False
    """Print all rows as CSV; lists are JSON in it, and nothing stands for null."""
    json: bool = False
    """Print all rows as a JSON list of objects."""

    def check(self) -> None:
        """Rejects what cannot be.

        Raises:
            UsageError: says what, and why.
        """
        if self.csv and self.json:
            raise UsageError("expected --csv or --json, got both")
        if self.sql is None and (self.csv or self.json):
            raise UsageError("expected a question in SQL for --csv or --json, got none")
