from dataclasses import replace

import numpy as np
import pytest

from experiments.dataset.batch import Judged
from experiments.dataset.bootstrap import draw_weights, resample
from experiments.dataset.metrics import ERRORS_M, area, curves, evaluations, figures, least_error_threshold
from experiments.dataset.rules import ALTERNATIVES, Rules
from maskval import Evaluation, paper_threshold, recall_curve, spearman
from maskval.evaluation.metrics import chosen
from sim.instance_ids import NO_INSTANCE

METHODS = ("maskval", "ensemble-add", "oracle-mdd", "random")
RULES = {"the defaults": Rules(), **ALTERNATIVES}


def judged(images: int = 60, seed: int = 0) -> Judged:
    """Poses whose u rises with the error, in steps (ties), with a false alarm and a missed part here and there."""
    rng = np.random.default_rng(seed)
    parts = rng.integers(1, 5, size=images)
    pose_part = [rng.permutation(count)[: rng.integers(count + 1)] for count in parts]
    pose_part = [np.append(part, NO_INSTANCE) if rng.uniform() < 0.1 else part for part in pose_part]
    poses = np.array([len(part) for part in pose_part])
    flat = np.concatenate(pose_part)
    mdd_m = np.where(flat == NO_INSTANCE, np.inf, rng.lognormal(-5.2, 0.8, size=len(flat)))
    vague = np.minimum(mdd_m, 0.1) * rng.lognormal(0.0, 0.7, size=len(flat))
    u = np.round(np.minimum(1.0, vague / 0.05), 2)
    visibility = rng.uniform(0.5, 1.0, size=parts.sum())
    return Judged(
        poses=poses,
        parts=parts,
        pose_part=flat,
        mdd_m=mdd_m,
        disagreement_m=vague,
        u={
            "maskval": u,
            "ensemble-add": np.minimum(vague / 0.05, 1.0),
            "oracle-mdd": 1 - 0.015 / (0.015 + mdd_m),
            "random": rng.uniform(size=len(flat)),
        },
        visibility=visibility,
        in_view=np.minimum(1.0, visibility + 0.1),
    )


def empty() -> Judged:
    nothing = np.empty(0)
    return Judged(
        poses=np.zeros(3, int),
        parts=np.ones(3, int),
        pose_part=np.empty(0, int),
        mdd_m=nothing,
        disagreement_m=nothing,
        u=dict.fromkeys(METHODS, nothing),
        visibility=np.ones(3),
        in_view=np.ones(3),
    )  # three images with a part each, and no poses


@pytest.mark.parametrize("rules", RULES.values(), ids=RULES)
@pytest.mark.parametrize("method", ["maskval", "ensemble-add", "random"])
def test_a_bootstrap_sample_has_the_figures_of_its_images(rules: Rules, method: str) -> None:
    evaluation = evaluations(judged(), rules)[method]
    weights = draw_weights(evaluation.images, 6, np.random.default_rng(1))
    samples = list(resample(evaluation, rules, weights))
    assert len(samples) == 6
    for row, sample in zip(weights, samples, strict=True):
        expected = figures(evaluation.of_images(np.repeat(np.arange(evaluation.images), row)), rules)
        assert sample.u_tg == expected.u_tg
        assert sample[:2] == pytest.approx(expected[:2], abs=1e-9)


def test_weights_draw_as_many_images_as_there_are() -> None:
    weights = draw_weights(50, 20, np.random.default_rng(0))
    assert weights.shape == (20, 50)
    assert (weights.sum(axis=1) == 50).all()


@pytest.mark.parametrize("method", METHODS)
def test_the_defaults_are_the_metrics_of_maskval(method: str) -> None:
    evaluation = evaluations(judged(), Rules())[method]
    found, expected = figures(evaluation, Rules()), recall_curve(evaluation, ERRORS_M)
    owned = np.isfinite(evaluation.errors_m)
    assert found.auc_ar == pytest.approx(expected.auc, abs=1e-12)
    assert found.u_tg == paper_threshold(evaluation, 0.015)
    assert found.spearman == spearman(evaluation.u[owned], evaluation.errors_m[owned])


