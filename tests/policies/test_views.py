import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.layout import Layout
from cell.motion import Motion, Unreachable
from cell.viewpoints import search_run
from policies.views import SIDES, TILTS_DEG, views_around
from tests.fakes import FakeStation, brick, observation, on_belt, policy_setup, turned

LAYOUT, PART = Layout(), brick()
SEARCH_VIEW = search_run(LAYOUT).views[2]


def test_all_views_centre_the_part_from_40_cm_and_are_tilted_as_they_say():
    X_BO = on_belt(PART, LAYOUT, turned(yaw_deg=20), y_W=-0.1)
    views = views_around(observation([0.5], X_BC=SEARCH_VIEW, X_BO=[X_BO]), 0, policy_setup())
    assert len(views) == 1 + len(TILTS_DEG) * SIDES
    middle_B = X_BO.apply(np.array([0.01, 0.005, 0.02]))  # of the brick's box
    for X_BC in views:
        np.testing.assert_allclose(X_BC.inverse().apply(middle_B), [0, 0, 0.40], atol=1e-12)
    tilts = [np.degrees(np.arccos(-X_BC.rotation[2, 2])) for X_BC in views]
    np.testing.assert_allclose(tilts, [0.0] + 8 * [20.0] + 8 * [35.0], atol=1e-5)
    directions = {tuple(np.round(X_BC.rotation[:, 2], 6)) for X_BC in views}
    assert len(directions) == len(views)


@pytest.mark.parametrize("x_W", [0.68, 1.0, 1.2])
def test_exactly_the_views_within_the_arms_reach_are_given(x_W):
    X_BO = on_belt(PART, LAYOUT, turned(), x_W=x_W)
    seen = observation([0.5], X_BC=SEARCH_VIEW, X_BO=[X_BO])
    views = views_around(seen, 0, policy_setup())
    motion = Motion(FakeStation(LAYOUT), LAYOUT, PRESETS["ur-default"])
    for X_BC in views:
        motion.joints_for_camera(X_BC)
    if x_W == 0.68:
        assert len(views) == 17
    else:
        assert len(views) < 17
        with pytest.raises(Unreachable):
            motion.joints_for_camera(_farthest(X_BO))


def _farthest(X_BO):
    """The view that looks back at the part from beyond it, tilted by 35°."""
    near = on_belt(PART, LAYOUT, turned(), x_W=0.68)
    views = views_around(observation([0.5], X_BC=SEARCH_VIEW, X_BO=[near]), 0, policy_setup())
    beyond = max(views, key=lambda X_BC: LAYOUT.X_WB.apply(X_BC.translation)[0])
    return X_BO @ near.inverse() @ beyond


def test_a_part_out_of_reach_has_no_views():
    X_BO = on_belt(PART, LAYOUT, turned(), x_W=2.0)
    assert views_around(observation([0.5], X_BC=SEARCH_VIEW, X_BO=[X_BO]), 0, policy_setup()) == []
