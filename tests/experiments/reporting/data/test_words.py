from dataclasses import replace

import pytest

from cell.interfaces import Outcome
from cell.records import Tally
from experiments.reporting.data.words import kind_of, verdict, why_attempt, why_time_out
from experiments.results.paired import Paired
from experiments.results.table import Cell, make_cell

STRUCK = {
    "outcome": "collision with belt",
    "last_state": "descend",
    "contact_force_N": 57.4,
    "u": 0.31,
    "threshold": 0.5,
}
WRONG = {"true_part": 3, "true_mdd_m": 0.0587, "true_visibility": 0.44}
RIGHT = {"true_part": 3, "true_mdd_m": 0.0021, "true_visibility": 1.0}
FALSE = {"true_part": None}
NAMES = {("none", "always"): "none", ("maskval", "threshold"): "maskval"}


def test_a_failed_attempt_says_what_was_struck_how_wrong_the_pose_was_and_that_u_let_it_pass() -> None:
    assert why_attempt(STRUCK, WRONG, "threshold") == (
        "The gripper struck the belt with 57 N on the way down. Its pose was 58.7 mm off (only 44 % of the part was "
        "visible). u = 0.31 stayed within the threshold 0.50, so the error went unnoticed."
    )


def test_a_policy_without_a_bound_is_named() -> None:
    told = why_attempt({**STRUCK, "threshold": None}, WRONG, "always")
    assert told.endswith("The policy “always” set no bound on u.")


def test_a_placed_part_has_its_pose_and_u_told_without_blame() -> None:
    placed = {**STRUCK, "outcome": "placed", "last_state": "retreat", "contact_force_N": None}
    assert why_attempt(placed, RIGHT, "threshold") == (
        "Placed in its slot. Its pose was right within 2.1 mm. u = 0.31 met the threshold 0.50."
    )
    assert "of symmetries, those of the part's file are counted" in why_attempt(placed, WRONG, "threshold")


def test_a_false_detection_is_called_one() -> None:
    assert "The detection shows no part at all." in why_attempt(STRUCK, FALSE, "threshold")


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_has_a_sentence_and_a_kind(outcome: Outcome) -> None:
    told = why_attempt({**STRUCK, "outcome": outcome.value}, RIGHT, "threshold")
    assert told[0].isupper()
    assert told.count(".") >= 3
    kind = kind_of(outcome.value)
    assert (kind == "placed", kind == "failed") == (outcome.is_true_positive, outcome.is_false_positive)


def test_a_time_out_says_whether_the_best_refusal_was_right() -> None:
    decision = {"u": 0.65, "threshold": 0.5}
    worse = ({"u": 0.9, "threshold": 0.5}, RIGHT)
    told = why_time_out(20.4, [worse, (decision, WRONG)], 13, [])
    assert told.startswith("The 20 s of this part ran out after 13 looks. The least u that was refused is 0.65, above")
    assert told.endswith("rightly refused.")
    assert why_time_out(20.0, [(decision, RIGHT)], 1, []).endswith("it would probably have held.")
    assert "found no part" in why_time_out(20.0, [], 4, [])
    assert "2 attempts in it came to nothing (void)." in why_time_out(20.0, [], 4, ["void", "void"])


def cell(method: str, policy: str, tp: int, fp: int, same: str | None) -> Cell:
    count = Tally(parts=8, tp=tp, fp=fp, fn=8 - tp, void=0, unreachable=0, timeouts=0, duration=80.0)
    return replace(make_cell(("handle", method, policy), [count]), same=same)


def test_the_verdict_names_the_method_that_places_most_and_whether_the_others_differ() -> None:
    best, worse = cell("maskval", "threshold", 6, 1, "a"), cell("none", "always", 4, 3, "b")
    assert verdict([worse, best], NAMES) == (
        "maskval places 75 % of the parts with 1 failed attempt; none 50 % with 3. The differences in parts placed are "
        "significant (5 %, Holm)."
    )
    level = verdict([replace(worse, same="a"), best], NAMES)
    assert level.endswith("It cannot be told apart from none in parts placed.")
    assert verdict([replace(best, same=None)], NAMES) == "maskval places 75 % of the parts with 1 failed attempt."


def test_the_verdict_names_the_methods_that_fail_more_often_than_the_best() -> None:
    best, worse = cell("maskval", "threshold", 6, 1, "a"), cell("none", "always", 4, 3, "a")
    difference = Paired("handle", "none", "always", "maskval", "threshold", 2, -1.0, (-3.0, 1.0), 2.0, (0.5, 3.5))
    assert verdict([best, worse], NAMES, [difference]).endswith("none fails more attempts (95 % interval).")
    unclear = replace(difference, failed_ci=(-0.5, 3.5))
    assert verdict([best, worse], NAMES, [unclear]).endswith("in parts placed.")
