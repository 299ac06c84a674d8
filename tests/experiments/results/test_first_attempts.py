import json

import pyarrow.parquet as pq
import pytest

from cell.interfaces import Outcome
from experiments.results.first_attempts import FirstAttempts, first_attempts
from experiments.results.table import make_cell
from tests.experiments.command import command
from tests.experiments.results.test_table_intervals import count

FAILED = Outcome.COLLISION_PART.value
PLACED = Outcome.PLACED.value


def tables(*attempts: tuple[int | None, str]) -> dict[str, list[dict[str, object]]]:
    """Rows of attempts, each upon a frame of its own, for a true part (None for a false detection) with an outcome."""
    return {
        "estimates": [
            {"frame": frame, "detection": detection, "true_part": part if detection == 1 else 99}
            for frame, (part, _) in enumerate(attempts)
            for detection in (0, 1)
        ],
        "attempts": [
            {"attempt": number, "frame": number, "detection": 1, "outcome": outcome}
            for number, (_, outcome) in enumerate(attempts)
        ],
    }


def test_a_part_that_fails_again_and_again_counts_once() -> None:
    found = first_attempts(tables((3, FAILED), (3, FAILED), (3, FAILED), (5, PLACED)))
    assert found == FirstAttempts(parts=2, placed=1, failed=1)
    assert found.ap == 1 / 2


def test_a_part_that_is_placed_after_a_failure_counts_as_failed_at_first() -> None:
    assert first_attempts(tables((3, FAILED), (3, PLACED))) == FirstAttempts(parts=1, placed=0, failed=1)


def test_a_part_that_is_struck_for_after_it_was_placed_counts_as_placed_and_as_failed() -> None:
    assert first_attempts(tables((3, PLACED), (3, FAILED))) == FirstAttempts(parts=1, placed=1, failed=1)


def test_attempts_that_do_not_count_are_no_first_ones() -> None:
    idle = [(3, Outcome.VOID.value), (3, Outcome.UNREACHABLE.value), (4, Outcome.VOID.value)]
    assert first_attempts(tables(*idle, (3, PLACED))) == FirstAttempts(parts=1, placed=1, failed=0)
    assert first_attempts(tables(*idle)).ap is None


def test_each_attempt_upon_a_false_detection_counts_for_a_part_of_its_own() -> None:
    assert first_attempts(tables((None, FAILED), (None, FAILED), (0, PLACED))) == FirstAttempts(3, 1, 2)


def test_a_cell_has_the_mean_of_the_first_attempts_and_the_sum_of_the_failed_parts() -> None:
    counts = [count(4, 4, 4), None, count(6, 2, 2), count(0, 0, 8)]
    firsts = [FirstAttempts(4, 3, 1), None, FirstAttempts(8, 6, 2), FirstAttempts(0, 0, 0)]
    cell = make_cell(("handle", "none", "always"), counts, range(4), firsts)
    assert (cell.ap, cell.ap_first, cell.parts_failed) == (pytest.approx(5 / 8), 3 / 4, 3)
    low, high = cell.ap_first_ci
    assert low < 3 / 4 < high
    unknown = make_cell(("handle", "none", "always"), counts)
    assert (unknown.ap_first, unknown.ap_first_ci, unknown.parts_failed) == (None, None, None)


def test_compare_writes_the_first_attempts_that_its_logs_hold(capsys, tmp_path) -> None:
    told = command(
        capsys,
        *("compare", "--methods", "none", "--objects", "handle", "--gap", "fitted"),
        *("--experiments", 1, "--seed", 0, "--jobs", 1, "--out", tmp_path),
    )
    assert told.code == 0
    (cell,) = json.loads((tmp_path / "table.json").read_text(encoding="utf-8"))["cells"]
    read = {name: pq.read_table(tmp_path / f"{name}.parquet").to_pylist() for name in ("estimates", "attempts")}
    found = first_attempts(read)
    assert (cell["ap_first"], cell["parts_failed"]) == (found.ap, found.failed)
    assert 0 < found.failed <= cell["fp"]
    assert found.placed <= cell["tp"]
