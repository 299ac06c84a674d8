import numpy as np
import pytest

from cell.layout import Container, Layout
from maskval import Pose

CONTAINER = Container(center_x=1.0, center_y=2.0, floor_z=-0.1, wall_thickness=0.01, columns=2, rows=3)
SIZE = (0.19, 0.09)  # with a wall: a pitch of 0.2 and 0.1


def test_slots_are_numbered_row_by_row_from_least_x_and_most_y():
    centers = [CONTAINER.slot_center(slot, SIZE) for slot in range(6)]
    expected = [(x, y, -0.1) for y in (2.0 + 0.1, 2.0, 2.0 - 0.1) for x in (1.0 - 0.1, 1.0 + 0.1)]
    np.testing.assert_allclose(centers, expected)


@pytest.mark.parametrize("slot", [-1, 6])
def test_a_slot_that_the_container_has_not_is_refused(slot):
    with pytest.raises(IndexError, match=rf"slot must lie in 0\.\.5, got {slot}"):
        CONTAINER.slot_center(slot, SIZE)


def test_the_base_is_half_a_turn_from_the_world():
    layout = Layout()
    np.testing.assert_allclose(layout.X_WB.apply(np.array([0.7, 0.2, 0.1])), [-0.7, -0.2, 0.1])
    assert isinstance(layout.gripper.X_FT, Pose)
    np.testing.assert_allclose(layout.gripper.X_FT.translation, [0, 0, layout.gripper.tcp_from_flange])
