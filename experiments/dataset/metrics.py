"""The paper's figures of uncertainty methods on a judged set: Spearman, AUC AR and u_tg, and their curves."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from experiments.dataset.batch import Judged
from experiments.dataset.rules import Range, Rules
from maskval import Evaluation, ImageErrors, RecallCurve, match_images, recall_curve, spearman
from maskval.evaluation.metrics import MAXIMUM_ERROR_M
from maskval.methods.ensemble import ENSEMBLE_MAXIMUM_M

ERROR_THRESHOLD = 15  # index of the paper's e_t for its robot, 15 mm
ERRORS_M = np.linspace(0.0, MAXIMUM_ERROR_M, 31)

Array = NDArray[np.float64]


class Figures(NamedTuple):
    """What a method is worth; None where it is undefined, or no threshold reaches the AP."""

    spearman: float | None
    auc_ar: float | None
    u_tg: float | None


def least_disagreement(judged: Judged) -> float | None:
    """Where Ensemble-ADD's scale begins: the set's least ADD between S1 and S2, m; None without poses."""
    return float(judged.disagreement_m.min()) if len(judged.disagreement_m) else None


def from_least(disagreement_m: Array) -> Array:
    """Ensemble-ADD's u of all poses of a set, (N,): its scale begins at the set's least disagreement."""
    low = disagreement_m.min() if len(disagreement_m) else 0.0
    scaled: Array = np.clip((disagreement_m - low) / (ENSEMBLE_MAXIMUM_M - low), 0.0, 1.0)
    return scaled


def evaluations(judged: Judged, rules: Rules) -> dict[str, Evaluation]:
    """The poses with the uncertainty of each method of the set; the scale of Ensemble-ADD begins as the rules say."""
    base, u = _matched(judged, rules), dict(judged.u)
    if "ensemble-add" in u and rules.ensemble_minimum == "least":
        u["ensemble-add"] = from_least(judged.disagreement_m)
    return {method: replace(base, u=values) for method, values in u.items()}


def figures(evaluation: Evaluation, rules: Rules) -> Figures:
    """Spearman, AUC AR and u_tg of a method."""
    owned = np.isfinite(evaluation.errors_m)
    found = curves(evaluation, rules)
    reached = np.array([u is not None for u in found.u])
    return Figures(
        spearman(evaluation.u[owned], evaluation.errors_m[owned]),
        float(area(found.ar, reached, rules.auc_range)),
        found.u[ERROR_THRESHOLD],
    )


def least_error_threshold(evaluation: Evaluation) -> float | None:
    """The u that sorts the poses at the paper's e_t with the fewest errors: wrong ones kept, right ones not kept.

    Of equally good ones the least. For methods that reach the demanded AP at no threshold; None without right poses.
    """
    order = np.argsort(evaluation.u, kind="stable")
    u, good = evaluation.u[order], evaluation.errors_m[order] <= ERRORS_M[ERROR_THRESHOLD]
    if not good.any():
        return None
    saved = np.cumsum(np.where(good, 1, -1))  # errors fewer than if nothing were kept
    saved[:-1][np.diff(u) == 0] = saved.min() - 1  # poses of equal u are kept together
    return float(u[np.argmax(saved)])


def curves(evaluation: Evaluation, rules: Rules) -> RecallCurve:
    """AR and ARU at the threshold that reaches the AP, and AR* of all poses, over the error thresholds `ERRORS_M`."""
    return recall_curve(evaluation, ERRORS_M, counting=rules.counting, choice=rules.threshold)


def area(ar: Array, reached: NDArray[np.bool_], over: Range) -> Array:
    """Area under AR, (..., 31), as a share of the range of error thresholds, in [0, 1]."""
    whole = np.trapezoid(ar, ERRORS_M)
    if over == "whole":
        return np.asarray(whole / np.ptp(ERRORS_M))
    # Before the first that is reached, AR is 0, but for the rise to it.
    first = np.minimum(np.argmax(reached, axis=-1), len(ERRORS_M) - 2)
    rise = np.where(first > 0, np.take_along_axis(ar, first[..., None], axis=-1)[..., 0] * ERRORS_M[1] / 2, 0.0)
    return np.asarray(np.where(reached.any(axis=-1), (whole - rise) / (ERRORS_M[-1] - ERRORS_M[first]), 0.0))


def _matched(judged: Judged, rules: Rules) -> Evaluation:
    """The set without uncertainties: a pose can belong to the part that its mask shows, and to no other."""
    visibility = judged.visibility if rules.visibility == "total" else judged.in_view
    poses, parts = np.cumsum(judged.poses)[:-1], np.cumsum(judged.parts)[:-1]
    images = []
    for part, mdd_m, visible in zip(
        np.split(judged.pose_part, poses), np.split(judged.mdd_m, poses), np.split(visibility, parts), strict=True
    ):
        table = np.full((len(part), len(visible)), np.inf)
        shown = np.flatnonzero(part >= 0)
        table[shown, part[shown]] = mdd_m[shown]
        images.append(ImageErrors(table, np.zeros(len(part)), visible))
    return match_images(images)
