import pytest

from cell.interfaces import Outcome
from cell.records import Tally


def count(tp: int, fp: int, fn: int) -> Tally:
    return Tally(parts=8, tp=tp, fp=fp, fn=fn, void=2, unreachable=1, timeouts=8 - tp - fp, duration=160.0)


def test_ap_is_the_share_of_placed_parts_among_attempts_that_count():
    assert count(tp=3, fp=2, fn=4).ap == 3 / (3 + 2)


def test_ar_is_the_share_of_placed_parts_among_those_placed_or_left_on_the_belt():
    assert count(tp=3, fp=2, fn=4).ar == 3 / (3 + 4)


def test_neither_void_nor_unreachable_nor_timeouts_count():
    assert (count(tp=1, fp=0, fn=0).ap, count(tp=1, fp=0, fn=0).ar) == (1.0, 1.0)


def test_ap_is_none_without_an_attempt_that_counts():
    assert count(tp=0, fp=0, fn=8).ap is None
    assert count(tp=0, fp=0, fn=8).ar == 0 / 8


def test_ar_is_none_when_nothing_was_placed_and_nothing_is_left():
    assert count(tp=0, fp=8, fn=0).ar is None
    assert count(tp=0, fp=8, fn=0).ap == 0 / 8


@pytest.mark.parametrize(
    ("outcome", "is_tp", "is_fp"),
    [
        (Outcome.PLACED, True, False),
        (Outcome.COLLISION_PART, False, True),
        (Outcome.COLLISION_BELT, False, True),
        (Outcome.COLLISION_CONTAINER, False, True),
        (Outcome.COLLISION_ROBOT, False, True),
        (Outcome.DROPPED, False, True),
        (Outcome.MISPLACED, False, True),
        (Outcome.VOID, False, False),
        (Outcome.UNREACHABLE, False, False),
    ],
)
def test_only_placed_is_a_tp_and_void_and_unreachable_are_no_fp(outcome, is_tp, is_fp):
    assert (outcome.is_true_positive, outcome.is_false_positive) == (is_tp, is_fp)
