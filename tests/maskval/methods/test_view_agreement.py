import numpy as np
import pytest

from maskval import Estimates, InvalidEstimatesError, Pose, TemporalConsistency, needs_of
from tests.maskval import shapes
from tests.maskval.shapes import VGA

# Looks down from (x, 0, 0.6): half a turn about x.
DOWN = Pose.from_rotvec((np.pi, 0, 0))


def above(x: float) -> Pose:
    return Pose.from_translation((x, 0, 0.6)) @ DOWN


def at(x: float, yaw: float = 0.0) -> Pose:
    """X_BO of a sheet that lies on the ground."""
    return Pose.from_translation((x, 0, 0)) @ Pose.from_rotvec((0, 0, yaw))


def seen(X_BC: Pose, *sheets: Pose) -> Estimates:
    poses = tuple(X_BC.inverse() @ X_BO for X_BO in sheets)
    return Estimates(
        VGA, shapes.square(), np.zeros((len(poses), 480, 640), dtype=bool), (poses,), np.ones(len(poses)), X_BC=X_BC
    )


def test_without_an_earlier_view_nothing_is_known() -> None:
    assert TemporalConsistency()(seen(above(0.0), at(0.0), at(0.1))).tolist() == [1.0, 1.0]


def test_the_same_pose_from_elsewhere_is_certain() -> None:
    method = TemporalConsistency()
    method(seen(above(0.0), at(0.05, 0.3)))
    assert method(seen(above(0.2), at(0.05, 0.3))) == pytest.approx([0.0], abs=1e-12)


@pytest.mark.parametrize(("shift_m", "u"), [(0.01, 0.2), (0.015, 0.3), (0.05, 1.0), (0.2, 1.0)])
def test_a_pose_is_as_uncertain_as_two_views_disagree(shift_m: float, u: float) -> None:
    method = TemporalConsistency()
    method(seen(above(0.0), at(0.0)))
    assert method(seen(above(0.2), at(shift_m))) == pytest.approx([u])


def test_a_turn_counts_by_the_point_that_it_moves_farthest() -> None:
    method = TemporalConsistency(maximum_m=0.1)
    method(seen(above(0.0), at(0.0)))
    corner = 0.05 * np.sqrt(2)
    assert method(seen(above(0.2), at(0.0, yaw=0.3))) == pytest.approx([2 * corner * np.sin(0.15) / 0.1])


def test_each_pose_is_compared_with_the_nearest_one_of_any_earlier_view() -> None:
    method = TemporalConsistency()
    method(seen(above(0.0), at(0.0), at(0.3)))
    method(seen(above(0.2), at(0.105)))
    u = method(seen(above(0.4), at(0.1), at(0.302), at(0.0)))
    assert u == pytest.approx([0.005 / 0.05, 0.002 / 0.05, 0.0], abs=1e-12)


def test_a_look_from_the_same_place_says_nothing() -> None:
    method = TemporalConsistency(baseline_m=0.1)
    method(seen(above(0.0), at(0.0)))
    assert method(seen(above(0.0), at(0.0))).tolist() == [1.0]
    assert method(seen(above(0.099), at(0.0))).tolist() == [1.0]
    assert method(seen(above(0.101), at(0.0))) == pytest.approx([0.0], abs=1e-12)


def test_the_fixed_frame_may_be_any() -> None:
    X_WB = Pose.from_translation((1, 2, 3)) @ Pose.from_rotvec((0.1, -0.2, 0.9))
    u = []
    for X in (Pose.identity(), X_WB):
        method = TemporalConsistency()
        method(seen(X @ above(0.0), X @ at(0.0)))
        u.append(method(seen(X @ above(0.2), X @ at(0.012, 0.05))))
    assert u[0] == pytest.approx(u[1])
    assert 0.2 < u[0][0] < 0.4


def test_a_new_object_remembers_nothing_and_no_detections_are_no_views() -> None:
    method = TemporalConsistency()
    assert method(seen(above(0.0))).shape == (0,)
    assert method(seen(above(0.2), at(0.0))).tolist() == [1.0]
    assert TemporalConsistency()(seen(above(0.4), at(0.0))).tolist() == [1.0]


def test_it_needs_the_cameras_pose() -> None:
    assert needs_of(TemporalConsistency()).X_BC
    made = Estimates(VGA, shapes.square(), np.zeros((0, 480, 640), dtype=bool), ((),), np.ones(0))
    with pytest.raises(InvalidEstimatesError, match="needs the camera's pose X_BC, but the estimates hold none"):
        TemporalConsistency()(made)


@pytest.mark.parametrize(("maximum_m", "baseline_m"), [(0.0, 0.1), (np.nan, 0.1), (0.05, -0.1), (np.inf, 0.1)])
def test_a_scale_that_is_none_is_refused(maximum_m: float, baseline_m: float) -> None:
    with pytest.raises(InvalidEstimatesError, match="maximum_m must be > 0 and baseline_m >= 0"):
        TemporalConsistency(maximum_m, baseline_m)
