"""Rows of the logs, from records made by hand: no physics."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from cell.interfaces import Action, Contact, Decision, Detection, Frame, Observation, Outcome, Touch
from cell.part import Part
from cell.records import AttemptRecord, DecisionRecord, FailedFrame, State, Tally, TimeSlot, Transition
from experiments.results.recorder import Recorder, Row, pose_row
from experiments.results.store import SCHEMAS
from maskval import Camera, Pose
from sim.networks.ground_truth import FrameTruth, LatestTruth
from tests.fakes import brick

KEY = {"object": "brick", "method": "maskval", "experiment": 3}
CAMERA = Camera(fx=40.0, fy=40.0, cx=20.0, cy=15.0, width=40, height=30)
AHEAD = Pose(np.eye(3), np.array([0.0, 0.0, 0.5]))
X_BC = Pose(np.eye(3), np.array([0.1, 0.2, 0.3]))
FRAME = Frame(index=7, time=1.5, camera=CAMERA, X_BC=X_BC)


def off_by(x: float) -> Pose:
    return Pose(np.eye(3), AHEAD.translation + [x, 0.0, 0.0])


def mask(*columns: int) -> np.ndarray:
    shown = np.zeros((30, 40), dtype=np.bool_)
    shown[10:20, columns[0] : columns[1]] = True
    return shown


def observation(networks: int = 2) -> Observation:
    """The first detection shows part 1, whose pose is off by 4 mm and 6 mm; the second shows nothing."""
    return Observation(
        frame=FRAME,
        detections=(Detection(mask(10, 20), 0.9), Detection(mask(30, 40), 0.4)),
        poses=((off_by(0.004), AHEAD), (off_by(0.006), AHEAD))[:networks],
        uncertainties=np.array([0.25, 0.75]),
        refining=True,
        time_left=10.0,
        inference_time=0.4,
    )


def recorded(*records: object, kind: Part | None = None) -> dict[str, list[Row]]:
    numbers = np.full((30, 40), -1, dtype=np.int8)
    numbers[10:20, 10:22] = 1
    latest_truth = LatestTruth()
    latest_truth.keep(FrameTruth(7, numbers, (Pose.identity(), AHEAD), CAMERA, brick().mesh))
    recorder = Recorder(KEY, kind or brick(), latest_truth)
    for record in records:
        recorder(record)
    return recorder.tables


def test_the_logged_errors_of_a_part_are_the_least_over_its_symmetries() -> None:
    half = Pose.from_rotvec((0.0, 0.0, np.pi))
    turned = replace(observation(), poses=((off_by(0.004) @ half, AHEAD), (off_by(0.006), AHEAD)))
    for symmetries, first in (((), None), ((Pose.identity(), half), 0.004)):
        kind = replace(brick(), symmetries=symmetries)
        row = recorded(DecisionRecord(2, 5, turned, Decision(Action.SEARCH)), kind=kind)["estimates"][0]
        assert row["true_mdd_2_m"] == pytest.approx(0.006)
        assert row["true_mdd_m"] == pytest.approx(first) if first else row["true_mdd_m"] > 0.02


def only(tables: dict[str, list[Row]], name: str) -> dict[str, Any]:
    """The one row of a table, without its key, which it has."""
    (row,) = tables[name]
    assert {key: row.pop(key) for key in KEY} == KEY
    assert set(row) <= set(SCHEMAS[name].names)
    return row


def test_there_is_a_list_of_rows_for_each_table_of_the_logs() -> None:
    assert recorded() == {name: [] for name in SCHEMAS}


def test_a_pose_is_its_translation_and_then_its_quaternion_with_w_first() -> None:
    half_turn = Pose(np.diag([1.0, -1.0, -1.0]), np.array([1.0, 2.0, 3.0]))
    row = pose_row(half_turn)
    assert row[:3] == [1.0, 2.0, 3.0]
    assert np.abs(row[3:]).tolist() == [0.0, 1.0, 0.0, 0.0]
    assert {type(number) for number in row} == {float}


def test_a_change_of_state_and_a_slot_are_rows() -> None:
    tables = recorded(Transition(2.5, State.LOOK, State.DECIDE, "seen"), TimeSlot(1, 0.0, 9.0, Outcome.PLACED))
    assert only(tables, "transitions") == {"time_s": 2.5, "source": "look", "target": "decide", "reason": "seen"}
    assert only(tables, "slots") == {"slot": 1, "start_s": 0.0, "end_s": 9.0, "outcome": "placed"}
    assert only(recorded(TimeSlot(0, 0.0, 20.0, None)), "slots")["outcome"] is None


def test_what_was_seen_is_a_frame_with_a_row_for_each_estimate_and_the_truth_beside_it() -> None:
    tables = recorded(DecisionRecord(2, 5, observation(), Decision(Action.SEARCH)))
    assert only(tables, "frames") == {
        "frame": 7,
        "time_s": 1.5,
        "refining": True,
        "X_BC": pose_row(X_BC),
        "inference_s": 0.4,
        "detections": 2,
        "failure": None,
    }
    first, second = tables["estimates"]
    assert (first["frame"], first["detection"], first["score"], first["u"]) == (7, 0, 0.9, 0.25)
    assert (first["X_CO_est"], first["X_CO_est_2"]) == (pose_row(off_by(0.004)), pose_row(off_by(0.006)))
    assert first["mask_rle"][:3] == [10 * 30 + 10, 10, 20]  # column by column: ten of 30, then rows 10 to 19 of each
    assert first["true_part"] == 1
    assert (first["true_mdd_m"], first["true_mdd_2_m"]) == pytest.approx((0.004, 0.006))
    assert 0.0 < first["true_visibility"] <= 1.0
    assert (second["detection"], second["u"], second["true_part"]) == (1, 0.75, None)
    assert [name for name in second if name.startswith("true_")] == ["true_part"]


def test_with_one_network_the_second_pose_and_its_error_are_missing() -> None:
    first, _ = recorded(DecisionRecord(2, 5, observation(networks=1), Decision(Action.SEARCH)))["estimates"]
    assert (first["X_CO_est_2"], first["true_mdd_2_m"]) == (None, None)
    assert first["true_mdd_m"] == pytest.approx(0.004)


def test_a_decision_has_the_uncertainty_that_it_was_made_upon() -> None:
    grasp = Decision(Action.GRASP, 1, threshold=0.8, X_BO_est=AHEAD)
    expected = {
        "decision": 5,
        "slot": 2,
        "frame": 7,
        "action": "grasp",
        "detection": 1,
        "u": 0.75,
        "threshold": 0.8,
        "X_BO_est": pose_row(AHEAD),
        "X_BC": None,
    }
    assert only(recorded(DecisionRecord(2, 5, observation(), grasp)), "decisions") == expected
    fused = replace(grasp, action=Action.REFINE, u=0.1, X_BO_est=None, X_BC=X_BC)
    changed = {"action": "refine", "u": 0.1, "X_BO_est": None, "X_BC": pose_row(X_BC)}
    assert only(recorded(DecisionRecord(2, 5, observation(), fused)), "decisions") == expected | changed
    searched = only(recorded(DecisionRecord(2, 5, observation(), Decision(Action.SEARCH))), "decisions")
    assert (searched["detection"], searched["u"], searched["threshold"]) == (None, None, None)


def test_a_frame_that_failed_has_the_reason_and_what_was_concluded_before() -> None:
    blind = only(recorded(FailedFrame(FRAME, False, None, "no light")), "frames")
    assert (blind["failure"], blind["inference_s"], blind["detections"], blind["refining"]) == (
        "no light",
        None,
        None,
        False,
    )
    tables = recorded(FailedFrame(FRAME, True, observation(), "the policy raised"))
    row = only(tables, "frames")
    assert (row["failure"], row["inference_s"], row["detections"]) == ("the policy raised", 0.4, 2)
    assert (len(tables["estimates"]), tables["decisions"]) == (2, [])


def test_an_attempt_has_a_number_and_what_stopped_it() -> None:
    stopped = AttemptRecord(
        slot=2,
        decision_index=5,
        frame=7,
        detection=1,
        u=0.2,
        threshold=0.8,
        X_BO_est=AHEAD,
        grasp="from above",
        container_slot=4,
        start=3.0,
        end=8.0,
        last_state=State.DESCEND,
        contact=Contact(Touch.BELT, 45.0, 5.0),
        outcome=Outcome.COLLISION_BELT,
    )
    tables = recorded(stopped, replace(stopped, contact=None, outcome=Outcome.PLACED))
    first, second = tables["attempts"]
    assert first == KEY | {
        "attempt": 0,
        "slot": 2,
        "decision": 5,
        "frame": 7,
        "detection": 1,
        "u": 0.2,
        "threshold": 0.8,
        "X_BO_est": pose_row(AHEAD),
        "grasp": "from above",
        "container_slot": 4,
        "start_s": 3.0,
        "end_s": 8.0,
        "last_state": "descend",
        "contact_with": "belt",
        "contact_force_N": 45.0,
        "contact_time_s": 5.0,
        "outcome": "collision with belt",
    }
    assert {name for name in first if first[name] != second[name]} == {
        "attempt",
        "contact_with",
        "contact_force_N",
        "contact_time_s",
        "outcome",
    }
    assert (second["attempt"], second["contact_with"]) == (1, None)


def test_a_record_of_unknown_kind_is_refused() -> None:
    with pytest.raises(TypeError, match="a record of unknown kind: str"):
        recorded("something")


@pytest.mark.parametrize("failed", [False, True])
def test_an_experiments_own_row_has_its_counts_or_the_reason_why_there_are_none(failed: bool) -> None:
    recorder = Recorder(KEY, brick(), LatestTruth())
    count = None if failed else Tally(8, 1, 2, 3, 4, 5, 6, 99.5)
    recorder.finish(11, "oracle", count, "no room" if failed else None)
    row = only(recorder.tables, "experiments")
    told = {"seed": 11, "estimator": "oracle", "failure": "no room" if failed else None}
    counts = {"parts": 8, "tp": 1, "fp": 2, "fn": 3, "void": 4, "unreachable": 5, "timeouts": 6, "duration_s": 99.5}
    assert row == told | ({} if failed else counts)
