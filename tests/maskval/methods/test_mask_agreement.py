import numpy as np
import pytest

from maskval import (
    UNMATCHED,
    Ensemble,
    Estimates,
    InvalidEstimatesError,
    InvalidMaskError,
    MaskVal,
    Needs,
    NoUncertainty,
    Pose,
    associate,
    maskval_uncertainty,
    needs_of,
    silhouette,
    uncertainty,
)
from tests.maskval import shapes
from tests.maskval.shapes import VGA

AHEAD = Pose.from_translation((0, 0, 0.6))
# Centred on the left border: 50 of the square's 100 columns are in the image.
AT_BORDER = Pose.from_translation((-0.32, 0, 0.6))


def estimates(*poses: tuple[Pose, ...], masks: np.ndarray | None = None, pixel_center: float = 0.0) -> Estimates:
    if masks is None:
        masks = np.array([silhouette(shapes.square(), X, VGA).mask for X in poses[0]], dtype=bool).reshape(-1, 480, 640)
    return Estimates(VGA, shapes.square(), masks, poses, np.ones(len(masks)), pixel_center)


@pytest.mark.parametrize(
    ("c", "v", "u"),
    [
        (0.9, 1.0, 1 - 0.9),
        (0.9, 0.8, 1 - 0.9),
        (0.9, 0.79, 1 - 0.9 * 0.79),
        (0.9, 0.0, 1.0),
        (0.0, 1.0, 1.0),
        (1, 1, 0),
    ],
)
def test_visibility_lowers_the_certainty_below_alpha_only(c, v, u) -> None:
    assert maskval_uncertainty(c, v, alpha=0.8) == pytest.approx(u, abs=1e-15)


def test_alpha_0_never_and_alpha_1_almost_always_looks_at_the_visibility() -> None:
    c, v = np.array([0.5, 0.5, 0.5]), np.array([0.0, 0.99, 1.0])
    np.testing.assert_allclose(maskval_uncertainty(c, v, alpha=0), [0.5, 0.5, 0.5], rtol=0, atol=1e-15)
    np.testing.assert_allclose(maskval_uncertainty(c, v, alpha=1), [1, 1 - 0.5 * 0.99, 0.5], rtol=0, atol=1e-15)


def test_maskval_compares_each_pose_with_its_own_mask() -> None:
    # Masks 20 px right of the silhouettes: IoU 80 / 120 ahead; 50 and 70 columns of the image at the border.
    masks = np.zeros((2, 480, 640), dtype=bool)
    masks[0, 190:290, 290:390] = True
    masks[1, 190:290, 0:70] = True
    u = MaskVal()(estimates((AHEAD, AT_BORDER), masks=masks))
    np.testing.assert_allclose(u, [1 - 80 / 120, 1 - (50 / 70) * (50 / 100)], rtol=0, atol=1e-15)
    u = MaskVal(alpha=0.5)(estimates((AHEAD, AT_BORDER), masks=masks))
    np.testing.assert_allclose(u, [1 - 80 / 120, 1 - 50 / 70], rtol=0, atol=1e-15)


def test_maskval_is_certain_of_a_pose_whose_mask_is_its_silhouette() -> None:
    assert MaskVal()(estimates((AHEAD,))).tolist() == [0.0]
    assert MaskVal()(estimates((AT_BORDER,))).tolist() == [1 - 50 / 100]


def test_maskval_samples_pixels_where_the_masks_do() -> None:
    mask = silhouette(shapes.square(), Pose.from_translation((0.0004, 0, 0.6)), VGA, pixel_center=0.5).mask[None]
    pose = (Pose.from_translation((0.0004, 0, 0.6)),)
    assert MaskVal()(estimates(pose, masks=mask, pixel_center=0.5)).tolist() == [0.0]
    # At u = i the same pose covers the columns 271..370, one to the right of the columns 270..369 at u = i + 0.5.
    assert MaskVal()(estimates(pose, masks=mask)).tolist() == [1 - 99 / 101]


