from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import NO_PART, Counting, Evaluation, ImageErrors, match_images
from maskval.evaluation.metrics import Rates, rates, recall_curve, sweep

COUNTINGS = [
    Counting(averaging, empty, missed, 0.5)
    for averaging, empty, missed in product(("images", "pooled"), ("skip", "one"), ("no true positive", "no pose"))
]


def random_evaluation(seed: int, images: int = 12, coarse: bool = True) -> Evaluation:
    """A few poses and parts per image: unfound, twice found, invisible, false and none at all; equal u when coarse."""
    rng = np.random.default_rng(seed)
    part_image = rng.integers(images, size=2 * images)
    pose_part = rng.integers(-5, 2 * images, size=3 * images).clip(NO_PART)
    pose_image = np.where(pose_part == NO_PART, rng.integers(images, size=3 * images), part_image[pose_part])
    errors_m = np.where(pose_part == NO_PART, np.inf, rng.exponential(0.01, size=3 * images))
    u = rng.integers(6, size=3 * images) / 5 if coarse else rng.random(3 * images)
    return Evaluation(images, pose_image, pose_part, errors_m, u, part_image, rng.random(2 * images))


def counted(e: Evaluation, e_t: float, u_T: float, rule: Counting) -> Rates:
    """The definitions, image by image."""
    kept = e.u <= u_T
    good = e.errors_m <= e_t
    counts = []
    for image in range(e.images):
        here = e.pose_image == image
        tp, fp = np.count_nonzero(here & kept & good), np.count_nonzero(here & kept & ~good)
        fn = 0
        for part in np.flatnonzero((e.part_image == image) & (e.part_visibility >= rule.visibility_threshold)):
            poses = kept & (e.pose_part == part)
            fn += not (poses & good).any() if rule.false_negatives == "no true positive" else not poses.any()
        counts.append((tp, fp, fn, np.count_nonzero(here & good)))
    if rule.averaging == "pooled":
        counts = [tuple(np.sum(counts, axis=0))]

    def mean(ratios: list[tuple[int, int]], empty: float | None = None) -> float | None:
        values = [top / bottom if bottom else empty for top, bottom in ratios]
        defined = [value for value in values if value is not None]
        return sum(defined) / len(defined) if defined else None

    one = 1.0 if rule.empty_images == "one" and rule.averaging == "images" else None
    return Rates(
        mean([(tp, tp + fp) for tp, fp, _, _ in counts], one),
        mean([(tp, tp + fn) for tp, _, fn, _ in counts]),
        mean([(tp, true) for tp, _, _, true in counts]),
    )


@pytest.mark.parametrize("rule", COUNTINGS, ids=str)
@pytest.mark.parametrize("coarse", [True, False])
def test_the_sweep_counts_what_the_definitions_count(rule, coarse) -> None:
    for seed in range(8):
        evaluation = random_evaluation(seed, coarse=coarse)
        for u_T in (-0.1, 0.0, 0.1, 0.4, 0.5, 0.99, 1.0, np.inf):
            for e_t in (0.0, 0.004, 0.02):
                found, expected = rates(evaluation, e_t, u_T, rule), counted(evaluation, e_t, u_T, rule)
                assert [value is None for value in found] == [value is None for value in expected]
                np.testing.assert_allclose(
                    [value for value in found if value is not None],
                    [value for value in expected if value is not None],
                    rtol=0,
                    atol=1e-13,
                )


# Two images. Image 0: part 0 has a good and a bad pose, part 1 a bad one. Image 1: part 2 is found, part 3 (hidden)
# has no pose, and one pose is of no part.
EXAMPLE = Evaluation(
    images=2,
    pose_image=np.array([0, 0, 0, 1, 1]),
    pose_part=np.array([0, 0, 1, 2, NO_PART]),
    errors_m=np.array([0.001, 0.02, 0.03, 0.002, np.inf]),
    u=np.array([0.1, 0.3, 0.9, 0.2, 0.8]),
    part_image=np.array([0, 0, 1, 1]),
    part_visibility=np.array([1.0, 0.9, 0.85, 0.84]),
)


