"""Runs made by hand: tables of a few rows."""

from functools import partial
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.dataset as ds

from experiments.reading.run import Run
from experiments.results.store import SCHEMAS

KEY = {"object": "antenna", "method": "none", "policy": "always", "experiment": 0}


def run_of(**rows: list[dict[str, Any]]) -> Run:
    """A run with these rows, which the key's columns and nulls fill up."""
    tables = {
        name: pa.Table.from_pylist([KEY | row for row in rows.get(name, [])], schema=schema)
        for name, schema in SCHEMAS.items()
    }
    return Run(Path("by-hand"), {name: partial(ds.dataset, table) for name, table in tables.items()})
