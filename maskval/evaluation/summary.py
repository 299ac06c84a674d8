"""What an uncertainty is worth on poses whose errors are known: every metric and threshold, with intervals."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidEvaluationError
from maskval.evaluation.matching import Counting, Evaluation
from maskval.evaluation.metrics import DEMANDED_AP, MAXIMUM_ERROR_M, rates, recall_curve
from maskval.evaluation.ranking import aurc, auroc, spearman
from maskval.evaluation.thresholds import certified_threshold, conformal_threshold, paper_threshold
from maskval.inputs.arrays import check_number
from maskval.statistics.intervals import percentile_interval

# The paper's e_t for its robot, and the steps of its curves.
ERROR_THRESHOLD_M = 0.015
CURVE_STEPS = 31

Statistic = Callable[[Evaluation], float | None]


class Measured(NamedTuple):
    """A figure and its bootstrap interval; None where it is undefined."""

    value: float | None
    interval: tuple[float, float] | None

    def __str__(self) -> str:
        if self.value is None:
            return "undefined"
        return f"{self.value:.4g}" + (f" [{self.interval[0]:.4g}, {self.interval[1]:.4g}]" if self.interval else "")


@dataclass(frozen=True, slots=True)
class Threshold:
    """A threshold u_T and what it keeps.

    Args:
        rule: How it was found.
        u_T: The threshold, with the interval over which it moves from sample to sample; None where the rule abstains.
        ap: AP of the poses of u <= u_T.
        ar: Their AR.
        aru: Their ARU.
    """

    rule: str
    u_T: Measured
    ap: Measured
    ar: Measured
    aru: Measured


@dataclass(frozen=True, slots=True)
class Summary:
    """Metrics and thresholds of an evaluation; printed, a table.

    Args:
        images: Number of images.
        poses: Number of poses.
        parts: Number of parts.
        e_t: Greatest error of a true positive, metres.
        demanded_ap: AP that the thresholds are to reach.
        level: Confidence level of the intervals.
        spearman: Rank correlation of u and error, of the poses that have a part.
        auroc: Probability that a bad pose has the greater u of a bad and a good one.
        aurc: Area under risk over coverage, the risk being the share of bad poses.
        auc: Area under AR over the error threshold at the demanded AP, up to 3 cm, in [0, 1].
        thresholds: All poses, and the rules' thresholds.
    """

    images: int
    poses: int
    parts: int
    e_t: float
    demanded_ap: float
    level: float
    spearman: Measured
    auroc: Measured
    aurc: Measured
    auc: Measured
    thresholds: tuple[Threshold, ...]

    def __str__(self) -> str:
        rows = [("rule", "u_T", "AP", "AR", "ARU")]
        for row in self.thresholds:
            kept = (row.u_T, row.ap, row.ar, row.aru)
            rows.append((row.rule, *(("abstains", "", "", "") if row.u_T.value is None else map(str, kept))))
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        table = [
            "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
        ]
        return "\n".join(
            (
                f"{self.poses} poses of {self.parts} parts in {self.images} images; "
                f"good is an error of at most {self.e_t * 1e3:g} mm; [{self.level:.0%} intervals]",
                f"Spearman  {self.spearman}",
                f"AUROC     {self.auroc}",
                f"AURC      {self.aurc}",
                f"AUC AR    {self.auc}  (errors up to {MAXIMUM_ERROR_M * 1e3:g} mm at AP >= {self.demanded_ap:g})",
                *table,
            )
        )


def summarise(
    evaluation: Evaluation,
    e_t: float = ERROR_THRESHOLD_M,
    *,
    demanded_ap: float = DEMANDED_AP,
    counting: Counting | None = None,
    rng: np.random.Generator | None = None,
    level: float = 0.95,
    resamples: int = 200,
    progress: Callable[[int], object] = lambda count: None,
) -> Summary:
    """Every metric and threshold of an evaluation, with bootstrap intervals over its images.

    The certified and the conformal threshold are found with one pose of each image, drawn at random: they need
    independent poses.

    Args:
        evaluation: Poses and parts.
        e_t: Greatest error of a true positive, metres.
        demanded_ap: Least AP that a threshold must reach, in (0, 1).
        counting: What the paper leaves open.
        rng: Source of the draws; seeded with 0 by default, so that the same evaluation has the same summary.
        level: Confidence level of the intervals, in (0, 1).
        resamples: Number of bootstrap samples, >= 1.
        progress: Called with a number of bootstrap samples whenever so many more are drawn.
    """
    if evaluation.images < 1 or resamples < 1:
        raise InvalidEvaluationError(f"a summary needs images and resamples, not {evaluation.images} and {resamples}")
    check_number("level", level, InvalidEvaluationError, least=0, most=1, ends="()")
    rng = rng or np.random.default_rng(0)
    fixed = _thresholds(evaluation, e_t, demanded_ap, counting, rng)
    curve = np.linspace(0.0, MAXIMUM_ERROR_M, CURVE_STEPS)
    statistics: dict[str, Statistic] = {
        "spearman": lambda sample: spearman(sample.u[_owned(sample)], sample.errors_m[_owned(sample)]),
        "auroc": lambda sample: auroc(sample.u, sample.errors_m > e_t),
        "aurc": lambda sample: aurc(sample.u, sample.errors_m > e_t),
        "auc": lambda sample: recall_curve(sample, curve, demanded_ap, counting).auc,
        "paper u_T": lambda sample: paper_threshold(sample, e_t, demanded_ap, counting),
    }
    for rule, u_T in fixed.items():
        if u_T is not None:
            for index, name in enumerate(("ap", "ar", "aru")):
                statistics[f"{rule} {name}"] = _rate(e_t, u_T, counting, index)
    samples = _samples(evaluation, rng, resamples, progress)
    measured = _bootstrap(evaluation, statistics, samples, level)
    nothing = Measured(None, None)
    return Summary(
        images=evaluation.images,
        poses=len(evaluation.u),
        parts=len(evaluation.part_image),
        e_t=e_t,
        demanded_ap=demanded_ap,
        level=level,
        **{name: measured[name] for name in ("spearman", "auroc", "aurc", "auc")},
        thresholds=tuple(
            Threshold(
                rule,
                measured.get(f"{rule} u_T", Measured(u_T, None)),
                *(measured.get(f"{rule} {name}", nothing) for name in ("ap", "ar", "aru")),
            )
            for rule, u_T in fixed.items()
        ),
    )


def _thresholds(
    evaluation: Evaluation, e_t: float, demanded_ap: float, counting: Counting | None, rng: np.random.Generator
) -> dict[str, float | None]:
    """The threshold of each rule, or None where it abstains."""
    bad = evaluation.errors_m > e_t
    drawn = _one_of_each_image(evaluation, rng)
    u, flags, risk = evaluation.u[drawn], bad[drawn], 1 - demanded_ap
    certificate = certified_threshold(u, flags, maximum_risk=risk)
    return {
        "all poses": np.inf,
        "paper": paper_threshold(evaluation, e_t, demanded_ap, counting),
        "certified": certificate.u_T if certificate else None,
        "conformal": conformal_threshold(u, flags, maximum_risk=risk),
    }


def _one_of_each_image(evaluation: Evaluation, rng: np.random.Generator) -> NDArray[np.int64]:
    shuffled = rng.permutation(len(evaluation.u))
    _, first = np.unique(evaluation.pose_image[shuffled], return_index=True)
    return shuffled[first]


def _owned(evaluation: Evaluation) -> NDArray[np.bool_]:
    return np.isfinite(evaluation.errors_m)


def _rate(e_t: float, u_T: float, counting: Counting | None, index: int) -> Statistic:
    return lambda sample: rates(sample, e_t, u_T, counting)[index]


def _samples(
    evaluation: Evaluation, rng: np.random.Generator, resamples: int, progress: Callable[[int], object]
) -> Iterator[Evaluation]:
    """Bootstrap samples of the images; the next one is asked for when the one before is done."""
    for _ in range(resamples):
        yield evaluation.of_images(rng.integers(evaluation.images, size=evaluation.images))
        progress(1)


def _bootstrap(
    evaluation: Evaluation, statistics: dict[str, Statistic], samples: Iterable[Evaluation], level: float
) -> dict[str, Measured]:
    """Each statistic with its interval, all from the same samples of images; undefined ones are left out."""
    drawn: dict[str, list[float]] = {name: [] for name in statistics}
    for sample in samples:
        for name, statistic in statistics.items():
            value = statistic(sample)
            if value is not None:
                drawn[name].append(value)
    return {
        name: Measured(statistic(evaluation), percentile_interval(drawn[name], level))
        for name, statistic in statistics.items()
    }
