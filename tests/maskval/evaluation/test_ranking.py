from itertools import permutations

import numpy as np
import pytest

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.metrics import rates
from maskval.evaluation.ranking import aurc, auroc, bootstrap_interval, spearman
from tests.maskval.evaluation.test_metrics import random_evaluation


def test_spearman_of_a_monotone_relation_is_1_however_bent() -> None:
    errors = np.random.default_rng(0).exponential(size=50)
    assert spearman(np.exp(errors), errors) == pytest.approx(1)
    assert spearman(-(errors**3), errors) == pytest.approx(-1)


def test_spearman_is_the_correlation_of_the_ranks() -> None:
    # Ranks 1 2 3 4 against 2 1 4 3: 1 - 6 Σd² / (n (n² - 1)).
    assert spearman([1, 2, 3, 4], [20, 10, 40, 30]) == pytest.approx(1 - 6 * 4 / (4 * 15))


def test_auroc_is_the_share_of_ordered_pairs() -> None:
    rng = np.random.default_rng(1)
    u, bad = rng.integers(5, size=40), rng.random(40) < 0.3
    pairs = [(u[i] > u[j]) + 0.5 * (u[i] == u[j]) for i in np.flatnonzero(bad) for j in np.flatnonzero(~bad)]
    assert len(pairs) > 100
    assert auroc(u, bad) == pytest.approx(np.mean(pairs))
    assert auroc([0.1, 0.2, 0.3], [0, 0, 1]) == 1
    assert auroc([0.1, 0.2, 0.3], [1, 0, 0]) == 0
    assert auroc([0.5, 0.5], [1, 0]) == 0.5


def test_aurc_is_the_mean_risk_over_coverage() -> None:
    # Losses in the order of u: 0, 1, 0, 1; risks 0, 1/2, 1/3, 1/2.
    assert aurc([0.1, 0.2, 0.3, 0.4], [0, 1, 0, 1]) == pytest.approx((0 + 1 / 2 + 1 / 3 + 1 / 2) / 4)


def test_aurc_of_equal_uncertainties_is_its_mean_over_all_orders() -> None:
    u, losses = np.array([0.1, 0.5, 0.5, 0.5, 0.9]), np.array([0.2, 1, 0, 0.5, 1])
    orders = [(0, *middle, 4) for middle in permutations((1, 2, 3))]
    areas = [np.mean(np.cumsum(losses[list(order)]) / np.arange(1, 6)) for order in orders]
    assert aurc(u, losses) == pytest.approx(np.mean(areas))


@pytest.mark.parametrize("metric", [spearman, auroc, aurc])
def test_ranking_metrics_see_the_order_of_u_only(metric) -> None:
    rng = np.random.default_rng(2)
    u, bad = rng.random(30), rng.random(30) < 0.4
    assert metric(u, bad) == pytest.approx(metric(u**5 - 3, bad))


def test_metrics_without_a_meaning_are_none() -> None:
    assert spearman([], []) is None
    assert spearman([1, 1], [1, 2]) is None
    assert spearman([1, 2], [1, 1]) is None
    assert auroc([0.1, 0.2], [0, 0]) is None
    assert auroc([0.1, 0.2], [1, 1]) is None
    assert aurc([], []) is None


def test_the_bootstrap_draws_whole_images() -> None:
    evaluation = random_evaluation(7, images=60)
    images = []
    interval = bootstrap_interval(
        evaluation,
        lambda sample: images.append(sample.images) or rates(sample, 0.01).ap,
        np.random.default_rng(0),
        resamples=300,
    )
    assert images == [60] * 300
    low, high = interval
    assert low < rates(evaluation, 0.01).ap < high
    assert high - low < 0.4


def test_the_bootstrap_of_what_is_never_defined_is_none() -> None:
    assert bootstrap_interval(random_evaluation(8), lambda _: None, np.random.default_rng(0), resamples=3) is None


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: spearman([1, 2], [1]), r"one shape \(N,\), but have \(2,\) and \(1,\)"),
        (lambda: spearman([1, 2], [1, np.inf]), "must be finite: leave out poses without a part"),
        (
            lambda: bootstrap_interval(random_evaluation(0), lambda _: 0.0, np.random.default_rng(0), 0.9, 0),
            "not 12 and 0",
        ),
    ],
)
def test_bad_arguments_are_refused(call, words) -> None:
    with pytest.raises(InvalidEvaluationError, match=words):
        call()
