from typing import Any

import pytest

from experiments.reporting.pictures.take import moment

ITEM: dict[str, Any] = {"k": "failed", "b": 10.0, "z": 16.0, "hit": None, "force": None, "touch": None}
CLOSED = [
    {"source": "close", "time_s": 8.0, "reason": "before it"},
    {"source": "close", "time_s": 13.5, "reason": "force reached"},
]


@pytest.mark.parametrize(
    ("item", "transitions", "time", "told", "is_grasp"),
    [
        (ITEM | {"k": "time-out"}, CLOSED, 16.0, "at 16.0 s, when the time ran out", False),
        (ITEM | {"hit": 12.25, "force": 57.4, "touch": "belt"}, CLOSED, 12.25, "at 12.2 s, 57 N on the belt", True),
        (ITEM, CLOSED, 13.5, "at 13.5 s, force reached", True),
        (ITEM, CLOSED[:1], 16.0, "at 16.0 s, at the end", False),
    ],
)
def test_the_pictures_show_what_decided_an_attempt(
    item: Any, transitions: Any, time: float, told: str, is_grasp: bool
) -> None:
    assert moment(item, transitions) == (time, told, is_grasp)