def test_the_oracle_of_the_error_reaches_the_optimum() -> None:
    curve = curves(evaluations(judged(300), Rules())["oracle-mdd"], Rules())
    assert curve.ar == pytest.approx(curve.ar_star, abs=1e-12)
    assert curve.ar[15] > 0.5
    assert curve.aru[15] == pytest.approx(1.0)


def test_no_method_beats_the_oracle_and_chance_ranks_nothing() -> None:
    sets = evaluations(judged(300), Rules())
    areas = {method: figures(one, Rules()).auc_ar for method, one in sets.items()}
    assert max(areas.values()) == areas["oracle-mdd"]
    assert abs(figures(sets["random"], Rules()).spearman or 0.0) < 0.15


def test_ensemble_add_is_scaled_from_the_least_of_the_set_or_from_zero() -> None:
    one = judged()
    least = one.disagreement_m.min()
    expected = np.clip((one.disagreement_m - least) / (0.05 - least), 0, 1)
    assert evaluations(one, Rules())["ensemble-add"].u == pytest.approx(expected)
    from_zero = evaluations(one, Rules(ensemble_minimum="zero"))["ensemble-add"].u
    assert from_zero == pytest.approx(np.clip(one.disagreement_m / 0.05, 0, 1))


@pytest.mark.parametrize("method", METHODS)
def test_no_threshold_sorts_with_fewer_errors_than_that_of_least_error(method: str) -> None:
    evaluation = evaluations(judged(), Rules())[method]
    good = evaluation.errors_m <= 0.015

    def errors(u_t: float) -> int:
        return int(np.count_nonzero((evaluation.u <= u_t) != good))

    each = {u: errors(u) for u in np.unique(evaluation.u).tolist()}
    assert len(each) > 20
    found = least_error_threshold(evaluation)
    assert found == min(each, key=lambda u: (each[u], u))


def test_without_a_right_pose_there_is_no_threshold_of_least_error() -> None:
    assert least_error_threshold(evaluations(empty(), Rules())["maskval"]) is None
    wrong = replace(judged(), mdd_m=np.full(len(judged().mdd_m), 0.1))
    assert least_error_threshold(evaluations(wrong, Rules())["maskval"]) is None


def test_a_part_found_twice_belongs_to_the_better_pose() -> None:
    twice = replace(empty(), poses=np.array([2, 0, 0]), pose_part=np.zeros(2, int), mdd_m=np.array([0.02, 0.01]))
    two = np.array([0.3, 0.4])
    twice = replace(twice, disagreement_m=two, u={"maskval": two})
    evaluation = evaluations(twice, Rules())["maskval"]
    assert evaluation.pose_part.tolist() == [NO_INSTANCE, 0]
    assert evaluation.errors_m.tolist() == [np.inf, 0.01]


@pytest.mark.parametrize("rules", RULES.values(), ids=RULES)
def test_a_set_without_poses_has_undefined_figures(rules: Rules) -> None:
    evaluation: Evaluation = evaluations(empty(), rules)["maskval"]
    assert figures(evaluation, rules) == (None, 0.0, None)
    assert list(resample(evaluation, rules, np.ones((2, 3), int))) == [(None, 0.0, None)] * 2


@pytest.mark.parametrize(
    ("reached", "largest", "first_violation"),
    [([1, 1, 0, 1, 0], 3, 1), ([0, 1, 0], 1, -1), ([0, 0], -1, -1), ([1, 1], 1, 1), ([], -1, -1)],
)
def test_the_threshold_is_the_largest_or_the_last_before_the_first_violation(
    reached: list[int], largest: int, first_violation: int
) -> None:
    flags = np.array(reached, dtype=bool)
    assert chosen(flags, "largest") == largest
    assert chosen(flags, "first violation") == first_violation
    assert chosen(np.array([flags, flags]), "largest").tolist() == [largest, largest]


def test_the_area_from_the_first_reached_error_leaves_out_what_is_before() -> None:
    reached = np.arange(31) >= 10
    ar = np.where(reached, 0.8, 0.0)
    assert area(ar, reached, "reached") == pytest.approx(0.8)
    assert area(ar, reached, "whole") == pytest.approx(0.8 * 20.5 / 30)
    assert area(np.zeros(31), np.zeros(31, bool), "reached") == 0.0
