from collections.abc import Callable

import numpy as np
import pytest

from cell.layout import Layout
from maskval import Pose
from sim.errors import StartError
from sim.model.parts import load_part
from sim.networks.random_streams import Streams
from sim.runtime.episode import starting_poses
from sim.runtime.start_check import check_start
from sim.runtime.world import World


@pytest.fixture(scope="module")
def world() -> World:
    return World(Layout(), load_part("antenna"), 2)


def begun(world: World) -> World:
    world.reset(starting_poses(world, Streams(0, 0, "antenna")))
    return world


def test_a_belt_of_parts_at_rest_passes(world: World) -> None:
    check_start(begun(world))
    assert np.abs(world.velocity(1)).max() < 0.05


def fallen(world: World) -> None:
    world.reset([Pose.from_translation((0.68, 0.0, 0.1)), Pose.from_translation((0.68, 1.5, 0.1))])


def in_the_container(world: World) -> None:
    center = Layout().container.slot_center(0, world.part_model.part.slot_size)
    world.reset([Pose.from_translation((0.68, 0.0, 0.1)), Pose.from_translation(center + [0.0, 0.0, 0.05])])


def moving(world: World) -> None:
    begun(world).velocity(1)[0] = 0.2


def pushed(world: World) -> None:
    begun(world).contact_forces()[:] = 3.0


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (fallen, r"part 1 begins at \(.*\) m, expected it on the belt"),
        (in_the_container, r"part 1 begins at \(.*\) m, expected it on the belt"),
        (moving, r"part 1 begins with 0\.20 m/s or rad/s, expected it at rest"),
        (pushed, r"the robot begins with 5\.2 N against a part, expected no touch"),  # √3 · 3 N
    ],
)
def test_a_spoiled_start_is_refused(world: World, spoil: Callable[[World], None], words: str) -> None:
    spoil(world)
    with pytest.raises(StartError, match=words):
        check_start(world)
