"""The experiment of a video is the one that happened."""

from itertools import pairwise

import numpy as np
import pytest

from cell.records import State
from experiments.observing.take import Take, take
from experiments.observing.words import in_words, slot_in_words
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from experiments.setup.thresholds import load_thresholds

SPEC = ExperimentSpec(
    part="handle",
    method="maskval",
    estimator="noisy",
    thresholds=load_thresholds("derived"),
    speed="ur-default",
    parts=2,
    seed=0,
    experiment=0,
)


@pytest.fixture(scope="module")
def ran() -> ExperimentResult:
    return run_experiment(SPEC)


@pytest.fixture(scope="module")
def taken() -> Take:
    return take(SPEC)


def test_a_run_for_a_video_has_the_tables_of_the_run_without_one_bit_for_bit(
    ran: ExperimentResult, taken: Take
) -> None:
    assert taken.result is not None
    assert {name: len(rows) for name, rows in ran.tables.items() if rows}.keys() >= {"frames", "decisions", "attempts"}
    assert taken.result.tables == ran.tables
    assert taken.result.count == ran.count


def test_the_film_has_every_step_and_leaves_the_world_alone(ran: ExperimentResult, taken: Take) -> None:
    assert ran.count is not None
    assert taken.film.duration == pytest.approx(ran.count.duration, abs=taken.world.time_step)
    assert taken.world.on_step is None
    first, last = taken.film.at(0.0), taken.film.at(1e6)
    assert np.array_equal(taken.film.at(-1.0), first)
    assert last == pytest.approx(taken.world.data.qpos, abs=1e-6)
    assert np.abs(last - first).max() > 0.1


def test_the_status_is_what_the_tables_say_of_a_time(ran: ExperimentResult, taken: Take) -> None:
    changes = ran.tables["transitions"]
    assert len(changes) > 10
    for change, following in pairwise(changes):
        if following["time_s"] - change["time_s"] > 0.01:
            assert taken.observer.at(change["time_s"] + 0.005).state == State(change["target"])
    assert taken.observer.at(0.0).slots == ()
    assert [str(outcome) for outcome in taken.observer.at(1e6).slots] == [row["outcome"] for row in ran.tables["slots"]]


def test_an_attempt_is_shown_from_its_look_to_its_end(ran: ExperimentResult, taken: Take) -> None:
    frames = {row["frame"]: row["time_s"] for row in ran.tables["frames"]}
    assert len(ran.tables["attempts"]) >= 1
    for row in ran.tables["attempts"]:
        assert taken.span(row["attempt"]) == (frames[row["frame"]], row["end_s"])
    assert taken.span(None) == (0.0, taken.film.duration)


def test_an_attempt_that_never_was_is_refused_with_those_that_were(taken: Take) -> None:
    most = len(taken.observer.attempts) - 1
    for wrong in (-1, most + 1):
        with pytest.raises(LookupError, match=f"in 0..{most}"):
            taken.span(wrong)


def test_a_decision_is_told_with_its_u_and_threshold_in_ascii(ran: ExperimentResult, taken: Take) -> None:
    told = {}
    for status in taken.observer.history:
        if status.decided is not None:
            told[status.decided.decision_index] = in_words(status.decided)
    assert len(told) == len(ran.tables["decisions"])
    for row in ran.tables["decisions"]:
        text = told[row["decision"]]
        assert text.isascii()
        assert text.endswith(row["action"])
        if row["threshold"] is not None:
            sign = ">" if row["action"] == "search" else "<="
            assert text.startswith(f"u = {row['u']:.3f} {sign} {row['threshold']:.3f}")


def test_a_time_slot_is_told_by_its_number_in_the_log(ran: ExperimentResult, taken: Take) -> None:
    rows = ran.tables["slots"]
    assert len(rows) == SPEC.parts
    for row in rows:
        status = taken.observer.at((row["start_s"] + row["end_s"]) / 2)
        assert slot_in_words(status, SPEC.parts) == f"time slot {row['slot']} of 0..{SPEC.parts - 1}"
