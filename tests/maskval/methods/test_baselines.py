import numpy as np
import pytest
import scipy

from maskval import Camera, DetectorScore, Estimates, InvalidEstimatesError, NoUncertainty, Pose, RandomUncertainty
from tests.maskval import shapes
from tests.maskval.shapes import VGA


def estimates(poses: list[Pose], scores: np.ndarray | None = None) -> Estimates:
    masks = np.zeros((len(poses), VGA.height, VGA.width), dtype=bool)
    return Estimates(VGA, shapes.square(), masks, (tuple(poses),), np.ones(len(poses)) if scores is None else scores)


def test_no_uncertainty_trusts_every_pose() -> None:
    assert NoUncertainty()(estimates(shapes.random_poses(0, 2))).tolist() == [0.0, 0.0]


def test_the_detectors_score_is_the_certainty() -> None:
    scores = np.array([1.0, 0.75, 0.0])
    assert DetectorScore()(estimates(shapes.random_poses(0, 3), scores)).tolist() == [0.0, 0.25, 1.0]


def test_a_score_that_is_no_certainty_is_refused() -> None:
    with pytest.raises(InvalidEstimatesError, match=r"scores must be in \[0, 1\], but are \[1.5\]"):
        DetectorScore()(estimates(shapes.random_poses(0, 1), np.array([1.5])))


@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1])
def test_chance_is_uniform_over_poses(seed: int) -> None:
    count, tiny = 4000, Camera(1, 1, 0, 0, 1, 1)
    poses = tuple(Pose.from_translation((1e-6 * i, 0, 0.5)) for i in range(count))
    masks, scores = np.zeros((count, 1, 1), dtype=bool), np.ones(count)
    u = RandomUncertainty(seed)(Estimates(tiny, shapes.square(), masks, (poses,), scores))
    assert len(set(u.tolist())) == count
    assert scipy.stats.kstest(u, "uniform").pvalue > 0.001
    assert abs(np.corrcoef(u[:-1], u[1:])[0, 1]) < 3 / np.sqrt(count)


def test_chance_is_the_same_for_the_same_pose_in_any_company_and_another_for_another_seed() -> None:
    poses, method = shapes.random_poses(3, 4), RandomUncertainty(7)
    u = method(estimates(poses))
    assert method(estimates(poses[::-1])).tolist() == u[::-1].tolist()
    assert method(estimates(poses[2:3])).tolist() == u[2:3].tolist()
    assert not np.isclose(RandomUncertainty(8)(estimates(poses)), u).any()


def test_chance_does_not_hang_on_the_last_bits_of_a_pose() -> None:
    poses, method = [*shapes.random_poses(3, 4), Pose.identity()], RandomUncertainty(7)
    u = method(estimates(poses)).tolist()
    for bits in (-1e-15, 1e-15):
        beside = [Pose.from_rotvec([bits, bits, 0.0], [bits] * 3) @ pose for pose in poses]
        assert method(estimates(beside)).tolist() == u


@pytest.mark.parametrize("seed", [-1, 2**64])
def test_a_seed_out_of_range_is_refused(seed: int) -> None:
    with pytest.raises(InvalidEstimatesError, match=r"seed must be in \[0, 2\^64\), but is"):
        RandomUncertainty(seed)
