from itertools import pairwise, product

import numpy as np
import pytest

from cell.grasping import (
    APPROACH_LENGTH,
    LIFT_HEIGHT,
    RELEASE_HEIGHT,
    GraspPlan,
    jaw_corners,
    look_at,
    plan_grasps,
    plan_places,
)
from cell.layout import Gripper, Layout
from cell.part import MAX_TILT
from maskval import Pose
from tests.fakes import brick, on_belt, turned

LAYOUT = Layout()
PART = brick()
# How far the part is rolled about its own x axis, and the grasp that then comes from above.
RESTING = {0: "from above", 90: "from left", 180: "from below", 270: "from right"}
RELEASE_HALF_OPENING = 0.032  # m


def lying(roll_deg: float, yaw_deg: float = 0.0, pitch_deg: float = 0.0) -> Pose:
    return on_belt(PART, LAYOUT, turned(roll_deg, pitch_deg, yaw_deg), y_W=0.2)


def tilt_deg(X_AB: Pose) -> float:
    """Angle between z_B and straight down in A."""
    return float(np.degrees(np.arccos(-X_AB.rotation[2, 2])))


@pytest.mark.parametrize("roll_deg", RESTING)
@pytest.mark.parametrize("yaw_deg", [0.0, 75.0, 200.0])
def test_a_resting_part_is_gripped_by_the_one_grasp_that_is_upright_then(roll_deg, yaw_deg):
    X_BO = lying(roll_deg, yaw_deg)
    plans = plan_grasps(PART, X_BO)
    assert [plan.grasp.name for plan in plans] == [RESTING[roll_deg]] * 2
    for plan in plans:
        assert plan.X_BO_est is X_BO
        np.testing.assert_allclose(plan.X_BT_grip.rotation[:, 2], [0, 0, -1], atol=1e-12)
        # The tool's point is the one that the grasp names on the part, here its middle.
        np.testing.assert_allclose(X_BO.inverse().apply(plan.X_BT_grip.translation), [0.01, 0.005, 0.02], atol=1e-12)


def test_the_two_ways_round_swap_the_jaws_and_nothing_else():
    one, other = plan_grasps(PART, lying(0.0, yaw_deg=30.0))
    np.testing.assert_allclose(one.X_BT_grip.rotation[:, :2], -other.X_BT_grip.rotation[:, :2], atol=1e-12)
    np.testing.assert_allclose(one.X_BT_grip.rotation[:, 2], other.X_BT_grip.rotation[:, 2], atol=1e-12)
    np.testing.assert_allclose(one.X_BT_grip.translation, other.X_BT_grip.translation, atol=1e-12)


def test_of_two_grasps_that_reach_a_tilted_part_the_more_upright_one_comes_first():
    plans = plan_grasps(PART, lying(42.0))
    assert [plan.grasp.name for plan in plans] == ["from above"] * 2 + ["from left"] * 2
    np.testing.assert_allclose([tilt_deg(plan.X_BT_grip) for plan in plans], [42, 42, 90 - 42, 90 - 42])


@pytest.mark.parametrize(("beyond_deg", "count"), [(-0.1, 2), (0.1, 0)])
def test_a_grasp_tilted_beyond_the_limit_is_none(beyond_deg, count):
    # Pitching turns the upright grasp away and brings no other one up.
    assert len(plan_grasps(PART, lying(0.0, pitch_deg=np.degrees(MAX_TILT) + beyond_deg))) == count


@pytest.mark.parametrize("pitch_deg", [90.0, -90.0])
def test_a_part_that_stands_on_its_end_has_no_grasp(pitch_deg):
    assert plan_grasps(PART, lying(0.0, pitch_deg=pitch_deg)) == []


@pytest.mark.parametrize("roll_deg", [0.0, 30.0])
def test_the_tool_comes_along_the_grasps_approach_and_leaves_straight_up(roll_deg):
    plans = plan_grasps(PART, lying(roll_deg, yaw_deg=75.0))
    assert len(plans) == 2
    for plan in plans:
        grip, approach_B = plan.X_BT_grip, plan.X_BT_grip.rotation[:, 2]
        np.testing.assert_allclose(grip.translation - plan.X_BT_before.translation, APPROACH_LENGTH * approach_B)
        np.testing.assert_allclose(plan.X_BT_lifted.translation - grip.translation, [0, 0, LIFT_HEIGHT], atol=1e-15)
        for X_BT in (plan.X_BT_before, plan.X_BT_lifted):
            np.testing.assert_array_equal(X_BT.rotation, grip.rotation)


def placings(container_slot: int) -> list[tuple[GraspPlan, Pose, Pose]]:
    """Every way to grip and to lay down each resting part: the plan, X_WO before, and X_WO when let go."""
    found = []
    for roll_deg, yaw_deg, pitch_deg in product(RESTING, (0.0, 75.0, 200.0), (0.0, 8.0)):
        for plan in plan_grasps(PART, lying(roll_deg, yaw_deg, pitch_deg)):
            X_TO = plan.X_BT_grip.inverse() @ plan.X_BO_est
            for place in plan_places(PART, LAYOUT, plan, container_slot, RELEASE_HALF_OPENING):
                found.append((plan, LAYOUT.X_WB @ plan.X_BO_est, LAYOUT.X_WB @ place.X_BT_release @ X_TO))
    assert len(found) == 4 * 3 * 2 * 2 * 2  # rolls, yaws, pitches, ways to grip, ways to lay down
    return found


