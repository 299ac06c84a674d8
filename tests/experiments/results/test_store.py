import re
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from experiments.results.store import SCHEMAS, LogWriter

KEY = {"object": "antenna", "method": "none", "experiment": 3}


def value(kind: pa.DataType) -> Any:
    """Something that the type holds, and no rounder than it must be."""
    if pa.types.is_fixed_size_list(kind):
        return [value(kind.value_type)] * kind.list_size
    if pa.types.is_list(kind):
        return [value(kind.value_type)] * 3
    if pa.types.is_floating(kind):
        return 0.1
    if pa.types.is_boolean(kind):
        return True
    if pa.types.is_integer(kind):
        return 7
    return "word"


def rows(experiment: int = 3) -> dict[str, list[dict[str, Any]]]:
    """One full row per table."""
    full = {name: {field.name: value(field.type) for field in schema} for name, schema in SCHEMAS.items()}
    return {name: [{**row, **KEY, "experiment": experiment}] for name, row in full.items()}


def read(folder: Path, name: str) -> list[dict[str, Any]]:
    table: list[dict[str, Any]] = pq.read_table(folder / f"{name}.parquet").to_pylist()
    return table


def test_there_is_a_table_per_kind_of_record() -> None:
    assert set(SCHEMAS) == {"experiments", "slots", "transitions", "frames", "estimates", "decisions", "attempts"}


def test_every_column_says_what_it_means() -> None:
    fields = [(name, field) for name, schema in SCHEMAS.items() for field in schema]
    assert len(fields) > 7 * 3
    assert [f"{name}.{field.name}" for name, field in fields if not (field.metadata or {}).get(b"meaning")] == []


@pytest.mark.parametrize(("ending", "unit"), [("_s", "s"), ("_m", "m"), ("_N", "N")])
def test_columns_with_a_unit_in_their_name_have_it_in_their_meaning(ending: str, unit: str) -> None:
    fields = [field for schema in SCHEMAS.values() for field in schema if field.name.endswith(ending)]
    assert fields
    meanings = [field.metadata[b"meaning"].decode().replace(",", " ").split() for field in fields]
    assert all(unit in meaning for meaning in meanings)


def test_poses_say_their_unit_and_the_order_of_their_quaternion() -> None:
    poses = [field for schema in SCHEMAS.values() for field in schema if field.name.startswith("X_")]
    assert len(poses) == 6  # X_BC, X_CO_est of two estimators, of decisions X_BO_est and X_BC, of attempts X_BO_est
    assert all(b"in m, then quaternion w, x, y, z" in pose.metadata[b"meaning"] for pose in poses)
    assert all(pose.type.list_size == 3 + 4 for pose in poses)


def test_columns_of_the_truth_are_marked() -> None:
    true = [field for schema in SCHEMAS.values() for field in schema if field.name.startswith("true_")]
    assert true
    assert all(field.metadata[b"meaning"].startswith(b"TRUTH") for field in true)


def test_the_meanings_are_in_the_files(tmp_path: Path) -> None:
    with LogWriter(tmp_path):
        pass
    for name, schema in SCHEMAS.items():
        stored = pq.read_schema(tmp_path / f"{name}.parquet")
        assert stored.equals(schema)
        assert [field.metadata[b"meaning"] for field in stored] == [field.metadata[b"meaning"] for field in schema]


def test_rows_come_back_as_they_were_written(tmp_path: Path) -> None:
    with LogWriter(tmp_path) as logs:
        logs.write(rows(3))
        logs.write(rows(4))
    for name in SCHEMAS:
        assert read(tmp_path, name) == rows(3)[name] + rows(4)[name]


def test_rows_of_many_experiments_come_back_in_their_order_as_one_row_group(tmp_path: Path) -> None:
    with LogWriter(tmp_path) as log:
        for experiment in range(450):  # more than wait side by side before they are joined, twice
            log.write(rows(experiment))
    for name in SCHEMAS:
        assert [row["experiment"] for row in read(tmp_path, name)] == list(range(450))
        assert pq.ParquetFile(tmp_path / f"{name}.parquet").num_row_groups == 1


def test_what_a_row_leaves_out_is_null(tmp_path: Path) -> None:
    with LogWriter(tmp_path) as logs:
        logs.write({**{name: [] for name in SCHEMAS}, "experiments": [{**KEY, "failure": "no light"}]})
    (row,) = read(tmp_path, "experiments")
    assert row["failure"] == "no light"
    assert (row["tp"], row["duration_s"]) == (None, None)
    assert read(tmp_path, "attempts") == []


def test_an_unknown_or_missing_table_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with LogWriter(tmp_path) as logs:
        with pytest.raises(KeyError, match="wrong: grasps"):
            logs.write({**rows(), "grasps": []})
        with pytest.raises(KeyError, match="wrong: slots"):
            logs.write({name: table for name, table in rows().items() if name != "slots"})
    assert [read(tmp_path, name) for name in SCHEMAS] == len(SCHEMAS) * [[]]


@pytest.mark.parametrize("error", [RuntimeError("broken"), KeyboardInterrupt()])
def test_what_was_written_before_an_exception_can_be_read(tmp_path: Path, error: BaseException) -> None:
    def write_and_fail() -> None:
        with LogWriter(tmp_path) as logs:
            logs.write(rows())
            raise error

    with pytest.raises(type(error)):
        write_and_fail()
    for name in SCHEMAS:
        assert read(tmp_path, name) == rows()[name]


def test_an_error_before_the_first_row_leaves_earlier_logs_untouched(tmp_path: Path) -> None:
    with LogWriter(tmp_path):
        pass
    before = {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert set(before) == {f"{name}.parquet" for name in SCHEMAS}
    with pytest.raises(RuntimeError, match="no cell"), LogWriter(tmp_path):
        raise RuntimeError("no cell")
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == before


def test_the_page_about_the_logs_names_every_column_with_its_meaning() -> None:
    page = (Path(__file__).parents[3] / "docs" / "logs.md").read_text(encoding="utf-8")
    rows = [(field.name, field.metadata[b"meaning"].decode()) for schema in SCHEMAS.values() for field in schema]
    assert len(rows) > 60
    for name, meaning in rows:
        assert re.search(rf"\| `{name}` \| [^|]+ \| {re.escape(meaning)} \|", page), name
