"""What `graspcell run` says of a record, from records made by hand, and its exit codes."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cell.interfaces import Action, Contact, Decision, Outcome, Touch
from cell.records import AttemptRecord, DecisionRecord, State, Tally, TimeSlot, Transition
from experiments.commands import run as run_module
from experiments.commands.run import lines
from experiments.results.store import SCHEMAS
from experiments.setup.experiment import ExperimentResult, ExperimentSpec
from sim.networks.ground_truth import FrameTruth, LatestTruth
from tests.experiments.command import command
from tests.experiments.results.test_recorder import AHEAD, CAMERA, observation
from tests.fakes import brick

ATTEMPT = AttemptRecord(0, 0, 7, 1, 0.2, 0.8, AHEAD, "from above", 4, 3.0, 8.0, State.INSERT, None, Outcome.PLACED)


def told(record: object) -> list[str]:
    numbers = np.full((30, 40), -1, dtype=np.int8)
    numbers[10:20, 10:22] = 1
    latest_truth = LatestTruth()
    latest_truth.keep(FrameTruth(7, numbers, (AHEAD, AHEAD), CAMERA, brick().mesh))
    return lines(record, latest_truth, brick())


def seen(decision: Decision, **other: Any) -> list[str]:
    return told(DecisionRecord(2, 5, replace(observation(), **other), decision))


def test_a_look_is_told_with_each_detection_and_its_error_against_the_truth() -> None:
    assert seen(Decision(Action.SEARCH)) == [
        "   1.50 s  second look, frame 7: 2 detections",
        "             detection 0: 100 px, score 0.90, u = 0.250 (part 1, true error 4.0 mm)",
        "             detection 1: 100 px, score 0.40, u = 0.750 (shows no part)",
        "             decision: search",
    ]
    assert seen(Decision(Action.SEARCH), refining=False)[0] == "   1.50 s  look, frame 7: 2 detections"


@pytest.mark.parametrize(
    ("decision", "words"),
    [
        (Decision(Action.GRASP, 0, threshold=0.5), "grasp detection 0, u ≤ 0.5"),
        (Decision(Action.REFINE, 1, threshold=0.8), "refine detection 1, u ≤ 0.8"),
        (Decision(Action.GRASP, 0), "grasp detection 0"),
        (Decision(Action.SEARCH, 1, threshold=0.6), "search, best was detection 1, u > 0.6"),
    ],
)
def test_a_decision_is_told_with_the_bound_that_was_met_or_missed(decision: Decision, words: str) -> None:
    assert seen(decision)[-1] == f"             decision: {words}"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, "grasp from above: placed"),
        ({"grasp": None, "outcome": Outcome.UNREACHABLE}, f"no grasp: {Outcome.UNREACHABLE.value}"),
        (
            {"contact": Contact(Touch.BELT, 44.6, 5.0), "outcome": Outcome.COLLISION_BELT},
            "grasp from above: collision with belt (45 N in insert)",
        ),
    ],
)
def test_an_attempt_is_told_with_what_stopped_it(change: dict[str, Any], words: str) -> None:
    assert told(replace(ATTEMPT, **change)) == [f"   8.00 s  attempt on detection 1, {words}"]


def test_a_parts_time_is_told_with_what_became_of_it() -> None:
    assert told(TimeSlot(1, 10.0, 19.5, Outcome.PLACED)) == ["  19.50 s  time slot 1: placed after 9.5 s"]
    assert told(TimeSlot(0, 0.0, 20.0, None)) == ["  20.00 s  time slot 0: time-out after 20.0 s"]


@pytest.mark.parametrize(
    ("source", "target", "is_told"),
    [
        (State.RELEASE, State.RETREAT, True),
        (State.DECIDE, State.REFINE, True),
        (State.LOOK, State.DECIDE, False),
        (State.REFINE, State.DECIDE, True),
        (State.DECIDE, State.APPROACH, False),
    ],
)
def test_of_changes_of_state_those_are_told_whose_reason_says_more(source: State, target: State, is_told: bool) -> None:
    expected = [f"   4.00 s  {target.value}: why"] if is_told else []
    assert told(Transition(4.0, source, target, "why")) == expected


@pytest.mark.parametrize("failed", [False, True])
def test_the_last_line_and_the_exit_code_say_what_came_of_it_and_the_logs_are_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failed: bool
) -> None:
    def run(spec: ExperimentSpec, tell: Any) -> ExperimentResult:
        tell(TimeSlot(0, 0.0, 20.0, None), LatestTruth())
        tables: dict[str, Any] = {name: [] for name in SCHEMAS}
        count = Tally(8, 1, 2, 3, 4, 5, 6, 99.54)
        return ExperimentResult(spec, None if failed else count, "no room" if failed else None, tables)

    monkeypatch.setattr(run_module, "run_experiment", run)
    done = command(capsys, "run", "--object", "handle", "--experiment", 3, "--seed", 4, "--out", tmp_path)
    head, line, last = done.out.splitlines()
    assert head == "handle × maskval, experiment 3 of seed 4, noisy estimators"
    assert line == "  20.00 s  time slot 0: time-out after 20.0 s"
    counts = "1 placed (TP), 2 failed (FP), 3 left on the belt (FN), 4 void, 5 unreachable, 6 time-outs, in 99.5 s"
    assert (done.code, last) == ((3, "failed: no room") if failed else (0, counts))
    assert {path.name for path in tmp_path.iterdir()} == {
        "config.toml",
        "manifest.json",
        *(f"{name}.parquet" for name in SCHEMAS),
    }
    assert '"seed": 4' in (tmp_path / "manifest.json").read_text()
