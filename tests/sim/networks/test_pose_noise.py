import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from maskval import Camera, Mesh, Pose
from sim.networks.pose_noise import (
    PoseLatents,
    core_scale,
    displace,
    is_outlier,
    noisy_pose,
    outlier_probability,
    pose_error,
    pose_of_nothing,
    ray_frame,
)
from tests.round_noise import ROUND

NOISE = ROUND.pose
NO_OUTLIERS = replace(NOISE, outlier_probability=0.0)
ONLY_OUTLIERS = replace(
    NOISE, outlier_probability=0.999, second_outlier_odds_ratio=1000.0, lateral_mm=0.0, rotation_deg=0.0
)
CENTER_O = np.array([0.01, -0.02, 0.03])
R0 = Pose.from_rotvec((0.4, 1.3, -0.8))
AT_800_MM = Pose.from_translation(0.8 * np.array([0.36, 0.48, 0.8])) @ R0 @ Pose.from_translation(-CENTER_O)
AT_400_MM = Pose.from_translation(0.4 * np.array([0.36, 0.48, 0.8])) @ R0 @ Pose.from_translation(-CENTER_O)


def latents(vector: np.ndarray | None = None, difficulty: float = 0.0) -> PoseLatents:
    """Numbers of a view; without a vector all are 0, which makes no error and no outlier."""
    return PoseLatents.from_vector(difficulty, np.zeros(PoseLatents.COUNT) if vector is None else vector)


def many(count: int, seed: int = 0) -> list[PoseLatents]:
    """Independent views of difficulty 0."""
    return [latents(vector) for vector in np.random.default_rng(seed).normal(size=(count, PoseLatents.COUNT))]


def core_of_one(axis: int) -> PoseLatents:
    vector = np.zeros(PoseLatents.COUNT)
    vector[2 + axis] = 1.0
    return latents(vector)


def four_sigma(p: float, count: int) -> float:
    return 4 * math.sqrt(p * (1 - p) / count)


def test_latents_of_zero_leave_the_pose_as_it_is() -> None:
    for network in (0, 1):
        X_CO = noisy_pose(AT_800_MM, CENTER_O, 1.0, latents(), NOISE, network=network)
        np.testing.assert_allclose(X_CO.matrix, AT_800_MM.matrix, atol=1e-15)


def test_the_core_is_its_parameters_at_the_reference_distance() -> None:
    rotation = math.radians(2.05)
    expected = np.diag([0.5e-3, 0.5e-3, 2.5 * 0.5e-3, rotation, rotation, 0.5 * rotation])
    for axis in range(6):
        error, flipped = pose_error(AT_800_MM, CENTER_O, 1.0, core_of_one(axis), NOISE, network=0)
        np.testing.assert_allclose(error, expected[axis], atol=1e-15)
        assert not flipped


def test_half_the_distance_has_half_the_core() -> None:
    view = latents(np.full(PoseLatents.COUNT, 0.7))
    far, _ = pose_error(AT_800_MM, CENTER_O, 1.0, view, NO_OUTLIERS, network=0)
    near, _ = pose_error(AT_400_MM, CENTER_O, 1.0, view, NO_OUTLIERS, network=0)
    np.testing.assert_allclose(near, far / 2, rtol=1e-12)


def test_difficulty_and_hiding_scale_the_core() -> None:
    assert core_scale(1.0, latents(), NOISE, network=0) == 1.0
    assert core_scale(1.0, latents(difficulty=1.5), NOISE, network=0) == pytest.approx(math.exp(0.46 * 1.5))
    assert core_scale(0.75, latents(), NOISE, network=0) == pytest.approx(math.exp(1.86 * 0.25))
    assert core_scale(1.0, latents(difficulty=1.5), NOISE, network=1) == pytest.approx(
        1.57 * math.exp(0.46 * 0.6 * 1.5)
    )


def test_a_shift_along_the_ray_leaves_the_middle_on_its_pixel() -> None:
    X_CO = noisy_pose(AT_800_MM, CENTER_O, 1.0, core_of_one(2), NOISE, network=0)
    p_C = X_CO.apply(CENTER_O)
    np.testing.assert_allclose(p_C, (0.8 + 2.5 * 0.5e-3) * np.array([0.36, 0.48, 0.8]), atol=1e-15)
    np.testing.assert_allclose(X_CO.rotation, AT_800_MM.rotation, atol=1e-15)


