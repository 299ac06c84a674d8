from dataclasses import replace

import numpy as np
import pytest

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import Evaluation
from maskval.evaluation.metrics import rates
from maskval.evaluation.thresholds import certified_threshold, conformal_threshold, paper_threshold
from tests.maskval.evaluation.test_metrics import random_evaluation


def test_the_papers_threshold_is_the_largest_that_reaches_the_ap() -> None:
    source = random_evaluation(9, images=50)
    noise = np.random.default_rng(9).uniform(0.5, 1.5, size=len(source.u))
    evaluation = replace(source, u=np.minimum(source.errors_m, 0.1) * noise)
    u_T = paper_threshold(evaluation, 0.015, 0.9)
    assert u_T is not None
    assert rates(evaluation, 0.015, u_T).ap >= 0.9
    larger = evaluation.u[evaluation.u > u_T]
    assert len(larger) > 0
    assert all(rates(evaluation, 0.015, u).ap < 0.9 for u in larger)


def test_there_is_no_threshold_where_every_pose_is_bad() -> None:
    bad = Evaluation(2, [0, 1], [0, 1], [0.5, 0.6], [0.1, 0.2], [0, 1], [1, 1])
    assert paper_threshold(bad, 0.01) is None


def test_a_certificate_needs_as_many_good_poses_as_its_bound_says() -> None:
    # Without a bad pose among n kept, the bound at doubt δ is 1 - δ^(1 / n); 20 thresholds share δ = 0.05.
    needed = int(np.ceil(np.log(0.05 / 20) / np.log(0.99)))
    assert certified_threshold(np.full(needed - 1, 0.3), np.zeros(needed - 1)) is None
    found = certified_threshold(np.full(needed, 0.3), np.zeros(needed))
    assert found == (1.0, needed, 0, pytest.approx(1 - (0.05 / 20) ** (1 / needed)))
    # A threshold that is fixed beforehand shares its doubt with no other.
    alone = int(np.ceil(np.log(0.05) / np.log(0.99)))
    assert certified_threshold(np.full(alone, 0.3), np.zeros(alone), grid=[0.5]).u_T == 0.5


def test_a_certificate_keeps_its_word_in_as_many_draws_as_it_says() -> None:
    # A pose of uncertainty u is bad with probability u / 5: below u_T the share of bad ones is u_T / 10.
    rng = np.random.default_rng(0)
    broken = given = 0
    for _ in range(100):
        u = rng.random(2000)
        found = certified_threshold(u, rng.random(2000) < u / 5, maximum_risk=0.05, confidence=0.8)
        if found is not None:
            given += 1
            broken += found.u_T / 10 > 0.05
    assert given > 80
    assert broken <= 0.2 * 100


def test_conformal_risk_control_counts_one_more_bad_pose() -> None:
    # 99 poses, rising u, the 50th and the 80th bad: (k + 1) / 100 <= 0.02 holds up to the 79th.
    u = np.arange(99) / 99
    bad = np.isin(np.arange(99), (49, 79))
    assert conformal_threshold(u, bad, maximum_risk=0.02) == u[78]
    assert conformal_threshold(u, bad, maximum_risk=0.03) == u[98]
    assert conformal_threshold(u, bad, maximum_risk=0.01) == u[48]
    assert conformal_threshold(u, bad, maximum_risk=0.009) is None


def test_conformal_risk_control_keeps_equal_poses_together() -> None:
    assert conformal_threshold([0.1] * 5 + [0.2] * 5, [0] * 9 + [1], maximum_risk=0.1) == 0.1


def test_the_risk_of_conformal_thresholds_is_on_average_below_the_bound() -> None:
    rng = np.random.default_rng(1)
    risks = []
    for _ in range(400):
        u = rng.random(60)
        u_T = conformal_threshold(u, rng.random(60) < u / 2, maximum_risk=0.1)
        # P(u <= u_T and bad) = ∫ u / 2 du.
        risks.append(0.0 if u_T is None else u_T**2 / 4)
    assert 0.05 < np.mean(risks) <= 0.1


@pytest.mark.parametrize("threshold", [certified_threshold, conformal_threshold])
def test_no_data_gives_no_threshold(threshold) -> None:
    assert threshold([], []) is None


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: paper_threshold(random_evaluation(0), 0.01, 1.5), r"demanded_ap must be in \(0, 1\], but is 1.5"),
        (lambda: certified_threshold([0.1], [0, 1]), r"one shape \(N,\), but have \(1,\) and \(2,\)"),
        (lambda: certified_threshold([np.nan], [0]), "must be finite"),
        (lambda: certified_threshold([0.1], [0], maximum_risk=0), r"maximum_risk must be in \(0, 1\), but is 0"),
        (lambda: certified_threshold([0.1], [0], confidence=1.0), r"confidence must be in \(0, 1\), but is 1.0"),
        (lambda: conformal_threshold([0.1], [0], maximum_risk=1), r"maximum_risk must be in \(0, 1\), but is 1"),
    ],
)
def test_bad_arguments_are_refused(call, words) -> None:
    with pytest.raises(InvalidEvaluationError, match=words):
        call()