def test_rates_of_the_example() -> None:
    # All: image 0 has TP 1, FP 2, FN 1 (part 1); image 1 has TP 1, FP 1, FN 0 (part 3 is not visible enough).
    assert rates(EXAMPLE, 0.01) == pytest.approx(((1 / 3 + 1 / 2) / 2, (1 / 2 + 1) / 2, 1.0))
    assert rates(EXAMPLE, 0.01, counting=Counting("pooled")) == pytest.approx((2 / 5, 2 / 3, 2 / 2))
    # u <= 0.15: image 1 has no pose left, so no AP; its part 2 is missed.
    assert rates(EXAMPLE, 0.01, 0.15) == pytest.approx((1.0, (1 / 2 + 0) / 2, 1 / 2))
    # Nothing left: no AP at all, unless empty images count as 1.
    assert rates(EXAMPLE, 0.01, 0.0) == (None, 0.0, 0.0)
    assert rates(EXAMPLE, 0.01, 0.0, Counting(empty_images="one")) == (1.0, 0.0, 0.0)


def test_the_largest_threshold_reaches_the_ap_even_if_a_smaller_one_does_not() -> None:
    # One pose an image, rising u: bad, good, good, good. AP 0, 1/2, 2/3, 3/4.
    evaluation = Evaluation(
        4, np.arange(4), np.arange(4), np.array([9, 0, 0, 0]), np.arange(4) / 4, np.arange(4), np.ones(4)
    )
    found = sweep(evaluation, 0.01)
    assert found.reaching(0.75) == 4
    assert found.u[4] == 3 / 4
    assert found.reaching(0.5) == 4
    assert found.reaching(0.76) is None


def test_the_recall_curve_is_the_recall_at_the_largest_threshold_that_reaches_the_ap() -> None:
    evaluation = random_evaluation(3, images=40, coarse=False)
    errors_m = np.linspace(0, 0.03, 7)
    curve = recall_curve(evaluation, errors_m, 0.9)
    reached = 0
    for i, e_t in enumerate(errors_m):
        at_each = [(u_T, rates(evaluation, e_t, u_T)) for u_T in evaluation.u]
        sufficient = [pair for pair in at_each if pair[1].ap is not None and pair[1].ap >= 0.9]
        assert curve.ar_star[i] == rates(evaluation, e_t).ar
        if sufficient:
            u_T, best = max(sufficient)
            assert (curve.u[i], curve.ar[i], curve.aru[i]) == (u_T, best.ar, best.aru)
            reached += 1
        else:
            assert (curve.u[i], curve.ar[i], curve.aru[i]) == (None, 0, 0)
    assert 2 <= reached <= 6


def test_the_area_under_the_recall_curve_is_divided_by_the_error_range() -> None:
    # The only pose has an error of 1 cm: recall 0 up to there, and 1 beyond.
    one = Evaluation(1, [0], [0], [0.01], [0.5], [0], [1.0])
    curve = recall_curve(one, [0.0, 0.005, 0.01, 0.02, 0.03])
    assert curve.ar.tolist() == curve.ar_star.tolist() == [0, 0, 1, 1, 1]
    assert curve.u == (None, None, 0.5, 0.5, 0.5)
    assert curve.auc == pytest.approx((0.005 / 2 + 0.02) / 0.03)


def test_a_perfect_uncertainty_reaches_ar_star() -> None:
    source = random_evaluation(4, images=60)
    perfect = replace(source, u=np.minimum(source.errors_m, 1.0))
    curve = recall_curve(perfect, np.linspace(0.001, 0.03, 6), 1.0)
    assert (curve.ar_star > 0.1).all()
    np.testing.assert_allclose(curve.ar, curve.ar_star, rtol=0, atol=1e-13)
    np.testing.assert_allclose(curve.aru, 1, rtol=0, atol=1e-13)


def test_metrics_see_the_order_of_u_only() -> None:
    source = random_evaluation(5, images=30)
    bent = replace(source, u=np.exp(3 * source.u) - 7)
    errors_m = np.linspace(0, 0.03, 5)
    plain, other = recall_curve(source, errors_m, 0.8), recall_curve(bent, errors_m, 0.8)
    assert plain.auc > 0.01
    np.testing.assert_array_equal(plain.ar, other.ar)
    np.testing.assert_array_equal(plain.aru, other.aru)


def test_an_evaluation_without_poses_or_parts_has_no_rates() -> None:
    empty = Evaluation(3, [], [], [], [], [], [])
    assert rates(empty, 0.01) == (None, None, None)
    assert rates(Evaluation(3, [], [], [], [], [1], [1.0]), 0.01) == (None, 0.0, None)
    assert recall_curve(empty, [0.0, 0.01]).auc == 0