def test_a_turn_leaves_the_middle_where_it_is() -> None:
    X_CO = displace(AT_800_MM, CENTER_O, np.array([0, 0, 0, 0.1, -0.2, 0.3]))
    np.testing.assert_allclose(X_CO.apply(CENTER_O), AT_800_MM.apply(CENTER_O), atol=1e-15)


@given(st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.1, 3)))
def test_the_ray_frame_is_a_rotation_whose_z_axis_is_the_ray(p_C) -> None:
    R_CR = ray_frame(np.array(p_C))
    np.testing.assert_allclose(R_CR @ R_CR.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(R_CR) == pytest.approx(1.0)
    np.testing.assert_allclose(R_CR[:, 2], np.array(p_C) / np.linalg.norm(p_C), atol=1e-14)
    assert R_CR[1, 0] == 0.0  # x lies in the camera's x-z plane


def test_errors_along_the_ray_are_larger_than_across_by_the_depth_ratio() -> None:
    # 4,000 views: each standard deviation is off by 1/√8000 = 1.1 %, the ratio by 1.6 %, four of which are 6.4 %.
    errors = np.array([pose_error(AT_800_MM, CENTER_O, 1.0, view, NO_OUTLIERS, network=0)[0] for view in many(4000)])
    across, along = errors[:, 0].std(), errors[:, 2].std()
    assert along / across == pytest.approx(2.5, rel=0.064)


def test_the_cores_of_both_networks_correlate() -> None:
    # 4,000 views of 6 numbers: 1/√24000 = .0065, four of which are .026.
    S1, S2 = (
        np.array([pose_error(AT_800_MM, CENTER_O, 1.0, view, NO_OUTLIERS, network=network)[0] for view in many(4000)])
        for network in (0, 1)
    )
    scaled = [(errors / errors.std(axis=0)).ravel() for errors in (S1, S2)]
    assert np.corrcoef(*scaled)[0, 1] == pytest.approx(0.33, abs=0.026)
    # r_B = 1.57 times exp(λ √(1 − ρ_D²) e_B), of root mean square exp((.46 · .8)²). Its squares spread by
    # √(3 exp(4 (.46 · .8)²) − 1) = 2.0, so S2's spread is off by 1.6 %, the ratio by 2 %, four of which are 8 %.
    expected = 1.57 * math.exp((0.46 * 0.8) ** 2)
    assert S2[:, 0].std() / S1[:, 0].std() == pytest.approx(expected, rel=0.08)


@pytest.mark.parametrize(
    ("network", "visibility", "difficulty", "odds"),
    [
        (0, 1.0, 0.0, 0.018 / 0.982),
        (0, 0.5, 0.0, 0.018 / 0.982 * math.exp(4.1 * 0.5)),
        (0, 1.0, 2.0, 0.018 / 0.982 * math.exp(0.9 * 2.0)),
        (1, 1.0, 0.0, 0.018 / 0.982 * 2.8),
        (1, 0.5, 0.0, 0.018 / 0.982 * 2.8 * math.exp(4.1 * 0.5)),
    ],
)
def test_outliers_happen_at_their_odds(network, visibility, difficulty, odds) -> None:
    count, p = 20000, odds / (1 + odds)
    vectors = np.random.default_rng(1).normal(size=(count, PoseLatents.COUNT))
    vectors[:, 0] = 0.0  # S2's own difficulty
    views = [latents(vector, difficulty) for vector in vectors]
    assert outlier_probability(visibility, views[0], NOISE, network=network) == pytest.approx(p)
    happened = sum(is_outlier(visibility, view, NOISE, network=network) for view in views)
    assert happened / count == pytest.approx(p, abs=four_sigma(p, count))


def test_the_networks_share_outliers_as_far_as_they_correlate() -> None:
    noise = replace(NOISE, outlier_probability=0.25, second_outlier_odds_ratio=1.0, outlier_difficulty_gain=0.0)

    def both(correlation: float) -> float:
        used = replace(noise, second_outlier_correlation=correlation)
        views = many(4000)
        return sum(all(is_outlier(1.0, view, used, network=n) for n in (0, 1)) for view in views) / len(views)

    assert both(0.0) == pytest.approx(0.25**2, abs=four_sigma(0.25**2, 4000))
    assert both(1.0) == pytest.approx(0.25, abs=four_sigma(0.25, 4000))
    assert both(0.0) < both(0.45) < both(1.0)


def test_half_of_the_common_outliers_have_the_same_content() -> None:
    count = 4000
    same = 0
    for view in many(count):
        S1, S2 = (pose_error(AT_800_MM, CENTER_O, 1.0, view, ONLY_OUTLIERS, network=network) for network in (0, 1))
        same += S1[1] == S2[1] and np.array_equal(S1[0], S2[0])
    # Two flips are the same too: .5 + .5 · .08². One in 1,000 estimates is none, which 4 sigma of 4,000 cover.
    p = 0.5 + 0.5 * 0.08**2
    assert same / count == pytest.approx(p, abs=four_sigma(p, count) + 0.002)


def test_a_flip_is_half_a_turn_about_the_axis_through_the_middle() -> None:
    vector = np.zeros(PoseLatents.COUNT)
    vector[14], vector[16] = -5.0, -5.0  # surely an outlier, surely a flip
    X_CO = noisy_pose(AT_800_MM, CENTER_O, 1.0, latents(vector), NOISE, network=0)
    X_OO = AT_800_MM.inverse() @ X_CO
    np.testing.assert_allclose(X_OO.rotation, np.diag([-1.0, -1.0, 1.0]), atol=1e-14)
    np.testing.assert_allclose(X_OO.apply(CENTER_O), CENTER_O, atol=1e-14)


def test_outliers_are_flips_in_their_share_and_gross_errors_in_the_rest() -> None:
    count = 4000
    outcomes = [pose_error(AT_800_MM, CENTER_O, 1.0, view, ONLY_OUTLIERS, network=0) for view in many(count)]
    flips = sum(flipped for _, flipped in outcomes)
    assert flips / count == pytest.approx(0.08, abs=four_sigma(0.08, count))
    gross = np.array([error for error, flipped in outcomes if not flipped])
    # A standard deviation of 3,680 is off by 1/√7360 = 1.2 %, four of which are 4.7 %.
    sd = [0.012, 0.012, 0.05, *[math.radians(35)] * 3]
    np.testing.assert_allclose(gross.std(axis=0), sd, rtol=0.047)


def test_no_error_puts_the_part_behind_the_camera() -> None:
    vector = np.zeros(PoseLatents.COUNT)
    vector[14], vector[16], vector[20] = -5.0, 5.0, -40.0  # a gross error of −40 · 50 mm along the ray
    X_CO = noisy_pose(AT_800_MM, CENTER_O, 1.0, latents(vector), NOISE, network=0)
    np.testing.assert_allclose(X_CO.apply(CENTER_O), 0.1 * AT_800_MM.apply(CENTER_O), atol=1e-14)


def test_a_mask_without_a_part_gets_a_pose_of_its_place_and_size() -> None:
    camera = Camera(600, 600, 320, 240, 640, 480)
    box = Mesh([[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0]], [[0, 1, 2]])
    mask = np.zeros((480, 640), dtype=bool)
    mask[200:280, 410:470] = True  # 60 × 80 px, its middle 120 px to the right
    X_CO = pose_of_nothing(mask, camera, box, np.array([0.0, 2.0, 0.0, 0.0]))
    z = 600 * 0.5 / 100  # a diagonal of 0.5 m over one of 100 px
    np.testing.assert_allclose(X_CO.apply([0.15, 0.2, 0]), (120 / 600 * z, 0, z), atol=1e-12)
    np.testing.assert_allclose(X_CO.rotation, np.diag([1.0, -1.0, -1.0]), atol=1e-12)


@pytest.mark.parametrize("vector", [np.zeros(29), np.full(PoseLatents.COUNT, np.nan)])
def test_unfit_latents_are_refused(vector) -> None:
    with pytest.raises(ValueError, match="expected 30 finite latents"):
        PoseLatents.from_vector(0.0, vector)


def test_latents_cannot_be_written() -> None:
    vector = np.zeros(PoseLatents.COUNT)
    view = latents(vector)
    vector[:] = 1.0
    assert not view.core.any()
    with pytest.raises(ValueError, match="read-only"):
        view.core[0, 0] = 1.0