@pytest.mark.parametrize(("shift_m", "u"), [(0.005, 0.0), (0.01, 0.0), (0.02, 0.25), (0.05, 1.0), (0.3, 1.0)])
def test_ensemble_add_scales_the_disagreement_and_clips_it(shift_m, u) -> None:
    other = Pose.from_translation((0, shift_m, 0)) @ AHEAD
    found = Ensemble(minimum=0.01)(estimates((AHEAD, AHEAD), (other, AHEAD)))
    np.testing.assert_allclose(found, [u, 0.0], rtol=0, atol=1e-12)


def test_ensembles_scale_their_own_disagreement() -> None:
    # The sheet's corners are 0.05 √2 m from its centre, where a turn by θ moves them by 2 r sin(θ / 2).
    turned = AHEAD @ Pose.from_rotvec((0, 0, 0.3))
    moved = Pose.from_translation((0.03, 0, 0.04)) @ AHEAD
    made = estimates((AHEAD, AHEAD), (turned, moved))
    radius = 0.05 * np.sqrt(2)
    for method, expected in (
        (Ensemble("add", 0.0, 0.1), [2 * radius * np.sin(0.15) / 0.1, 0.05 / 0.1]),
        (Ensemble("mdd", 0.0, 0.1), [2 * radius * np.sin(0.15) / 0.1, 0.05 / 0.1]),
        (Ensemble("translation", 0.0, 0.1), [0, 0.05 / 0.1]),
        (Ensemble("rotation", 0.1, 0.5), [(0.3 - 0.1) / (0.5 - 0.1), 0]),
    ):
        np.testing.assert_allclose(method(made), expected, rtol=0, atol=1e-12)


IOU = np.array([[0.7, 0.8, 0.0], [0.0, 0.7, 0.0], [0.1, 0.75, 0.0]])


def test_greedy_takes_the_best_pair_left_and_optimal_the_best_sum() -> None:
    # Greedy: 0-1, then 2-0; optimal: 0-0 and 2-1 with 1.45. Neither matches what does not overlap.
    assert associate(IOU, "greedy").tolist() == [1, UNMATCHED, 0]
    assert associate(IOU, "optimal").tolist() == [0, UNMATCHED, 1]


@pytest.mark.parametrize("rule", ["greedy", "optimal"])
@pytest.mark.parametrize("shape", [(0, 0), (0, 2), (2, 0), (2, 3), (3, 2)])
def test_association_gives_each_pose_a_mask_while_there_are_any(rule, shape) -> None:
    iou = np.random.default_rng(0).uniform(0.1, 1, size=shape)
    matched = associate(iou, rule)
    assert matched.shape == (shape[0],)
    found = matched[matched != UNMATCHED]
    assert len(set(found.tolist())) == len(found) == min(shape)


def test_greedy_prefers_the_first_of_equals() -> None:
    assert associate(np.full((2, 2), 0.5), "greedy").tolist() == [0, 1]


@pytest.mark.parametrize("rule", ["greedy", "optimal"])
def test_uncertainty_says_which_mask_each_pose_was_matched_to(rule) -> None:
    poses = (AHEAD, AT_BORDER, Pose.from_translation((0, 0.2, 0.6)))
    masks = np.zeros((2, 480, 640), dtype=bool)
    masks[0, 190:290, 0:70] = True
    masks[1, 190:290, 290:390] = True
    found = uncertainty(shapes.square(), poses, masks, VGA, association=rule)
    assert found.masks.tolist() == [1, 0, UNMATCHED]
    np.testing.assert_allclose(found.c, [80 / 120, 50 / 70, 0], rtol=0, atol=1e-15)
    # The third square ends at v = 490: 10 of its 100 rows are outside.
    np.testing.assert_allclose(found.v, [1, 50 / 100, 90 / 100], rtol=0, atol=1e-15)
    np.testing.assert_allclose(found.u, [1 - 80 / 120, 1 - (50 / 70) * 0.5, 1], rtol=0, atol=1e-15)