def test_chosen_images_keep_their_poses_and_parts() -> None:
    evaluation = random_evaluation(6)
    same = evaluation.of_images(np.arange(evaluation.images))
    assert rates(same, 0.01, 0.5) == pytest.approx(rates(evaluation, 0.01, 0.5))
    twice = evaluation.of_images(np.repeat(np.arange(evaluation.images), 2))
    assert len(twice.u) == 2 * len(evaluation.u)
    assert rates(twice, 0.01, 0.5) == pytest.approx(rates(evaluation, 0.01, 0.5))
    assert rates(twice, 0.01, 0.5, Counting("pooled")) == pytest.approx(
        rates(evaluation, 0.01, 0.5, Counting("pooled"))
    )
    one = EXAMPLE.of_images(np.array([1, 1]))
    assert one.pose_part.tolist() == [0, NO_PART, 2, NO_PART]
    assert one.part_visibility.tolist() == [0.85, 0.84, 0.85, 0.84]
    assert rates(one, 0.01) == pytest.approx((1 / 2, 1.0, 1.0))


def test_poses_are_matched_to_parts_by_the_least_error_first() -> None:
    evaluation = match_images(
        [
            ImageErrors(np.array([[0.02, 0.5], [0.01, 0.03], [0.4, np.inf]]), np.array([0.1, 0.2, 0.3]), np.ones(2)),
            ImageErrors(np.empty((0, 1)), np.empty(0), np.array([0.9])),
            ImageErrors(np.array([[0.005]]), np.array([0.4]), np.array([0.5])),
            ImageErrors(np.empty((1, 0)), np.array([0.6]), np.empty(0)),
        ]
    )
    # Image 0: pose 1 takes part 0, so pose 0 gets part 1 at 0.5 m, and for pose 2 there is none left.
    assert evaluation.pose_part.tolist() == [1, 0, NO_PART, 3, NO_PART]
    assert evaluation.errors_m.tolist() == [0.5, 0.01, np.inf, 0.005, np.inf]
    assert evaluation.pose_image.tolist() == [0, 0, 0, 2, 3]
    assert evaluation.part_image.tolist() == [0, 0, 1, 2]
    assert evaluation.part_visibility.tolist() == [1, 1, 0.9, 0.5]
    assert rates(match_images([]), 0.01) == (None, None, None)


def test_poses_and_parts_that_are_no_table_are_refused() -> None:
    for errors_m in (np.zeros((2, 1)), np.full((1, 1), -1.0)):
        with pytest.raises(InvalidEvaluationError, match=r"errors_m of image 0 must be >= 0 and of shape \(1, 1\)"):
            match_images([ImageErrors(errors_m, np.zeros(1), np.ones(1))])


def changed(**changes) -> Evaluation:
    fields = {
        "images": 1,
        "pose_image": [0, 0],
        "pose_part": [0, NO_PART],
        "errors_m": [0.0, np.inf],
        "u": [0.1, 0.2],
        "part_image": [0],
        "part_visibility": [1.0],
    }
    return Evaluation(**(fields | changes))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: changed(u=[0.1]), r"pose_image must have shape \(1,\), but has \(2,\)"),
        (lambda: changed(u=[0.1, np.nan]), "u must be finite, but pose 1 has none"),
        (lambda: changed(errors_m=[0.0, 0.5]), "infinite for a pose without a part"),
        (lambda: changed(errors_m=[-1.0, np.inf]), "errors_m must be >= 0"),
        (lambda: changed(errors_m=[np.nan, np.inf]), "errors_m must be >= 0"),
        (lambda: changed(pose_image=[0, 1]), r"pose_image\[1\] must be in 0..0, but is 1"),
        (lambda: changed(pose_part=[1, NO_PART]), r"pose_part\[0\] must be in -1..0, but is 1"),
        (lambda: changed(images=2, part_image=[1]), "pose 0 and its part 0 must be in one image"),
        (lambda: changed(part_visibility=[1.5]), r"part_visibility must be in \[0, 1\]"),
        (lambda: Counting(averaging="mean"), "averaging must be one of .* but is 'mean'"),
        (lambda: Counting(visibility_threshold=2), r"visibility_threshold must be in \[0, 1\], but is 2"),
        (lambda: recall_curve(EXAMPLE, [0.01]), "at least two rising thresholds"),
        (lambda: recall_curve(EXAMPLE, [0.01, 0.01]), "at least two rising thresholds"),
        (lambda: recall_curve(EXAMPLE, [0, 0.01], 0.0), r"demanded_ap must be in \(0, 1\], but is 0.0"),
    ],
)
def test_bad_evaluations_are_refused(call, words) -> None:
    with pytest.raises(InvalidEvaluationError, match=words):
        call()
