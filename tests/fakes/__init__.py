"""A cell without physics for the tests: everything that the controller meets follows a script.

What the real things guarantee or demand, the fakes check or do too: a trajectory begins where the arm is, a contact
lasts until the arm has moved away without watching, jaws move only as time goes on.
"""

from tests.fakes.cycle import Experiment, Records, run_cycle
from tests.fakes.estimators import FakeMasks, FakeMethod, FakePoses
from tests.fakes.policy import observation, policy_setup
from tests.fakes.referee import VOID, FakeReferee, Try
from tests.fakes.scene import box_mesh, brick, on_belt, small_layout, turned
from tests.fakes.script import ATTEMPT, CONTACT_FORCE, HALF_WIDTH, HOME, LOOK_TIME, MOVE_TIME, SETTLE_TIME, scripted
from tests.fakes.station import FakeStation

__all__ = [
    "ATTEMPT",
    "CONTACT_FORCE",
    "HALF_WIDTH",
    "HOME",
    "LOOK_TIME",
    "MOVE_TIME",
    "SETTLE_TIME",
    "VOID",
    "Experiment",
    "FakeMasks",
    "FakeMethod",
    "FakePoses",
    "FakeReferee",
    "FakeStation",
    "Records",
    "Try",
    "box_mesh",
    "brick",
    "observation",
    "on_belt",
    "policy_setup",
    "run_cycle",
    "scripted",
    "small_layout",
    "turned",
]
