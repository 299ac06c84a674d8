"""The questions of docs/query.md, asked to a small run and answered once more from its rows."""

import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from experiments import load
from experiments.reading.query import ask, opened
from experiments.reading.run import Run
from tests.experiments.reading.runs import run_of

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "query.md").read_text(encoding="utf-8")
QUESTIONS = dict(re.findall(r"^\*\*(.*?)\*\*.*?^```sql\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
Rows = list[tuple[Any, ...]]


def answer(run: Run, beginning: str) -> Rows:
    (sql,) = [sql for question, sql in QUESTIONS.items() if question.startswith(beginning)]
    with opened(run) as database:
        _, rows = ask(database, sql)
        return [row for some in rows for row in some]


def joined(run: Run) -> list[dict[str, Any]]:
    """The attempts with the estimates that they are about."""
    names = ("object", "method", "policy", "experiment", "frame", "detection")
    estimates = {tuple(row[name] for name in names): row for row in run.estimates.to_pylist()}
    return [estimates[tuple(row[name] for name in names)] | row for row in run.attempts.to_pylist()]


def fails(outcome: str) -> bool:
    return outcome not in ("placed", "void", "unreachable")


@pytest.fixture
def run(small_run: Path) -> Run:
    return load(small_run)


def test_the_page_has_ten_questions() -> None:
    assert len(QUESTIONS) == PAGE.count("```sql") == 10


@pytest.fixture
def beside_the_run(small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The working folder is one in which `make run` has made a run."""
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "compare").symlink_to(small_run)
    monkeypatch.chdir(tmp_path)


def execute(page: str) -> None:
    """Runs the only block of Python of a page."""
    text = (DOCS / page).read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    exec(compile(code, page, "exec"), {})


@pytest.mark.usefixtures("beside_the_run")
def test_the_code_of_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    execute("query.md")
    assert capsys.readouterr().out.endswith("the uncertainty decided upon\n")


@pytest.mark.usefixtures("beside_the_run")
def test_the_code_of_the_page_on_logs_prints_a_line_for_each_attempt(
    run: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    execute("logs.md")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(run.attempts) > 0
    assert all("true_mdd_m" in line for line in lines)


def test_ap_and_ar_of_each_method(run: Run) -> None:
    sums: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    for row in run.experiments.to_pylist():
        for name in ("tp", "fp", "fn", "duration_s"):
            sums[row["method"]][name] += row[name]
    expected = [
        ("handle", method, one["tp"] / (one["tp"] + one["fp"]), one["tp"] / (one["tp"] + one["fn"]))
        for method, one in sorted(sums.items())
    ]
    found = answer(run, "How did each method do")
    assert [row[:4] for row in found] == expected
    assert [row[4] for row in found] == pytest.approx(
        [one["duration_s"] / one["tp"] for _, one in sorted(sums.items())]
    )


def test_parts_that_failed_under_every_method() -> None:
    attempts = [("none", 0, "dropped"), ("none", 1, "dropped"), ("maskval", 0, "misplaced"), ("maskval", 1, "void")]
    keys = [{"method": method, "policy": method, "frame": 0, "detection": part} for method, part, _ in attempts]
    run = run_of(
        experiments=[{"method": "none", "policy": "none"}, {"method": "maskval", "policy": "maskval"}],
        attempts=[key | {"outcome": outcome} for key, (_, _, outcome) in zip(keys, attempts, strict=True)],
        estimates=[key | {"true_part": part} for key, (_, part, _) in zip(keys, attempts, strict=True)],
    )
    assert answer(run, "Which parts failed under every method") == [("antenna", 0, 0)]


def test_no_part_of_the_small_run_failed_under_every_method(run: Run) -> None:
    assert {row["method"] for row in run.attempts.to_pylist() if fails(row["outcome"])} == {"none"}
    assert answer(run, "Which parts failed under every method") == []


def test_u_of_the_attempts_that_struck_the_belt(run: Run) -> None:
    struck = [row for row in run.attempts.to_pylist() if row["outcome"] == "collision with belt"]
    names = ("object", "method", "experiment", "attempt", "u", "threshold", "contact_force_N")
    assert len(struck) == 1
    assert answer(run, "What was *u* of the attempts") == [tuple(row[name] for name in names) for row in struck]


def test_errors_of_placed_and_failed_attempts(run: Run) -> None:
    errors: dict[tuple[str, str], list[float]] = defaultdict(list)
    for row in joined(run):
        errors[row["method"], row["outcome"]].append(1000 * row["true_mdd_m"])
    found = {(method, outcome): (count, worst) for method, outcome, count, _, worst in answer(run, "How wrong was")}
    assert found == {group: (len(some), max(some)) for group, some in errors.items()}
    assert ("none", "dropped") in found


def test_estimates_that_were_certain_and_wrong() -> None:
    estimates = [("maskval", 0.1, 0.02), ("maskval", 0.3, 0.02), ("maskval", 0.1, 0.01), ("none", 0.0, 0.02)]
    rows = [{"method": method, "u": u, "true_mdd_m": error, "frame": 4} for method, u, error in estimates]
    found = answer(run_of(estimates=rows), "Which estimates were certain and wrong")
    assert found == [("maskval", 0, 4, None, 0.1, 20.0, None)]


def test_u_over_the_visibility(run: Run) -> None:
    groups: dict[tuple[str, float], list[float]] = defaultdict(list)
    for row in run.estimates.to_pylist():
        if row["true_part"] is not None:
            groups[row["method"], min(3, int(4 * row["true_visibility"])) / 4].append(row["u"])
    found = answer(run, "Does *u* follow")
    assert [row[:3] for row in found] == [(*group, len(some)) for group, some in sorted(groups.items())]
    assert [row[3] for row in found] == pytest.approx([sum(some) / len(some) for _, some in sorted(groups.items())])


def test_detections_that_showed_no_part() -> None:
    rows = [{"true_part": part, "frame": frame} for frame, part in enumerate([0, None, 1, None, None])]
    assert answer(run_of(estimates=rows), "How many detections") == [("antenna", "none", 5, 3)]


def test_frames_and_second_looks_per_placed_part(run: Run) -> None:
    frames, placed = run.frames.to_pylist(), run.experiments.to_pylist()
    expected = []
    for method, policy in (("maskval", "threshold"), ("none", "always")):
        tp = sum(row["tp"] for row in placed if row["method"] == method)
        own = [row["refining"] for row in frames if row["method"] == method]
        expected.append(("handle", method, policy, len(own) / tp, sum(own) / tp))
    assert answer(run, "What did looking cost") == expected


def test_parts_that_maskval_placed_and_none_failed_on(run: Run) -> None:
    by_part: dict[tuple[int, int], dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for row in joined(run):
        by_part[row["experiment"], row["true_part"]][row["method"]].add(row["outcome"])
    expected = [
        ("handle", *part, outcome)
        for part, outcomes in sorted(by_part.items())
        if "placed" in outcomes["maskval"]
        for outcome in sorted(outcomes["none"])
        if fails(outcome)
    ]
    assert len(expected) == 2
    assert answer(run, "In which experiments did maskval place") == expected


def test_the_times_of_all_states_add_up_to_the_time_of_the_experiments(run: Run) -> None:
    found = answer(run, "How much of its time")
    for method in ("none", "maskval"):
        own = [row for row in run.experiments.to_pylist() if row["method"] == method]
        times = {state: total for of, state, total, _ in found if of == method}
        assert sum(times.values()) == pytest.approx(sum(row["duration_s"] for row in own), abs=0.01)
        assert min(times.values()) > -1e-9
        assert {"search", "look", "approach", "transfer"} <= set(times)
        assert sum(row[3] for row in found if row[0] == method) == pytest.approx(100)
