"""What scripts are made of: numbers, states, and the entry that is next."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from cell.records import State

T = TypeVar("T")

HOME = np.radians([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
CONTACT_FORCE = 45.0  # N of every scripted contact
HALF_WIDTH = 0.02  # m, between the jaws when they hold the brick
# Powers of two, so that sums of times are exact: a look from the next view takes 1 + 0.25 + 0.5 + 0.25 = 2 s.
MOVE_TIME, SETTLE_TIME, MASK_TIME, POSE_TIME = 1.0, 0.25, 0.5, 0.25
LOOK_TIME = MOVE_TIME + SETTLE_TIME + MASK_TIME + POSE_TIME
ATTEMPT = (  # the states of one that succeeds
    State.APPROACH,
    State.DESCEND,
    State.CLOSE,
    State.LIFT,
    State.TRANSFER,
    State.INSERT,
    State.RELEASE,
    State.RETREAT,
)


def scripted(script: Sequence[T], call: int) -> T:
    """The call-th entry of a script; its last one holds on."""
    return script[min(call, len(script) - 1)]
