import math

import numpy as np
import pytest
from scipy.stats import kstest

from maskval import Pose
from sim.networks.random_streams import Streams
from sim.networks.view_noise import ViewLatents
from tests.round_noise import ROUND

NOISE = ROUND.view
CENTER_O = np.array([0.01, 0.0, 0.03])


def seen_from(angle: float, distance: float = 0.5, roll: float = 0.0) -> Pose:
    """X_CO of a part that is seen from `angle` (rad) beside its z axis, its middle on the optical axis."""
    turn = Pose.from_rotvec((0, 0, roll)) @ Pose.from_rotvec((math.pi, 0, 0)) @ Pose.from_rotvec((0, angle, 0))
    return Pose.from_translation((0, 0, distance)) @ turn @ Pose.from_translation(-CENTER_O)


def latents(seed: int, X_CO: Pose, count: int = 100, part: int = 0, purpose: str = "core") -> np.ndarray:
    return ViewLatents(Streams(seed, 0, "antenna"), NOISE).of_part(purpose, count, part, X_CO, CENTER_O)


def correlation(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.corrcoef(a.ravel(), b.ravel())[0, 1])


def test_the_same_view_has_the_same_latents_whatever_was_asked_before() -> None:
    alone = latents(3, seen_from(0.2), part=4)
    busy = ViewLatents(Streams(3, 0, "antenna"), NOISE)
    for part in (7, 4, 0):
        busy.of_part("core", 100, part, seen_from(0.7), CENTER_O)
        busy.of_part("mask", 12, part, seen_from(0.2), CENTER_O)
    again = busy.of_part("core", 100, 4, seen_from(0.2), CENTER_O)
    np.testing.assert_array_equal(again, alone)


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        # exp(−(2 sin(θ/2) / ℓ)² / 2) with ℓ = 22°, and exp(−(log 2 / 0.4)² / 2)
        (seen_from(math.radians(10)), 0.902),
        (seen_from(math.radians(30)), 0.403),
        (seen_from(math.radians(90)), 0.001),
        (seen_from(0.0, distance=0.25), 0.223),
    ],
)
def test_two_views_correlate_by_their_angle_and_distance(other, expected) -> None:
    # 100 streams of 100: the sample correlation is off by 1/√10⁴ = .010, the random frequencies' by 1/√(100 · 2 · 96) =
    # .007; together .012, four of which are .05.
    pairs = [(latents(seed, seen_from(0.0)), latents(seed, other)) for seed in range(100)]
    assert correlation(*map(np.array, zip(*pairs, strict=True))) == pytest.approx(expected, abs=0.05)


def test_a_roll_of_the_camera_is_the_same_view() -> None:
    np.testing.assert_allclose(latents(0, seen_from(0.3, roll=1.2)), latents(0, seen_from(0.3)), atol=1e-12)


def test_latents_are_standard_normal_over_seeds() -> None:
    # One number of each of 2,000 streams, hence independent: 1.63 / √2000 is Kolmogorov's bound at 1 %.
    drawn = np.array([latents(seed, seen_from(0.4), count=1)[0] for seed in range(2000)])
    assert kstest(drawn, "norm").statistic < 1.63 / math.sqrt(2000)


def test_views_all_round_one_part_average_out() -> None:
    # Within one stream: 500 directions all over the sphere hold some 4π / (2π ℓ²) ≈ 14 independent ones, and 400
    # processes some 5,400: the mean square is off by √(2 / 5400) = .019, four of which are .08.
    rng = np.random.default_rng(0)
    field = ViewLatents(Streams(1, 0, "antenna"), NOISE)
    views = [Pose.from_quaternion_wxyz(q / np.linalg.norm(q), (0, 0, 0.5)) for q in rng.normal(size=(500, 4))]
    drawn = np.array([field.of_part("core", 400, 0, X_CO, np.zeros(3)) for X_CO in views])
    assert np.mean(drawn**2) == pytest.approx(1.0, abs=0.08)


@pytest.mark.parametrize(
    "other",
    [
        latents(1, seen_from(0.0), 4000),
        latents(0, seen_from(0.0), 4000, part=1),
        latents(0, seen_from(0.0), 4000, purpose="mask"),
        ViewLatents(Streams(0, 1, "antenna"), NOISE).of_part("core", 4000, 0, seen_from(0.0), CENTER_O),
        ViewLatents(Streams(0, 0, "handle"), NOISE).of_part("core", 4000, 0, seen_from(0.0), CENTER_O),
        ViewLatents(Streams(2**40, 0, "antenna"), NOISE).of_part("core", 4000, 0, seen_from(0.0), CENTER_O),
        ViewLatents(Streams(0, 0, "antenna"), NOISE).of_camera("core", 4000, seen_from(0.0)),
    ],
    ids=["seed", "part", "purpose", "experiment", "kind", "long seed", "camera"],
)
def test_another_stream_is_independent(other) -> None:
    assert abs(correlation(latents(0, seen_from(0.0), 4000), other)) < 4 / math.sqrt(4000)


def test_latents_of_a_camera_change_with_its_place() -> None:
    # 50 mm aside at a correlation length of 100 mm: exp(−.5² / 2) = .882; tolerance as above.
    def of_camera(seed: int, x: float) -> np.ndarray:
        return ViewLatents(Streams(seed, 0, "antenna"), NOISE).of_camera("false", 100, Pose.from_translation((x, 0, 1)))

    pairs = [(of_camera(seed, 0.0), of_camera(seed, 0.05)) for seed in range(100)]
    assert correlation(*map(np.array, zip(*pairs, strict=True))) == pytest.approx(math.exp(-0.125), abs=0.05)
