"""Small comparisons and the rows that they write."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from experiments.setup.experiment import ExperimentSpec
from experiments.setup.thresholds import load_thresholds
from tests.experiments.command import Told, command, overriding

PARTS = 2  # per experiment: enough for a second slot of time, and two of them share a picture
KEY = ("object", "method", "policy", "experiment")
Row = dict[str, Any]


def compared(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object, jobs: int = 1) -> Told:
    common = ("--parts", PARTS, "--jobs", jobs, "--seed", 5, "--out", out)
    return command(capsys, "compare", *overriding(*common, *arguments))


def rows(folder: Path, table: str, **of: object) -> list[Row]:
    """The rows of a log, of those experiments that are asked for, one experiment after the other."""
    read: list[Row] = pq.read_table(folder / f"{table}.parquet").to_pylist()
    kept = [row for row in read if all(row[name] == value for name, value in of.items())]
    return sorted(kept, key=lambda row: tuple(row[name] for name in KEY))


def table_of(folder: Path) -> list[Row]:
    cells: list[Row] = json.loads((folder / "table.json").read_text(encoding="utf-8"))["cells"]
    return cells


def spec(method: str = "none", experiment: int = 0, **other: Any) -> ExperimentSpec:
    plain = ExperimentSpec("antenna", method, "oracle", load_thresholds("paper"), "fast", PARTS, 5, experiment)
    return replace(plain, **other)


def contents(folder: Path) -> dict[str, bytes]:
    """Every file of a run but its lock, which names a process."""
    files = [file for file in folder.rglob("*") if file.is_file() and file.name != ".lock"]
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in files}