@pytest.mark.parametrize("container_slot", [0, 3, 7])
def test_a_part_is_let_go_with_every_vertex_inside_its_slot_and_20_mm_above_the_floor(container_slot):
    center = LAYOUT.container.slot_center(container_slot, PART.slot_size)
    for _, _, X_WO in placings(container_slot):
        vertices_W = X_WO.apply(PART.mesh.vertices)
        assert (np.abs(vertices_W[:, :2] - center[:2]) < np.array(PART.slot_size) / 2).all()
        assert vertices_W[:, 2].min() - LAYOUT.container.floor_z == pytest.approx(0.020)
    assert RELEASE_HEIGHT == 0.020


def test_a_part_is_let_go_the_same_side_up_as_it_lay_on_the_belt():
    for _, X_WO_before, X_WO in placings(container_slot=0):
        np.testing.assert_allclose(X_WO.rotation[2], X_WO_before.rotation[2], atol=1e-12)


def test_a_part_is_let_go_with_its_x_axis_along_the_slot_in_both_directions():
    headings = [np.arctan2(X_WO.rotation[1, 0], X_WO.rotation[0, 0]) for _, _, X_WO in placings(container_slot=0)]
    np.testing.assert_allclose(np.sin(headings), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cos(headings), [1.0, -1.0] * (len(headings) // 2))


def test_part_and_opened_jaws_together_stand_in_the_middle_of_the_slot():
    center = LAYOUT.container.slot_center(0, PART.slot_size)
    gripper = LAYOUT.gripper
    reach = RELEASE_HALF_OPENING + gripper.finger_thickness  # of a jaw's outer side from the tool's point
    for plan, _, X_WO in placings(container_slot=0):
        X_WT = X_WO @ plan.X_BO_est.inverse() @ plan.X_BT_grip
        vertices_W = X_WO.apply(PART.mesh.vertices)
        assert abs(X_WT.rotation[1, 1]) == pytest.approx(1.0), "the jaws close across the slot"
        # Along the slot the part is longer than the fingers are wide, across it the jaws stand out.
        low = [vertices_W[:, 0].min(), min(vertices_W[:, 1].min(), X_WT.translation[1] - reach)]
        high = [vertices_W[:, 0].max(), max(vertices_W[:, 1].max(), X_WT.translation[1] + reach)]
        np.testing.assert_allclose((np.array(low) + high) / 2, center[:2])


def test_above_a_slot_is_straight_above_the_place_to_let_go():
    plan = plan_grasps(PART, lying(0.0))[0]
    places = plan_places(PART, LAYOUT, plan, 5, RELEASE_HALF_OPENING)
    assert len(places) == 2
    for place in places:
        way_B = place.X_BT_above.translation - place.X_BT_release.translation
        np.testing.assert_allclose(way_B, [0, 0, LIFT_HEIGHT], atol=1e-12)
        np.testing.assert_array_equal(place.X_BT_above.rotation, place.X_BT_release.rotation)


def test_jaw_corners_stand_a_finger_beyond_the_opening_and_a_tip_beyond_the_tool_point():
    gripper = Gripper(tip_below_tcp=0.015, finger_thickness=0.02, finger_width=0.03)
    corners_T = jaw_corners(gripper, 0.04, Pose.identity())
    assert corners_T.shape == (8, 3)
    np.testing.assert_allclose(corners_T.max(axis=0), [0.03 / 2, 0.04 + 0.02, 0.015])
    np.testing.assert_allclose(corners_T.min(axis=0)[:2], [-0.03 / 2, -(0.04 + 0.02)])


def test_look_at_looks_straight_down_from_the_distance_with_the_point_in_the_middle():
    point_B = np.array([-0.6, 0.3, -0.05])
    X_BC = look_at(point_B, 0.4)
    np.testing.assert_array_equal(X_BC.rotation[:, 2], [0, 0, -1])
    point_C = X_BC.inverse().apply(point_B)
    assert point_C[2] == pytest.approx(0.4)
    np.testing.assert_allclose(LAYOUT.camera.project(point_C), [640 / 2, 480 / 2])


def test_look_at_has_the_images_width_along_the_belt():
    points_W = np.array([[0.68, y, -0.05] for y in (-0.1, 0.0, 0.1)])
    points_B = LAYOUT.X_WB.inverse().apply(points_W)
    pixels = LAYOUT.camera.project(look_at(points_B[1], 0.5).inverse().apply(points_B))
    np.testing.assert_allclose(pixels[:, 1], 240.0)
    assert [abs(b[0] - a[0]) for a, b in pairwise(pixels)] == pytest.approx([600 * 0.1 / 0.5] * 2)
