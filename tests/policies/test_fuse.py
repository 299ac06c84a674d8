import numpy as np
import pytest

from cell.interfaces import Action, Decision
from cell.layout import Layout
from cell.viewpoints import search_run
from maskval import Pose, angle_between
from policies import Fuse
from policies.fuse import mean_pose
from tests.fakes import brick, observation, on_belt, policy_setup, turned

LAYOUT, PART = Layout(), brick()
VIEWS = search_run(LAYOUT).views  # 0.2 m apart
X_BO = on_belt(PART, LAYOUT, turned())
CENTER_O = PART.mesh.center


def off(x_mm=0.0, yaw_deg=0.0):
    """The part, shifted along B's x and turned about its own middle."""
    middle = Pose.from_translation(X_BO.apply(CENTER_O))
    turn = Pose.from_rotvec((0, 0, np.radians(yaw_deg)), (x_mm / 1000, 0, 0))
    return middle @ turn @ middle.inverse() @ X_BO


def seen(view, u, *X_BO_each, refining=False):
    return observation(u, X_BC=VIEWS[view], X_BO=X_BO_each, refining=refining)


def test_a_first_view_is_decided_upon_as_by_threshold():
    fuse = Fuse(policy_setup())
    decision = fuse.decide(seen(0, [0.7, 0.1], off(), off(200)))
    assert (decision.action, decision.detection, decision.threshold, decision.u) == (Action.GRASP, 1, 0.2, 0.1)
    assert (decision.X_BO_est.matrix == seen(0, [0.1], off(200)).X_BO_est(0).matrix).all()
    assert Fuse(policy_setup()).decide(seen(0, [])) == Decision(Action.SEARCH)


def test_the_pose_grasped_is_the_mean_of_the_views_that_agree():
    fuse = Fuse(policy_setup())
    assert fuse.decide(seen(0, [0.3], off(-4, yaw_deg=3))).action is Action.REFINE
    decision = fuse.decide(seen(1, [0.1], off(4, yaw_deg=-3), refining=True))
    assert (decision.action, decision.threshold) == (Action.GRASP, 0.2)
    assert decision.u == pytest.approx((0.3 + 0.1) / 2)
    np.testing.assert_allclose(decision.X_BO_est.matrix, X_BO.matrix, atol=1e-9)


def test_a_mean_above_the_bound_is_not_grasped_though_the_last_view_alone_would_be():
    fuse = Fuse(policy_setup())
    fuse.decide(seen(0, [0.5], off()))
    decision = fuse.decide(seen(1, [0.1], off(), refining=True))
    assert (decision.action, decision.detection, decision.threshold) == (Action.SEARCH, 0, 0.2)
    assert decision.u == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("earlier", "averaged"),
    [
        ([(0, off(14))], 2),  # every point of the part is 14 mm away, of 15
        ([(0, off(16))], 1),
        ([(0, off(yaw_deg=20))], 1),  # about 12 mm · 20° = 22 mm at the brick's ends
        ([(1, off(2))], 1),  # the same view again
        ([(0, off(10)), (2, off(-10))], 2),  # each agrees with the newest, but not with the other
        ([(0, off(3)), (2, off(-3))], 3),
        ([(0, off(3)), (0, off(-3))], 2),  # the same view twice counts once
    ],
)
def test_only_views_from_apart_that_agree_each_with_each_are_averaged(earlier, averaged):
    fuse = Fuse(policy_setup())
    for view, pose in earlier:
        fuse.decide(seen(view, [0.19], pose))
    decision = fuse.decide(seen(1, [0.01], off()))
    # The means of one, two and three views: 0.01, 0.2 / 2 and 0.39 / 3.
    assert decision.u == pytest.approx({1: 0.01, 2: 0.1, 3: 0.13}[averaged])


def test_parts_beside_one_another_are_not_mixed_up():
    fuse = Fuse(policy_setup())
    fuse.decide(seen(0, [0.7, 0.3], off(), off(100)))
    decision = fuse.decide(seen(1, [0.4, 0.1], off(2), off(104)))
    assert (decision.detection, decision.action) == (1, Action.GRASP)
    np.testing.assert_allclose(decision.X_BO_est.matrix, off(102).matrix, atol=1e-9)


def test_two_policies_remember_nothing_of_one_another():
    Fuse(policy_setup()).decide(seen(0, [0.5], off()))
    assert Fuse(policy_setup()).decide(seen(1, [0.1], off())).u == 0.1


def test_the_mean_of_turns_is_half_way_and_that_of_one_pose_is_the_pose():
    poses = [off(yaw_deg=angle) for angle in (10, 30)]
    mean = mean_pose(poses, CENTER_O)
    assert angle_between(mean.rotation, X_BO.rotation) == pytest.approx(np.radians(20))
    np.testing.assert_allclose(mean.apply(CENTER_O), X_BO.apply(CENTER_O), atol=1e-12)
    assert mean_pose(poses[:1], CENTER_O) is poses[0]
