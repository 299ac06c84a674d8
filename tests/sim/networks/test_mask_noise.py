import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import ndtri

from maskval import Camera, Mesh, Pose, mask_iou, silhouette
from sim.networks.mask_noise import (
    CELLS,
    FALSE_ALARM_COUNT,
    MODES,
    MaskLatents,
    cell_distance,
    difficulty_scale,
    false_alarm,
    miss_probability,
    noisy_detection,
    paste,
    random_field,
)
from sim.networks.noise_model import MaskNoise
from tests.round_noise import ROUND

NOISE = ROUND.mask
EXACT = replace(
    NOISE, field_cells=0.0, box_share=0.0, leak_cells=0.0, drop_probability=0.0, miss_probability=0.0, score_sd=0.0
)
NOBODY = np.zeros((480, 640), dtype=bool)
SIDE = 196  # px: a cell of the grid is 7 px
SQUARE = NOBODY.copy()
SQUARE[100 : 100 + SIDE, 200 : 200 + SIDE] = True
OWN, MISS, DROP, SCORE, BOX, FIELD = 0, 1, 3, 2, 6, 10  # where the parts of the latents' vector begin


def latents(difficulty: float = 0.0, **numbers: float) -> MaskLatents:
    """Numbers of a view, 0 where not given: by their places in the vector, `at_6=1.0`."""
    vector = np.zeros(MaskLatents.COUNT)
    for place, number in numbers.items():
        vector[int(place.removeprefix("at_"))] = number
    return MaskLatents.from_vector(difficulty, vector)


def many(count: int) -> list[MaskLatents]:
    vectors = np.random.default_rng(0).normal(size=(count, MaskLatents.COUNT))
    return [MaskLatents.from_vector(0.0, vector) for vector in vectors]


def noisy(mask: np.ndarray, view: MaskLatents, noise: MaskNoise, neighbors: np.ndarray = NOBODY) -> np.ndarray:
    detection = noisy_detection(mask, neighbors, 1.0, view, noise)
    assert detection is not None
    return detection.mask


def four_sigma(p: float, count: int) -> float:
    return 4 * math.sqrt(p * (1 - p) / count)


def turned_boxes(count: int) -> list[np.ndarray]:
    """Silhouettes of a 120 × 80 × 60 mm box from anywhere, about 200 px wide."""
    corners = np.array([(x, y, z) for x in (-0.06, 0.06) for y in (-0.04, 0.04) for z in (-0.03, 0.03)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    box = Mesh(corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]))
    camera = Camera(600, 600, 320, 240, 640, 480)
    turns = np.random.default_rng(5).normal(size=(count, 4))
    poses = [Pose.from_quaternion_wxyz(q / np.linalg.norm(q), (0, 0, 0.4)) for q in turns]
    return [silhouette(box, X_CO, camera, pixel_center=0.5).mask for X_CO in poses]


def test_without_noise_only_the_detectors_resolution_is_lost() -> None:
    # Distances are measured in quarters of a cell. An outline that is off by half of one, an eighth of a cell, all
    # along the box's 4 · 28 cells takes 14 of the 28² / 2 cells that the slimmest of these silhouettes fills: IoU .96.
    ious = [mask_iou(noisy(mask, latents(), EXACT), mask) for mask in turned_boxes(40)]
    assert min(ious) > 0.96
    assert np.mean(ious) > 0.98
    assert mask_iou(noisy(SQUARE, latents(), EXACT), SQUARE) == 1.0


