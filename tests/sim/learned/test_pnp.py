import numpy as np
import pytest
import scipy.optimize

from maskval import Correspondences, Pose
from sim.learned.pnp import DepthEstimate, solve
from tests.sim.learned.perfect import SKEWED

X_CO = Pose.from_rotvec((0.4, -0.7, 0.9), (0.06, -0.05, 0.55))
RNG = np.random.default_rng(1)
POINTS_O = RNG.uniform(-0.06, 0.06, (80, 3))
EXACT = SKEWED.project(X_CO.apply(POINTS_O))
DEPTH = DepthEstimate(np.array((0.01, 0.0, 0.02)), float(np.log(X_CO.apply((0.01, 0.0, 0.02))[2])), 0.05)


def test_the_minimum_is_that_of_a_general_solver() -> None:
    sigma = RNG.uniform(0.5, 2.0, 80)
    found = Correspondences(POINTS_O, EXACT + sigma[:, None] * RNG.normal(size=(80, 2)), sigma)
    weight = 0.2

    def residuals(pose: np.ndarray) -> np.ndarray:
        X = Pose.from_rotvec(pose[:3], pose[3:])
        e = np.linalg.norm(found.errors_px(X, SKEWED), axis=1) / sigma
        z = X.apply(DEPTH.point_O)[2]
        robust = 3.0 * np.sqrt(weight * np.log1p((e / 3.0) ** 2))  # whose squares are Cauchy's
        return np.append(robust, (np.log(z) - DEPTH.log_depth) / DEPTH.sigma)

    start = np.array((0.4, -0.7, 0.9, 0.06, -0.05, 0.55))
    best = scipy.optimize.least_squares(residuals, start, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    expected = Pose.from_rotvec(best.x[:3], best.x[3:])
    pose = solve(found, SKEWED, DEPTH, weight)
    assert pose is not None
    # Where the last step gains less than 1e-5 of the cost, what is left is a few µm.
    assert pose.apply(POINTS_O) == pytest.approx(expected.apply(POINTS_O), abs=2e-5)


def test_a_fifth_of_wild_correspondences_hardly_moves_the_pose() -> None:
    pixels = EXACT.copy()
    pixels[::5] += RNG.uniform(-80, 80, (16, 2))
    pose = solve(Correspondences(POINTS_O, pixels, np.ones(80)), SKEWED, DEPTH, 1.0)
    assert pose is not None
    assert np.linalg.norm(pose.apply(POINTS_O) - X_CO.apply(POINTS_O), axis=1).max() < 1e-3


@pytest.mark.parametrize("count", [0, 3, 5])
def test_too_few_correspondences_give_no_pose(count: int) -> None:
    found = Correspondences(POINTS_O[:count], EXACT[:count], np.ones(count))
    assert solve(found, SKEWED, DEPTH, 1.0) is None


def test_points_in_one_place_give_no_pose_or_one_before_the_camera() -> None:
    found = Correspondences(np.zeros((20, 3)), np.full((20, 2), 300.0), np.ones(20))
    pose = solve(found, SKEWED, DEPTH, 1.0)
    assert pose is None or pose.translation[2] > 0


def test_a_start_with_unsure_points_behind_the_camera_is_none() -> None:
    behind = X_CO.inverse().apply(np.array(((0.0, 0.0, -0.2), (0.1, 0.0, -0.3))))
    points_O, pixels = np.concatenate((POINTS_O, behind)), np.concatenate((EXACT, np.full((2, 2), 100.0)))
    found = Correspondences(points_O, pixels, np.append(np.ones(80), (50.0, 50.0)))
    assert solve(found, SKEWED, DEPTH, 1.0) is None
