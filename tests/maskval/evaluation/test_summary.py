import numpy as np
import pytest

from maskval import (
    NO_PART,
    Evaluation,
    InvalidEvaluationError,
    aurc,
    auroc,
    paper_threshold,
    rates,
    recall_curve,
    spearman,
    summarise,
)


def evaluation(images: int = 60, *, noise: float = 0.0) -> Evaluation:
    """Two poses of two parts in each image; u follows the error, up to noise, and one pose of ten has no part."""
    rng = np.random.default_rng(0)
    count = 2 * images
    errors = rng.uniform(0, 0.03, size=count)
    parts = np.arange(count)
    parts[::10] = NO_PART
    errors[::10] = np.inf
    u = np.clip(np.minimum(errors, 0.04) / 0.04 + noise * rng.normal(size=count), 0, 1)
    image = np.repeat(np.arange(images), 2)
    return Evaluation(images, image, parts, errors, u, image, np.ones(count))


def test_a_summary_holds_the_metrics_of_the_evaluation() -> None:
    made = evaluation(noise=0.1)
    found = summarise(made, 0.015, resamples=40)
    owned = np.isfinite(made.errors_m)
    bad = made.errors_m > 0.015
    assert (found.images, found.poses, found.parts) == (60, 120, 120)
    assert found.spearman.value == spearman(made.u[owned], made.errors_m[owned])
    assert (found.auroc.value, found.aurc.value) == (auroc(made.u, bad), aurc(made.u, bad))
    assert found.auc.value == recall_curve(made, np.linspace(0, 0.03, 31)).auc
    everything, paper = found.thresholds[:2]
    assert (everything.rule, everything.ap.value) == ("all poses", rates(made, 0.015).ap)
    assert paper.u_T.value == paper_threshold(made, 0.015)
    assert tuple(rate.value for rate in (paper.ap, paper.ar, paper.aru)) == rates(made, 0.015, paper.u_T.value)
    for measured in (found.spearman, found.auroc, found.aurc, found.auc, everything.ar, paper.u_T):
        low, high = measured.interval
        assert low < measured.value < high


def test_an_oracle_reaches_the_oracles_figures() -> None:
    found = summarise(evaluation(), 0.015, resamples=20)
    assert (found.spearman.value, found.auroc.value) == (pytest.approx(1.0), 1.0)
    paper = found.thresholds[1]
    assert (paper.ap.value, paper.aru.value) == (1.0, 1.0)
    assert paper.ar.value == found.thresholds[0].ar.value


def test_the_guarantees_abstain_on_few_poses_and_hold_on_many() -> None:
    few = {row.rule: row.u_T.value for row in summarise(evaluation(), 0.015, resamples=1).thresholds}
    assert (few["certified"], few["conformal"]) == (None, None)
    many = {row.rule: row.u_T.value for row in summarise(evaluation(images=3000), 0.015, resamples=1).thresholds}
    # Errors up to 15 mm are u up to 0.375: the certificate's grid has 0.35 below it, and 0.4 above it.
    assert many["certified"] == 0.35
    assert 0.375 <= many["conformal"] < 0.4


def test_a_summary_is_a_table_and_the_same_every_time() -> None:
    text = str(summarise(evaluation(), resamples=5))
    assert text == str(summarise(evaluation(), resamples=5))
    lines = text.splitlines()
    assert lines[0] == "120 poses of 120 parts in 60 images; good is an error of at most 15 mm; [95% intervals]"
    assert [line.split()[0] for line in lines[1:]] == [
        *("Spearman", "AUROC", "AURC", "AUC", "rule", "all", "paper", "certified", "conformal")
    ]
    assert lines[-1].split() == ["conformal", "abstains"]


def test_what_is_undefined_is_named() -> None:
    nothing = np.empty(0)
    found = summarise(Evaluation(3, nothing, nothing, nothing, nothing, nothing, nothing), resamples=2)
    assert (found.spearman.value, found.auroc.interval, found.thresholds[0].ap.value) == (None, None, None)
    assert "Spearman  undefined" in str(found)


def test_a_summary_needs_images_and_resamples() -> None:
    with pytest.raises(InvalidEvaluationError, match="needs images and resamples, not 60 and 0"):
        summarise(evaluation(), resamples=0)
