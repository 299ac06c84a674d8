import numpy as np
import pytest

from cell.grasping import look_at
from cell.interfaces import Action, Decision
from cell.layout import Layout
from cell.viewpoints import search_run
from maskval import Pose
from policies import NextBestView, ThresholdPolicy
from policies.next_best_view import visible_errors
from policies.views import views_around
from tests.fakes import box_mesh, brick, observation, on_belt, policy_setup, turned

LAYOUT, PART = Layout(), brick()
VIEW = search_run(LAYOUT).views[2]


@pytest.mark.parametrize("u", [0.1, 0.2, 0.61, 1.0])
def test_next_best_view_decides_like_threshold_where_it_does_not_look_again(u):
    seen = observation([0.9, u], X_BC=VIEW, X_BO=2 * [on_belt(PART, LAYOUT, turned())])
    assert NextBestView(policy_setup()).decide(seen) == ThresholdPolicy(0.2, 0.6).decide(seen)


def test_the_errors_that_a_view_from_above_shows_are_those_of_a_box_by_hand():
    """A square plate of 200 mm, seen from 0.4 m with f = 600 px: 300 px wide, and 10 mm are 15 px."""
    plate = box_mesh((-0.1, -0.1, 0.0), (0.1, 0.1, 0.0001))
    along_x, along_y, along_z, about_x, about_y, about_z = visible_errors(
        plate, Pose.identity(), look_at(np.zeros(3), 0.4), LAYOUT.camera
    )
    # Shifted by 15 of 300 px: IoU = 285 / 315. Nearer by 10 mm: 390 / 400 of the width, so its square of the area.
    assert along_x == pytest.approx(1 - 285 / 315, abs=0.01)
    assert along_y == pytest.approx(1 - 285 / 315, abs=0.01)
    assert along_z == pytest.approx(1 - (390 / 400) ** 2, abs=0.015)
    # Tilted by 10 mm / 141 mm = 4°, the width shrinks by 1 − cos 4° = 0.2 %, and one end is 10 mm nearer than before.
    assert max(about_x, about_y) < 0.03
    assert about_z > 2 * about_x


def test_a_part_outside_of_the_picture_shows_no_error():
    errors = visible_errors(PART.mesh, Pose.from_translation((2.0, 0.0, 0.0)), look_at(np.zeros(3), 0.6), LAYOUT.camera)
    assert errors.tolist() == 6 * [0.0]


@pytest.mark.parametrize("turn", [turned(), turned(roll_deg=90, yaw_deg=30), turned(yaw_deg=75)])
def test_the_view_taken_shows_the_error_that_is_hardest_to_see_best_of_all_in_reach(turn):
    X_BO = on_belt(PART, LAYOUT, turn)
    seen = observation([0.4], X_BC=VIEW, X_BO=[X_BO])
    decision = NextBestView(policy_setup()).decide(seen)
    assert (decision.action, decision.detection, decision.threshold) == (Action.REFINE, 0, 0.6)

    def worst(X_BC):
        pictures = [visible_errors(PART.mesh, X_BO, X, LAYOUT.camera) for X in (VIEW, X_BC)]
        return min(map(sum, zip(*pictures, strict=True)))

    views = views_around(seen, 0, policy_setup())
    assert len(views) == 17
    assert worst(decision.X_BC) == max(map(worst, views))
    assert worst(decision.X_BC) > worst(views[0])  # better than straight from above


def test_without_a_view_in_reach_the_choice_is_left_to_the_controller():
    far = observation([0.4], X_BC=VIEW, X_BO=[on_belt(PART, LAYOUT, turned(), x_W=2.0)])
    assert NextBestView(policy_setup()).decide(far) == Decision(Action.REFINE, 0, 0.6)
