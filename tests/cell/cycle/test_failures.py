"""Policies and estimators that fail."""

import re
import sys
import time
from typing import Any

import numpy as np
import pytest

from cell.errors import CellError, EstimatorError, PolicyError
from cell.interfaces import Action, Decision
from cell.records import FailedFrame
from policies import Always
from tests.cell.cycle.runs import Deciding, config
from tests.fakes import run_cycle


def raising() -> Any:
    raise LookupError("no such table")


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (raising, "raised LookupError: no such table"),
        (lambda: None, "expected a cell.interfaces.Decision, got NoneType"),
        (lambda: "grasp", "expected a cell.interfaces.Decision, got str"),
        (lambda: Decision(Action.GRASP, 2), "expected a detection in 0..1 to grasp, got 2"),
        (lambda: Decision(Action.GRASP, -1), "expected a detection in 0..1 to grasp, got -1"),
        (lambda: Decision(Action.REFINE, 2), "expected a detection in 0..1 to refine, got 2"),
        (lambda: Decision(Action.GRASP), "expected a detection in 0..1 to grasp, got None"),
        (lambda: Decision(Action.GRASP, 1.0), "expected a detection in 0..1 to grasp, got 1.0"),
        (lambda: Decision(Action.SEARCH, 2), "expected a detection in 0..1 to search, got 2"),
        (lambda: Decision("grasp", 0), "expected a cell.interfaces.Action, got 'grasp'"),
        (lambda: Decision(Action.GRASP, 0, "low"), "expected threshold to be a finite number or None, got 'low'"),
        (lambda: Decision(Action.GRASP, 0, float("nan")), "expected threshold to be a finite number or None, got nan"),
        (
            lambda: Decision(Action.GRASP, 0, None, np.eye(4)),
            "expected X_BO_est to be a maskval.Pose or None, got ndarray",
        ),
        (lambda: Decision(Action.REFINE, 0, X_BC="up"), "expected X_BC to be a maskval.Pose or None, got str"),
        (lambda: sys.exit("bye"), "raised SystemExit: bye"),
    ],
)
def test_a_policy_that_raises_or_names_what_is_not_there_is_refused_by_name_and_frame(answer, message):
    place = r"( \(test_failures\.py:\d+\))?"
    with pytest.raises(PolicyError, match=f"^{re.escape(f'Deciding on frame 1: {message}')}{place}$"):
        run_cycle(Deciding(answer), masks=[[0.9, 0.8]])


def test_rubbish_from_a_network_ends_the_experiment_and_not_only_the_slot():
    with pytest.raises(EstimatorError, match=r"FakeMasks on frame 2: expected score 0 in \[0, 1\], got 7.0"):
        run_cycle(Always(), config=config(parts=2), masks=[[], [], [7.0]])


@pytest.mark.parametrize("case", ["detector", "policy"])
def test_the_frame_on_which_something_failed_is_told_of(case):
    told: list[object] = []
    fails = Deciding(raising, first=2) if case == "policy" else Always()
    masks = [[]] * 2 + [[0.9]] if case == "policy" else [[], [], [7.0]]
    with pytest.raises(CellError) as error:
        run_cycle(fails, masks=masks, listener=told.append)
    (failed,) = (record for record in told if isinstance(record, FailedFrame))
    assert (failed.frame.index, failed.refining, failed.reason) == (2, False, str(error.value))
    assert (failed.observation is None) == (case == "detector")
    assert told[-1] is failed


def test_a_policy_that_hangs_is_ended_by_name_and_frame():
    with pytest.raises(PolicyError, match=r"^Deciding on frame 1: took longer than 0\.25 s$"):
        run_cycle(Deciding(lambda: time.sleep(30)), config=config(time_limit=0.25))
