"""What disturbs the cell, seen in whole experiments."""

import pytest

from experiments.experiment import ExperimentSpec, Result, run_experiment
from experiments.thresholds import load_thresholds
from sim.conditions import Conditions


def result(parts: int = 1, part: str = "antenna", experiment: int = 0, **knobs: object) -> Result:
    return run_experiment(
        ExperimentSpec(
            part, "none", "oracle", load_thresholds("paper"), "fast", parts, 5, experiment, Conditions(**knobs)
        )
    )


def test_latency_lengthens_a_slot_by_itself_for_every_look() -> None:
    usual, late = result(), result(latency_s=0.5)
    looks = len(usual.tables["frames"])
    assert looks == len(late.tables["frames"]) >= 1
    (short,), (long,) = usual.tables["slots"], late.tables["slots"]
    assert (short["outcome"], long["outcome"]) == ("placed", "placed")
    assert (long["end_s"] - long["start_s"]) - (short["end_s"] - short["start_s"]) == pytest.approx(0.5 * looks)


def test_a_camera_far_from_where_the_robot_believes_it_spoils_the_grasp() -> None:
    count = result(hand_eye_error_mm=(0.0, 40.0, 0.0)).count
    assert count is not None
    assert count.tp == 0
