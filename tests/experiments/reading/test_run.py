import builtins
import shutil
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from experiments import load
from experiments.errors import UsageError
from experiments.results.store import SCHEMAS, LogWriter
from tests.experiments.command import command

KEY = ["object", "method", "policy", "experiment"]


@pytest.fixture
def copy(small_run: Path, tmp_path: Path) -> Path:
    """A copy of the small run that a test may change."""
    return Path(shutil.copytree(small_run, tmp_path / "copy"))


def test_a_run_has_every_table_under_its_name_and_as_an_attribute(small_run: Path) -> None:
    run = load(small_run)
    assert run.experiments.num_rows == 4
    for name, schema in SCHEMAS.items():
        table = run[name]
        assert table.schema.equals(schema)
        assert table.schema.names[:4] == KEY
        assert table.equals(pq.read_table(small_run / f"{name}.parquet"))
        assert getattr(run, name) is table
    assert set(SCHEMAS) <= set(dir(run))


def test_a_folder_may_be_named_by_text(small_run: Path) -> None:
    assert load(str(small_run)).experiments.equals(load(small_run).experiments)


@pytest.mark.parametrize("taken", ["attempts.parquet", "*.parquet"])
def test_tables_are_made_from_the_units_where_there_are_none_yet(copy: Path, taken: str) -> None:
    before = {name: load(copy)[name] for name in SCHEMAS}
    for file in copy.glob(taken):
        file.unlink()
    run = load(copy)
    for name in SCHEMAS:
        assert run[name].equals(before[name])
        assert run[name].schema.metadata[b"schema"] == b"1"


def test_tables_of_an_earlier_end_are_not_read_once_there_are_more_units(copy: Path) -> None:
    unit = sorted(copy.glob("units/*/*.gz"))[0]
    shutil.move(unit, copy / "kept.gz")
    assert load(copy).experiments.num_rows == 3
    shutil.move(copy / "kept.gz", unit)
    assert load(copy).experiments.num_rows == 4


def test_tables_of_two_ends_are_not_mixed(copy: Path, tmp_path: Path) -> None:
    attempts = load(copy).attempts
    with LogWriter(tmp_path, "of other units") as logs:
        logs.write({name: [] for name in SCHEMAS})
    shutil.copy(tmp_path / "attempts.parquet", copy)
    assert attempts.num_rows > 0
    assert load(copy).attempts.equals(attempts)


def test_a_damaged_table_is_made_anew_from_the_units(copy: Path) -> None:
    attempts = load(copy).attempts
    (copy / "attempts.parquet").write_bytes(b"PAR1 and nothing else")
    assert load(copy).attempts.equals(attempts)


def test_the_folder_of_run_out_is_read_from_its_tables(
    small_run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cell = ("--object", "handle", "--gap", "fitted", "--parts", 2, "--seed", 5)
    assert command(capsys, "run", *cell, "--experiment", 1, "--method", "none", "--out", tmp_path).code == 0
    alone, among = load(tmp_path), load(small_run)
    assert alone.attempts.num_rows == 2
    rows = [row for row in among.attempts.to_pylist() if (row["method"], row["experiment"]) == ("none", 1)]
    assert alone.attempts.to_pylist() == rows


def test_tables_say_which_version_of_package_and_schema_they_are_of(small_run: Path) -> None:
    for name in SCHEMAS:
        metadata = pq.read_schema(small_run / f"{name}.parquet").metadata
        assert metadata[b"graspcell"] == b"0.2.0"
        assert metadata[b"schema"] == b"1"


def test_pandas_has_the_same_rows(small_run: Path) -> None:
    run = load(small_run)
    frame = run.pandas("attempts")
    assert list(frame.columns) == run.attempts.schema.names
    assert frame["outcome"].tolist() == run.attempts["outcome"].to_pylist()


def test_without_pandas_one_line_says_how_to_get_it(small_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *others: Any) -> Any:
        if name == "pandas":
            raise ImportError(name)
        return real(name, *others)

    run = load(small_run)
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(
        UsageError, match=r"^expected pandas for run.pandas\('attempts'\), got none: pip install pandas$"
    ):
        run.pandas("attempts")


def test_an_unknown_table_is_refused_with_the_known_ones(small_run: Path) -> None:
    run = load(small_run)
    with pytest.raises(KeyError, match=r"expected one of experiments, .*attempts, got 'grasps'"):
        run["grasps"]
    with pytest.raises(AttributeError, match="no 'grasps': expected one of experiments"):
        _ = run.grasps


def without_slots(folder: Path) -> None:
    with LogWriter(folder):
        pass
    (folder / "slots.parquet").unlink()


def with_other_files(folder: Path) -> None:
    for name in SCHEMAS:
        (folder / f"{name}.parquet").write_bytes(b"no table")


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda folder: None, "expected the folder of a run, as compare and run --out write it"),
        (lambda folder: (folder / "run.json").write_text("{"), "run.json is damaged"),
        (without_slots, "it lacks run.json, slots.parquet"),
        (with_other_files, "experiments.parquet: expected a table that compare or run has written"),
    ],
)
def test_a_folder_without_a_run_is_refused(tmp_path: Path, spoil: Any, words: str) -> None:
    spoil(tmp_path)
    with pytest.raises(UsageError, match=words):
        load(tmp_path)


def test_tables_of_another_version_are_refused(tmp_path: Path) -> None:
    with LogWriter(tmp_path) as logs:
        logs.write({name: [] for name in SCHEMAS})
    file = tmp_path / "frames.parquet"
    pq.write_table(pq.read_table(file).drop_columns(["policy"]).replace_schema_metadata({"graspcell": "0.1.9"}), file)
    with pytest.raises(
        UsageError, match=r"frames.parquet: expected the columns of schema 1, got others, written by 0.1.9"
    ):
        load(tmp_path)
