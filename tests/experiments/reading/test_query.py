import csv
import io
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import duckdb
import pytest

from experiments.reading.query import ask, opened
from experiments.results.store import SCHEMAS
from tests.experiments.command import Told, command
from tests.experiments.reading.runs import run_of

ROOT = Path(__file__).parents[3]
Ask = Callable[..., Told]


@pytest.fixture
def asked(small_run: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Ask:
    monkeypatch.setenv("COLUMNS", "80")
    return lambda *arguments: command(capsys, "query", small_run, *arguments)


def test_an_answer_is_an_aligned_table(asked: Ask) -> None:
    told = asked("SELECT method, experiment, tp, tp / 3 AS third FROM experiments ORDER BY ALL")
    assert (told.code, told.err) == (0, "")
    assert told.out.splitlines() == [
        "method   experiment  tp     third",
        "---------------------------------",
        "maskval           0   2  0.666667",
        "maskval           1   2  0.666667",
        "none              0   1  0.333333",
        "none              1   1  0.333333",
    ]


def test_every_line_fits_the_terminal_and_says_what_it_leaves_out(asked: Ask) -> None:
    lines = asked("SELECT * FROM attempts").out.splitlines()
    assert max(map(len, lines)) <= 80
    told = " ".join(lines[-3:])
    assert "outcome: --csv or --json prints all" in told
    assert set(SCHEMAS["attempts"].names) <= set(lines[0].split()) | set(told.replace(",", "").replace(":", "").split())


def test_csv_has_every_row_and_value(asked: Ask, small_run: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(asked("SELECT * FROM estimates", "--csv").out)))
    assert list(rows[0]) == SCHEMAS["estimates"].names
    expected = asked("SELECT * FROM estimates", "--json").out
    for row, same in zip(rows, json.loads(expected), strict=True):
        assert float(row["u"]) == same["u"]
        assert json.loads(row["X_CO_est"]) == same["X_CO_est"]
        assert json.loads(row["mask_rle"]) == same["mask_rle"]
        assert row["X_CO_est_2"] == ""
        assert same["X_CO_est_2"] is None


def test_no_rows_are_an_empty_list_and_a_header(asked: Ask) -> None:
    nothing = "SELECT u FROM attempts WHERE false"
    assert json.loads(asked(nothing, "--json").out) == []
    assert asked(nothing, "--csv").out == "u\n"
    assert asked(nothing).out == "u\n-\n"


def test_a_person_gets_a_hundred_rows_and_a_program_all(asked: Ask) -> None:
    numbers = "SELECT range AS n FROM range(30000)"
    lines = asked(numbers).out.splitlines()
    assert lines == [" n", "--", *(f"{n:2}" for n in range(100)), "the first 100 rows: --csv or --json prints all"]
    assert asked(numbers, "--csv").out == "n\n" + "".join(f"{n}\n" for n in range(30000))


def test_without_a_question_tables_and_columns_are_listed_with_their_meanings(asked: Ask) -> None:
    told = asked()
    assert told.code == 0
    assert max(map(len, told.out.splitlines())) <= 80
    assert "experiments (4 rows)" in told.out
    words = " ".join(told.out.split())
    fields = [field for schema in SCHEMAS.values() for field in schema]
    assert len(fields) > 60
    for field in fields:
        assert field.metadata[b"meaning"].decode() in words
        assert f"  {field.name} " in told.out
    assert "X_BO_est 7 doubles" in words
    assert "mask_rle uint32s" in words


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["SELEC"], 'syntax error at or near "SELEC"'),
        (["SELECT nope FROM attempts"], 'column "nope" not found'),
        (["SELECT * FROM grasps"], "grasps does not exist; expected one of experiments, slots,"),
        (["SELECT CAST('x' AS INT) FROM attempts"], "Could not convert string 'x'"),
        ([""], "got an empty text"),
        (["SELECT 1; SELECT 2"], "expected one SELECT, got SELECT, SELECT"),
        (["DROP VIEW attempts"], "expected one SELECT, got DROP"),
        (["COPY attempts TO 'attempts.csv'"], "expected one SELECT, got COPY"),
        (["SET enable_external_access = true"], "expected one SELECT, got SET"),
        (["SELECT * FROM read_text('pyproject.toml')"], "Cannot access file"),
        (["SELECT * FROM 'pyproject.toml'"], "pyproject.toml does not exist"),
        (["SELECT * FROM read_csv('https://localhost/a.csv')"], "Cannot access"),
        (["SELECT * FROM database"], "database does not exist"),
        (["SELECT 1", "--csv", "--json"], "expected --csv or --json, got both"),
        (["--csv"], "expected a question in SQL for --csv or --json, got none"),
        (["SELECT u, u FROM attempts", "--json"], "expected columns of different names for --json, got u twice"),
        (["SELECT 'nan'::DOUBLE AS x", "--json"], "expected finite numbers for --json, got nan in x"),
    ],
)
def test_what_cannot_be_answered_is_one_line_and_exit_code_2(asked: Ask, arguments: list[str], words: str) -> None:
    told = asked(*arguments)
    assert told.code == 2
    assert words in told.err
    assert told.err.count("\n") == 1


def test_statements_that_write_or_reach_out_would_fail_even_if_they_were_let_through() -> None:
    with opened(run_of()) as database:
        for statement in (
            "COPY attempts TO 'attempts.csv'",
            "SET enable_external_access = true",
            "ATTACH 'other.db'",
            "INSTALL httpfs",
        ):
            with pytest.raises(duckdb.Error, match=r"disabled by configuration|has been locked"):
                database.execute(statement)


def test_an_error_while_rows_are_read_is_told_too(asked: Ask) -> None:
    late = "SELECT CASE WHEN range < 25000 THEN 1 ELSE error('too late') END FROM range(30000)"
    told = asked(late, "--csv")
    assert told.code == 2
    assert "too late" in told.err


def test_a_folder_without_a_run_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "query", tmp_path, "SELECT 1")
    assert (told.code, told.err.count("\n")) == (2, 1)
    assert "expected the folder of a run" in told.err


def test_a_reader_that_closes_the_pipe_ends_the_command_without_a_traceback(small_run: Path) -> None:
    numbers = ["query", str(small_run), "SELECT range FROM range(1000000)", "--csv"]
    with subprocess.Popen(
        [sys.executable, "-m", "experiments.cli", *numbers], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"range\n"
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 141


def test_without_duckdb_one_line_says_how_to_get_it(asked: Ask, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "duckdb", None)
    told = asked("SELECT 1")
    assert (told.code, told.err) == (
        2,
        "graspcell: error: query needs DuckDB; expected the extra: pip install 'graspcell[query]'\n",
    )


def test_ask_gives_the_rows_of_tables_made_by_hand() -> None:
    with opened(run_of(attempts=[{"u": 0.25}, {"u": 0.5}])) as database:
        names, rows = ask(database, "SELECT method, u FROM attempts ORDER BY u")
        assert names == ["method", "u"]
        assert list(rows) == [[("none", 0.25), ("none", 0.5)]]
