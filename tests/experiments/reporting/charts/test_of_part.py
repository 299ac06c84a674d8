import re
from typing import Any

import numpy as np
import pytest

from experiments.reporting.charts.of_part import MOST_POINTS, charts
from experiments.reporting.charts.seen import evaluation_of, seen_of
from maskval import NO_PART

WHO = ("maskval", "threshold")
NAMES = {WHO: "maskval"}


def experiment(looks: list[list[list[Any]]], chosen: int | None = None) -> dict[str, Any]:
    """Looks of detections [part, u, error in mm, visible share]; in each `chosen` is grasped."""
    action = "search" if chosen is None else "grasp"
    rows = [[frame, 1.0, 0, 0, action, chosen, 0.1, 0.5, seen] for frame, seen in enumerate(looks)]
    return {"looks": rows, "phases": [[0.0, 0], [6.0, 3], [10.0, 5]], "items": [{"k": "placed"}, {"k": "placed"}]}


def test_estimates_are_gathered_with_what_followed_and_parts_of_other_looks_are_others() -> None:
    seen = seen_of([experiment([[[3, 0.1, 2.0, 1.0], [None, 0.9, None, None]], [[3, 0.2, 4.0, 0.5]]], chosen=0)])
    assert seen.u.tolist() == [0.1, 0.9, 0.2]
    assert seen.errors.tolist() == [2.0, np.inf, 4.0]
    assert seen.acted.tolist() == [True, False, True]
    judged = evaluation_of(seen)
    assert judged.pose_part.tolist() == [0, NO_PART, 1]
    assert judged.part_visibility.tolist() == [1.0, 0.5]


@pytest.mark.parametrize(("count", "stated"), [(MOST_POINTS, "all 10000"), (MOST_POINTS + 1, "one in 2 of 10001")])
def test_a_chart_has_ten_thousand_points_at_most_and_states_its_sample(count: int, stated: str) -> None:
    numbers = np.random.default_rng(0).uniform(size=(count, 2))
    one = experiment([[[0, float(u), float(30 * error), 1.0] for u, error in numbers]])
    drawn = charts("handle", {WHO: [one]}, NAMES, {("handle", "maskval"): 0.5})
    (dots,) = re.findall(r'<path class="dots refused" d="([^"]*)"', drawn)
    assert dots.count("M") == -(-count // (2 if count > MOST_POINTS else 1))
    assert f"({stated})" in drawn


def test_time_is_told_by_phase_per_placed_part() -> None:
    drawn = charts("handle", {WHO: [experiment([[[0, 0.1, 2.0, 1.0]]])]}, NAMES, {})
    assert "<title>search: 3.0 s</title>" in drawn
    assert "<title>grasp: 2.0 s</title>" in drawn


def test_a_part_without_any_estimate_has_charts_of_what_there_is() -> None:
    drawn = charts("handle", {WHO: [experiment([])]}, NAMES, {})
    assert "where the time goes" in drawn
    assert "does u know the error" not in drawn
