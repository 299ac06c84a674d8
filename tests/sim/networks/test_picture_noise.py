import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from maskval import Pose
from sim.networks.noise_model import load_noise, noise_names
from sim.networks.picture_noise import PictureLatents
from sim.networks.random_streams import Streams
from sim.networks.view_noise import ViewLatents
from tests.round_noise import ROUND

CENTER_O = np.array([0.01, 0.0, 0.03])


def seen_from(angle: float) -> Pose:
    """X_CO of a part at 0.5 m that is seen from `angle` (rad) beside its z axis."""
    turn = Pose.from_rotvec((math.pi, 0, 0)) @ Pose.from_rotvec((0, angle, 0))
    return Pose.from_translation((0, 0, 0.5)) @ turn @ Pose.from_translation(-CENTER_O)


VIEW = seen_from(0.0)
CAMERA = Pose.from_translation((0.7, 0.1, 0.5))


def pictures(share: float, seed: int = 0, experiment: int = 0) -> PictureLatents:
    return PictureLatents(Streams(seed, experiment, "antenna"), replace(ROUND.view, renewed_share=share))


def latents(share: float, seed: int, frame: int, X_CO: Pose = VIEW, count: int = 100) -> np.ndarray:
    return pictures(share, seed).of_part("core", count, 0, X_CO, CENTER_O, frame=frame)


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def test_without_renewal_every_picture_has_the_bits_of_its_view() -> None:
    views, none = ViewLatents(Streams(0, 0, "antenna"), ROUND.view), pictures(0.0)
    for frame in (0, 1, 30):
        np.testing.assert_array_equal(
            none.of_part("mask", 35, 2, VIEW, CENTER_O, frame=frame), views.of_part("mask", 35, 2, VIEW, CENTER_O)
        )
        np.testing.assert_array_equal(
            none.of_camera("false alarm", 7, CAMERA, frame=frame), views.of_camera("false alarm", 7, CAMERA)
        )


def test_the_error_models_that_come_with_the_package_renew_nothing() -> None:
    assert {name: load_noise(name).view.renewed_share for name in noise_names()} == {"antenna": 0.0, "handle": 0.0}


def test_latents_with_a_renewed_share_are_standard_normal_over_seeds() -> None:
    # One number of each of 2,000 streams, hence independent: 1.63 / √2000 is Kolmogorov's bound at 1 %.
    drawn = np.array([latents(0.5, seed, frame=3, count=1)[0] for seed in range(2000)])
    assert kstest(drawn, "norm").statistic < 1.63 / math.sqrt(2000)


@pytest.mark.parametrize(
    ("share", "other", "expected"),
    [
        (0.5, VIEW, 0.5),
        (0.2, VIEW, 0.8),
        (1.0, VIEW, 0.0),
        (0.5, seen_from(math.radians(10)), 0.5 * 0.902),  # the view's own correlation at 10°, times 1 − s
    ],
)
def test_two_pictures_correlate_by_what_is_not_renewed(share, other, expected) -> None:
    # 100 streams of 100: off by 1/√10⁴ = .010, with the random frequencies' share of it by .012, four of which are .05.
    pairs = [(latents(share, seed, 0), latents(share, seed, 1, other)) for seed in range(100)]
    assert correlation(*map(np.array, zip(*pairs, strict=True))) == pytest.approx(expected, abs=0.05)


def test_two_pictures_of_one_camera_place_correlate_by_what_is_not_renewed() -> None:
    pairs = [
        [pictures(0.5, seed).of_camera("false", 100, CAMERA, frame=frame) for frame in (4, 5)] for seed in range(100)
    ]
    assert correlation(*map(np.array, zip(*pairs, strict=True))) == pytest.approx(0.5, abs=0.05)


def test_a_pictures_latents_do_not_depend_on_what_was_asked_before() -> None:
    alone = latents(0.5, 3, frame=2)
    busy = pictures(0.5, 3)
    for part, frame in ((0, 1), (0, 2), (1, 2)):
        busy.of_part("core", 100, part, VIEW, CENTER_O, frame=frame)
    np.testing.assert_array_equal(busy.of_part("core", 100, 0, VIEW, CENTER_O, frame=2), alone)


@pytest.mark.parametrize(
    "other",
    [
        pictures(1.0, seed=1).of_part("core", 4000, 0, VIEW, CENTER_O, frame=2),
        pictures(1.0, experiment=1).of_part("core", 4000, 0, VIEW, CENTER_O, frame=2),
        pictures(1.0).of_part("core", 4000, 1, VIEW, CENTER_O, frame=2),
        pictures(1.0).of_part("mask", 4000, 0, VIEW, CENTER_O, frame=2),
        pictures(1.0).of_camera("core", 4000, CAMERA, frame=2),
    ],
    ids=["seed", "experiment", "part", "purpose", "camera"],
)
def test_what_is_new_in_a_picture_is_independent_of_other_streams(other) -> None:
    assert abs(correlation(latents(1.0, 0, frame=2, count=4000), other)) < 4 / math.sqrt(4000)
