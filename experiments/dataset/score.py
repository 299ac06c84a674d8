"""All figures of one part's set of test images, with bootstrap intervals over its images."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.dataset.batch import Judged
from experiments.dataset.bootstrap import draw_weights, resample
from experiments.dataset.coco import MaskFigures, Matches, mask_figures
from experiments.dataset.metrics import (
    ERROR_THRESHOLD,
    ERRORS_M,
    Figures,
    curves,
    evaluations,
    figures,
    least_disagreement,
    least_error_threshold,
)
from experiments.dataset.rules import ALTERNATIVES, Rules
from maskval import Measured, RecallCurve, rates
from maskval.statistics.intervals import percentile_interval

LEVEL = 0.95
PAPERS_METHODS = ("ensemble-add", "maskval")
_QUANTILES = np.linspace(0.0, 1.0, 101)

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Scored:
    """The figures of one part's set.

    Attributes:
        object: name of the part.
        images: how many.
        parts: how many.
        poses: how many.
        mask: the detector's figures, by name.
        methods: each method's figures, by method and name.
        curves: each method's curves.
        unfiltered: AP and AR of all poses at the paper's e_t for its robot.
        median_mdd_m: median error of the poses that show a part, m.
        mdd_m: their errors, (M,).
        least_disagreement_m: least ADD between S1 and S2, m; None without poses.
        least_error_u: by method, the threshold that sorts right and wrong poses with the fewest errors; None without
            right ones.
    """

    object: str
    images: int
    parts: int
    poses: int
    mask: dict[str, Measured]
    methods: dict[str, dict[str, Measured]]
    curves: dict[str, RecallCurve]
    unfiltered: tuple[float | None, float | None]
    median_mdd_m: Measured
    mdd_m: Array
    least_disagreement_m: float | None
    least_error_u: dict[str, float | None]

    def as_json(self) -> dict[str, Any]:
        """The set's entry in dataset.json."""
        any_curve = next(iter(self.curves.values()))
        return {
            "object": self.object,
            "images": self.images,
            "parts": self.parts,
            "poses": self.poses,
            "mask": _rows(self.mask),
            "methods": {method: _rows(row) for method, row in self.methods.items()},
            "unfiltered": {"e_t_m": ERRORS_M[ERROR_THRESHOLD], "ap": self.unfiltered[0], "ar": self.unfiltered[1]},
            "median_mdd_m": self.median_mdd_m.value,
            "median_mdd_m_ci": self.median_mdd_m.interval,
            "ensemble_add_minimum_m": self.least_disagreement_m,
            "least_error_u": self.least_error_u,
            "curves": {
                "e_t_m": ERRORS_M.tolist(),
                "ar_star": any_curve.ar_star.tolist(),
                **{
                    method: {"u": one.u, "ar": one.ar.tolist(), "aru": one.aru.tolist()}
                    for method, one in self.curves.items()
                },
                "mdd_m_percentiles": np.quantile(self.mdd_m, _QUANTILES).tolist() if len(self.mdd_m) else None,
            },
        }


def score(name: str, judged: Judged, matches: Matches, rules: Rules, *, seed: int, resamples: int) -> Scored:
    """All figures of a set; its intervals come from the same bootstrap samples.

    Args:
        name: The part's.
        judged: Poses and parts.
        matches: The detector's masks.
        rules: How poses are counted.
        seed: Root of the samples' random numbers.
        resamples: How many samples.
    """
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    weights = draw_weights(len(judged.poses), resamples, rng)
    sets = evaluations(judged, rules)
    any_set = next(iter(sets.values()))
    owned = np.isfinite(any_set.errors_m)
    mdd_m, image = any_set.errors_m[owned], any_set.pose_image[owned]
    everything = rates(any_set, float(ERRORS_M[ERROR_THRESHOLD]), counting=rules.counting)
    return Scored(
        object=name,
        images=len(judged.poses),
        parts=len(judged.visibility),
        poses=len(judged.mdd_m),
        mask=_measured(mask_figures(matches), (mask_figures(matches, row) for row in weights)),
        methods={method: _measured(figures(one, rules), resample(one, rules, weights)) for method, one in sets.items()},
        curves={method: curves(one, rules) for method, one in sets.items()},
        unfiltered=(everything.ap, everything.ar),
        median_mdd_m=Measured(_median(mdd_m), _interval(_median(np.repeat(mdd_m, row[image])) for row in weights)),
        mdd_m=mdd_m,
        least_disagreement_m=least_disagreement(judged),
        least_error_u={method: least_error_threshold(one) for method, one in sets.items()},
    )


def alternatives(judged: Judged) -> dict[str, dict[str, Figures]]:
    """The figures of the paper's two methods by every rule of `ALTERNATIVES`, by rule and method."""
    found = {}
    for name, rules in ALTERNATIVES.items():
        sets = evaluations(judged, rules)
        found[name] = {method: figures(one, rules) for method, one in sets.items() if method in PAPERS_METHODS}
    return found


def _measured(values: Figures | MaskFigures, samples: Iterable[Figures | MaskFigures]) -> dict[str, Measured]:
    """Each figure with its interval, by name."""
    drawn = list(samples)
    return {
        name: Measured(value, _interval(getattr(one, name) for one in drawn))
        for name, value in values._asdict().items()
    }


def _interval(samples: Iterable[float | None]) -> tuple[float, float] | None:
    """The percentile interval of the samples in which a figure is defined; None of fewer than 40."""
    defined = [value for value in samples if value is not None]
    return percentile_interval(defined, LEVEL)


def _median(values: Array) -> float | None:
    return float(np.median(values)) if len(values) else None


def _rows(measured: dict[str, Measured]) -> dict[str, Any]:
    return {
        key: value for name, one in measured.items() for key, value in ((name, one.value), (f"{name}_ci", one.interval))
    }