def test_uncertainty_of_known_pairs_is_that_of_maskval() -> None:
    masks = np.zeros((2, 480, 640), dtype=bool)
    masks[0, 190:290, 290:390] = True
    masks[1, 190:290, 0:70] = True
    found = uncertainty(shapes.square(), (AHEAD, AT_BORDER), masks, VGA)
    assert found.masks.tolist() == [0, 1]
    np.testing.assert_array_equal(found.u, MaskVal()(estimates((AHEAD, AT_BORDER), masks=masks)))


def test_uncertainty_of_no_poses_is_empty() -> None:
    for rule in ("known", "greedy", "optimal"):
        found = uncertainty(shapes.square(), (), np.zeros((0, 480, 640), dtype=bool), VGA, association=rule)
        assert [a.shape for a in (found.masks, found.c, found.v, found.u)] == [(0,)] * 4


def test_poses_and_masks_of_other_numbers_have_no_known_association() -> None:
    with pytest.raises(InvalidMaskError, match=r"1 poses and 0 masks .* pass association='greedy'"):
        uncertainty(shapes.square(), (AHEAD,), np.zeros((0, 480, 640), dtype=bool), VGA)


@pytest.mark.parametrize("method", [NoUncertainty(), MaskVal(), Ensemble()])
def test_every_method_says_how_many_estimators_it_needs_and_accepts_no_detections(method) -> None:
    assert needs_of(method) == Needs(estimators=2 if isinstance(method, Ensemble) else 1)
    assert method(estimates((), ())).shape == (0,)


def test_nobody_can_write_to_estimates() -> None:
    made = estimates((AHEAD,))
    assert len(made) == 1
    for array in (made.masks, made.scores):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


MASK = np.zeros((1, 480, 640), dtype=bool)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: estimates(masks=MASK), "at least one estimator, but hold none"),
        (lambda: estimates((AHEAD,), (AHEAD, AHEAD)), "each of 1 masks, but estimator 1 gives 2"),
        (lambda: estimates((AHEAD,), masks=MASK.astype(np.uint8)), "must be bool of shape .* but are uint8"),
        (lambda: estimates((AHEAD,), masks=MASK[:, :-1]), r"\(N, 480, 640\), but are bool of \(1, 479, 640\)"),
        (lambda: Estimates(VGA, shapes.square(), MASK, ((AHEAD,),), np.ones(2)), r"finite and of shape \(1,\)"),
        (lambda: Estimates(VGA, shapes.square(), MASK, ((AHEAD,),), np.array([np.nan])), "finite and of shape"),
        (lambda: MaskVal(alpha=1.1), r"alpha must be in \[0, 1\], but is 1.1"),
        (lambda: Ensemble("add", 0.05), "0 <= minimum < maximum, but are 0.05 and 0.05"),
        (lambda: Ensemble("add", -0.01), "0 <= minimum < maximum, but are -0.01"),
        (lambda: Ensemble()(estimates((AHEAD,))), "an ensemble needs 2 estimators, but the estimates hold 1"),
        (lambda: Ensemble("rotation", 1.0, 0.5), "0 <= minimum < maximum, but are 1.0 and 0.5"),
        (lambda: Ensemble("scale"), "one of add, mdd, translation, rotation, but is 'scale'"),
        (lambda: Needs(estimators=0), "whole number >= 1, but is 0"),
        (lambda: Needs(estimators=1.5), "whole number >= 1, but is 1.5"),
        (lambda: associate(IOU[0], "greedy"), r"shape \(N, K\)"),
        (lambda: associate(2 * IOU, "greedy"), r"values in \[0, 1\]"),
        (lambda: associate(IOU, "best"), "'known', 'greedy' or 'optimal', but is 'best'"),
        (lambda: maskval_uncertainty(1.2, 1.0), r"iou must be in \[0, 1\], but is 1.2"),
        (lambda: maskval_uncertainty(0.5, np.nan), r"visibility must be in \[0, 1\], but is nan"),
    ],
)
def test_bad_estimates_are_refused(call, words) -> None:
    with pytest.raises(InvalidEstimatesError, match=words):
        call()
