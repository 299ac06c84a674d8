import mujoco
import numpy as np
import pytest

from cell.interfaces import Contact, Outcome, Touch
from maskval import Pose
from sim.model.parts import PartModel
from sim.runtime.referee import SimReferee
from sim.runtime.station import SimStation
from sim.runtime.world import World


@pytest.fixture
def referee(station: SimStation, antenna_world: World) -> SimReferee:
    return SimReferee(antenna_world, station)


def put(world: World, part: int, X_WO: Pose) -> None:
    """Puts a part somewhere without physics."""
    address = world.mj_model.joint(f"part_{part}").qposadr[0]
    world.data.qpos[address : address + 3] = X_WO.translation
    world.data.qpos[address + 3 : address + 7] = X_WO.quaternion_wxyz
    mujoco.mj_forward(world.mj_model, world.data)


def in_slot(world: World, slot: int, offset: tuple[float, float, float] = (0, 0, 0), roll: float = 0.0) -> Pose:
    center = world.layout.container.slot_center(slot, world.part_model.part.slot_size)
    return Pose.from_rotvec(np.array([roll, 0.0, 0.0]), center + offset)


def touch_first(station: SimStation, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(station, "touched_parts", lambda: [0])


def test_touching_nothing_is_a_void(referee: SimReferee) -> None:
    referee.attempt_begins(0)
    assert referee.verdict(None) is Outcome.VOID


@pytest.mark.parametrize(
    ("touch", "outcome"),
    [
        (Touch.BELT, Outcome.COLLISION_BELT),
        (Touch.PART, Outcome.COLLISION_PART),
        (Touch.CONTAINER, Outcome.COLLISION_CONTAINER),
        (Touch.PRESSED, Outcome.COLLISION_CONTAINER),
        (Touch.ROBOT, Outcome.COLLISION_ROBOT),
    ],
)
def test_a_contact_is_a_collision_with_what_was_touched(referee: SimReferee, touch: Touch, outcome: Outcome) -> None:
    assert referee.verdict(Contact(touch, 50.0, 1.0)) is outcome


@pytest.mark.parametrize(
    ("slot", "offset", "roll_deg", "outcome"),
    [
        (3, (0.0, 0.0, 0.0), 0.0, Outcome.PLACED),
        (3, (0.024, 0.033, 0.0), 0.0, Outcome.PLACED),  # 200 × 130 mm leave 25 and 34 mm around 150 × 62 mm
        (3, (0.027, 0.0, 0.0), 0.0, Outcome.MISPLACED),
        (3, (0.0, 0.036, 0.0), 0.0, Outcome.MISPLACED),
        (3, (0.0, 0.0, 0.01), 15.0, Outcome.PLACED),
        (3, (0.0, 0.0, 0.01), 25.0, Outcome.MISPLACED),  # tilted by more than 20°
        (3, (0.0, 0.0, 0.05), 0.0, Outcome.MISPLACED),  # on the walls
        (2, (0.0, 0.0, 0.0), 0.0, Outcome.MISPLACED),  # another part's slot
    ],
)
def test_a_part_is_placed_when_it_lies_in_its_slot_as_it_lay_on_the_belt(
    referee: SimReferee,
    station: SimStation,
    antenna_world: World,
    monkeypatch: pytest.MonkeyPatch,
    slot: int,
    offset: tuple[float, float, float],
    roll_deg: float,
    outcome: Outcome,
) -> None:
    referee.attempt_begins(3)
    touch_first(station, monkeypatch)
    put(antenna_world, 0, in_slot(antenna_world, slot, offset, np.radians(roll_deg)))
    assert referee.verdict(None) is outcome


def test_a_part_that_was_touched_and_lies_elsewhere_was_dropped(
    referee: SimReferee, station: SimStation, antenna_world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    referee.attempt_begins(0)
    touch_first(station, monkeypatch)
    assert referee.verdict(None) is Outcome.DROPPED  # still on the belt
    put(antenna_world, 0, Pose.from_translation(np.array([0.4, 0.9, antenna_world.layout.floor_z])))
    assert referee.verdict(None) is Outcome.DROPPED  # on the floor


def test_parts_on_the_belt_are_counted_where_they_are(
    referee: SimReferee, antenna_world: World, antenna: PartModel
) -> None:
    assert referee.parts_on_belt() == antenna_world.parts == 2
    put(antenna_world, 0, in_slot(antenna_world, 0))
    assert referee.parts_on_belt() == 1
    below = antenna_world.layout.belt.top_z - 0.3
    put(antenna_world, 1, Pose.from_translation(np.array([antenna_world.layout.belt.center_x, 0.0, below])))
    assert referee.parts_on_belt() == 0
    assert antenna.part.name == "antenna"
