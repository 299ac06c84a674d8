import os
from dataclasses import dataclass
from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.setup.checks import FAILED, all_at_least, at_least, check_cell, one_of, worker_count, writable_folder

MOST = 2147483647  # of 32 bits with a sign


@dataclass
class Options:
    max_runs: int = 5
    seed: int = 0


def test_the_ends_of_what_is_valid_are_valid() -> None:
    check_cell(1, 0, "fast")
    check_cell(8, MOST, "ur-default")
    at_least("--runs", 3, 3)
    at_least("--runs", MOST, 3)
    all_at_least(Options(), max_runs=5, seed=0)
    one_of("--speed", "fast", ("slow", "fast"))


@pytest.mark.parametrize(
    ("parts", "seed", "speed", "words"),
    [
        (0, 0, "fast", r"--parts in 1\.\.8, the container's slots, got 0"),
        (9, 0, "fast", r"--parts in 1\.\.8, the container's slots, got 9"),
        (8, -1, "fast", f"--seed of at least 0 and at most {MOST}, got -1"),
        (8, MOST + 1, "fast", f"--seed of at least 0 and at most {MOST}, got {MOST + 1}"),
        (8, 0, "warp", "unknown speed 'warp': expected one of ur-default, moderate, fast"),
    ],
)
def test_a_cell_that_cannot_be_is_refused(parts: int, seed: int, speed: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        check_cell(parts, seed, speed)


def test_an_option_below_its_least_value_is_named_as_it_is_typed() -> None:
    with pytest.raises(UsageError, match=f"expected --max-runs of at least 6 and at most {MOST}, got 5"):
        all_at_least(Options(), seed=0, max_runs=6)


def test_a_folder_is_made_and_stays_empty(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    assert writable_folder(folder) == folder
    assert os.listdir(folder) == []
    assert writable_folder(folder) == folder


def test_no_number_of_jobs_means_one_for_each_core(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: 6)
    assert [worker_count(jobs) for jobs in (0, 1, 3)] == [6, 1, 3]
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert worker_count(0) == 1


def test_the_exit_code_of_failed_experiments_is_the_documented_one() -> None:
    page = (Path(__file__).parents[3] / "docs" / "logs.md").read_text(encoding="utf-8")
    assert f"0 if every experiment has a result, {FAILED} if one failed" in page