def test_distances_are_in_cells_and_positive_inside() -> None:
    distance = cell_distance(SQUARE, (200.0, 100.0, 200.0 + SIDE, 100.0 + SIDE))
    row = distance[CELLS // 2]
    np.testing.assert_allclose(row[:5], [0.5, 1.5, 2.5, 3.5, 4.5], atol=0.05)
    beside = cell_distance(SQUARE, (200.0 - SIDE, 100.0, 200.0, 100.0 + SIDE))
    np.testing.assert_allclose(beside[CELLS // 2][-3:], [-2.5, -1.5, -0.5], atol=0.06)


def test_a_negative_bias_shrinks_the_mask_by_its_cells_on_every_side() -> None:
    shrunk = noisy(SQUARE, latents(), replace(EXACT, bias_cells=-2.0))
    side = SIDE - 2 * 2.0 * 7
    assert math.sqrt(shrunk.sum()) == pytest.approx(side, abs=1.5)  # px; corners are round below a cell


def test_a_positive_bias_grows_the_mask_into_its_holes_but_not_out_of_the_box() -> None:
    ring = SQUARE.copy()
    ring[150:250, 250:350] = False  # a hole of 100 px
    grown = noisy(ring, latents(), replace(EXACT, bias_cells=1.0))
    hole = SQUARE & ~grown
    assert math.sqrt(hole.sum()) == pytest.approx(100 - 2 * 7, abs=1.5)
    assert not (grown & ~SQUARE).any()


def test_the_field_has_variance_one_over_the_grid() -> None:
    squares = [np.mean(random_field(coefficients) ** 2) for coefficients in np.eye(MODES**2)]
    assert sum(squares) == pytest.approx(1.0, abs=1e-5)
    assert np.allclose(squares, 1 / MODES**2, atol=1e-6)


def test_the_field_moves_the_outline_by_its_cells() -> None:
    # The constant mode, 1/MODES everywhere, at 10 standard deviations of .5 cells: one cell, and inwards everywhere.
    moved = noisy(SQUARE, latents(at_10=-10.0), replace(EXACT, field_cells=0.5))
    assert math.sqrt(moved.sum()) == pytest.approx(SIDE - 2 * 7 * 10 * 0.5 / MODES, abs=1.5)


def test_a_box_that_is_too_small_cuts_the_mask() -> None:
    # The right side at −1 standard deviation of 10 % of 196 px, the top at +2 of them.
    cut = noisy(SQUARE, latents(at_8=-1.0, at_7=2.0), replace(EXACT, box_share=0.1))
    rows, columns = np.flatnonzero(cut.any(axis=1)), np.flatnonzero(cut.any(axis=0))
    assert (columns[0], columns[-1] + 1) == (200, round(200 + SIDE - 19.6))
    assert (rows[0], rows[-1] + 1) == (round(100 + 39.2), 100 + SIDE)


def test_a_box_that_is_too_large_changes_little() -> None:
    same = noisy(SQUARE, latents(at_8=1.0, at_6=-1.0), replace(EXACT, box_share=0.1))
    assert mask_iou(same, SQUARE) > 1 - 4 * 0.125 / CELLS  # an eighth of a cell on every side


def test_leakage_moves_the_outline_into_neighbours_only() -> None:
    ell = SQUARE.copy()
    ell[198:, 298:] = False
    notch = SQUARE & ~ell  # 98 × 98 px
    noise = replace(EXACT, leak_cells=1.0)
    alone, beside = noisy(ell, latents(), noise), noisy(ell, latents(), noise, neighbors=notch)
    assert (alone & notch).sum() < 0.02 * notch.sum()
    assert 98 - math.sqrt(98**2 - (beside & notch).sum()) == pytest.approx(7.0, abs=1.5)
    assert not (beside & ~SQUARE).any()


def test_a_dropped_piece_has_the_share_that_it_was_drawn() -> None:
    noise = replace(EXACT, drop_probability=1.0)
    for share_latent, share in ((-8.0, 0.15), (0.0, 0.30), (8.0, 0.45)):
        kept = noisy(SQUARE, latents(at_4=0.7, at_5=share_latent), noise)
        assert kept.sum() / SQUARE.sum() == pytest.approx(1 - share, abs=1 / CELLS)  # a cell all along the cut
        assert not (kept & ~SQUARE).any()


def test_pieces_drop_at_their_rate() -> None:
    noise = replace(EXACT, drop_probability=0.1)
    dropped = sum(noisy(SQUARE, view, noise).sum() < 0.9 * SQUARE.sum() for view in many(600))
    assert dropped / 600 == pytest.approx(0.1, abs=four_sigma(0.1, 600))


def test_misses_rise_to_certainty_as_the_part_disappears() -> None:
    assert miss_probability(1.0, NOISE) == pytest.approx(0.0024)
    assert miss_probability(0.1, NOISE) == pytest.approx(0.0024)
    assert miss_probability(0.05, NOISE) == pytest.approx(1 - 0.9976 * 0.5)
    assert miss_probability(0.0, NOISE) == 1.0
    assert miss_probability(0.0, replace(NOISE, miss_visibility=0.0)) == pytest.approx(0.0024)


@pytest.mark.parametrize(("visibility", "p"), [(1.0, 0.2), (0.05, 1 - 0.8 * 0.5)])
def test_instances_are_missed_at_their_rate(visibility, p) -> None:
    noise = replace(NOISE, miss_probability=0.2)
    missed = sum(noisy_detection(SQUARE, NOBODY, visibility, view, noise) is None for view in many(600))
    assert missed / 600 == pytest.approx(p, abs=four_sigma(p, 600))


def test_an_empty_mask_is_a_missed_instance() -> None:
    assert noisy_detection(NOBODY, NOBODY, 1.0, latents(), EXACT) is None
    assert noisy_detection(SQUARE, NOBODY, 1.0, latents(), replace(EXACT, bias_cells=-14.0)) is None


def test_a_single_pixel_is_found_or_missed_but_no_error() -> None:
    for v, u in ((0, 0), (479, 639), (200, 300)):
        pixel = NOBODY.copy()
        pixel[v, u] = True
        found = [noisy_detection(pixel, NOBODY, 1.0, view, replace(NOISE, miss_probability=0.0)) for view in many(20)]
        assert sum(detection is not None for detection in found) > 10


def test_the_images_border_is_no_outline() -> None:
    touching = NOBODY.copy()
    touching[:140, :196] = True
    shrunk = noisy(touching, latents(), replace(EXACT, bias_cells=-1.0))
    assert shrunk[:120, :175].all()  # only the sides inside the image moved, by 5 px and 7 px
    assert not shrunk[137:].any()


def test_the_score_is_the_iou_with_noise() -> None:
    cut = replace(EXACT, drop_probability=1.0, score_sd=0.12)
    for number in (-1.0, 0.0, 1.0, 9.0):
        detection = noisy_detection(SQUARE, NOBODY, 1.0, latents(at_2=number), cut)
        assert detection is not None
        expected = min(1.0, mask_iou(detection.mask, SQUARE) + 0.12 * number)
        assert detection.score == pytest.approx(expected)


def test_difficulty_scales_the_displacements() -> None:
    assert difficulty_scale(latents(), NOISE) == 1.0
    assert difficulty_scale(latents(difficulty=2.0), NOISE) == pytest.approx(math.exp(0.35 * 0.7 * 2))
    assert difficulty_scale(latents(at_0=2.0), NOISE) == pytest.approx(math.exp(0.35 * math.sqrt(1 - 0.49) * 2))
    noise = replace(EXACT, field_cells=0.15)
    easy, hard = (
        np.mean([mask_iou(noisy(SQUARE, replace(view, difficulty=D), noise), SQUARE) for view in many(50)])
        for D in (-2.0, 2.0)
    )
    assert hard < easy


def test_false_alarms_happen_at_their_rate_anywhere_in_the_image() -> None:
    noise = replace(NOISE, false_alarms_per_image=0.2)
    drawn = [
        false_alarm((480, 640), numbers, noise)
        for numbers in np.random.default_rng(0).normal(size=(1000, FALSE_ALARM_COUNT))
    ]
    blobs = [detection for detection in drawn if detection is not None]
    assert len(blobs) / 1000 == pytest.approx(0.2, abs=four_sigma(0.2, 1000))
    middles = np.array([np.argwhere(blob.mask).mean(axis=0) / (480, 640) for blob in blobs])
    # Uniform in the image: a mean of 200 is off by √(1/12/200) = .020, four of which are .08.
    np.testing.assert_allclose(middles.mean(axis=0), 0.5, atol=0.08)
    assert all(0.0 <= blob.score <= 1.0 for blob in blobs)


def test_a_false_alarm_in_the_middle_is_a_disc_of_its_radius() -> None:
    numbers = np.zeros(FALSE_ALARM_COUNT)
    numbers[0] = ndtri(0.005)
    blob = false_alarm((480, 640), numbers, NOISE)
    assert blob is not None
    assert blob.mask.sum() == pytest.approx(math.pi * 30**2, rel=0.05)
    assert blob.score == pytest.approx(0.7)


def test_what_a_grid_means_is_cut_at_box_and_image() -> None:
    everything = np.ones((CELLS, CELLS), dtype=np.float32)
    assert paste(everything, (-10.0, -10.0, 20.0, 30.0), (480, 640)).sum() == 20 * 30
    assert paste(everything, (10.4, 10.6, 20.4, 20.6), (480, 640)).nonzero()[1].min() == 10  # its middle, 10.5, is in
    assert not paste(everything, (700.0, 0.0, 800.0, 50.0), (480, 640)).any()


@pytest.mark.parametrize("vector", [np.zeros(3), np.full(MaskLatents.COUNT, np.inf)])
def test_unfit_latents_are_refused(vector) -> None:
    with pytest.raises(ValueError, match="expected 35 finite latents"):
        MaskLatents.from_vector(0.0, vector)


def test_a_detections_mask_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        noisy(SQUARE, latents(), NOISE)[0, 0] = True
