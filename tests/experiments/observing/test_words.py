"""A moment in words."""

import pytest

from cell.interfaces import Outcome
from experiments.observing.observer import Status
from experiments.observing.words import headline, slot_in_words


@pytest.mark.parametrize(
    ("slots", "words"),
    [
        ((), "time slot 0 of 0..1"),
        ((None,), "time slot 1 of 0..1"),
        ((None, Outcome.PLACED), "time slot 1 of 0..1"),  # all are over
    ],
)
def test_the_time_slot_that_goes_on_is_told_and_the_last_one_at_the_end(
    slots: tuple[Outcome | None, ...], words: str
) -> None:
    assert slot_in_words(Status(slots=slots), 2) == words
    assert headline(Status(slots=slots), 7.0, 2) == f"  7.00 s | {words} | search"
