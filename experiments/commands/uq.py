"""`graspcell uq`: the uncertainty of every pose of a BOP submission, and how good it is."""

import math
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from experiments.errors import UsageError
from experiments.progress import saying
from maskval import UNMATCHED, InexactRotationWarning, MaskvalError, Summary, bop, summarise
from maskval.input_files import MOST_RESULTS, check_input

_HEADER = "scene_id,im_id,obj_id,score,mask,c,v,u"


@dataclass(frozen=True)
class Uq:
    """Print MaskVal's uncertainty of every pose of a BOP submission, and how good it is if true poses are known.

    Reads only a data set in BOP's layout: it works for any detector and pose estimator, without the cell.
    """

    dataset: Path
    """Folder in BOP's layout: models/ and the split's scenes."""
    results: Path
    """The poses: a results file of BOP, .csv."""
    masks: str
    """Detections with masks, .json or .json.gz (BOP's results of 2022, COCO run lengths); or the data set's own masks:
    mask_visib, or mask."""
    split: str = "test"
    """Folder of the scenes in the data set."""
    association: Literal["greedy", "optimal", "known"] = "greedy"
    """How poses find their masks: greedy, optimal (Hungarian), or known: in the order of the files."""
    alpha: float = 0.8
    """Visibility below which the certainty is lowered by the visibility, 0 to 1."""
    pixel_center: float = 0.5
    """Where pixel i of the masks is sampled: i + 0.5 for BOP's and OpenGL's, i + 0 for OpenCV's."""
    canvas: Literal["full", "3x3"] = "full"
    """Where the whole silhouette is counted for the visibility: all of it, or BOP's 3 x 3 images."""
    error: Literal["mssd", "mdd", "add", "add-s"] = "mssd"
    """The error of a pose; mssd is the mdd where an object has no symmetries."""
    error_threshold_mm: float = 15.0
    """Greatest error of a good pose, mm."""
    demanded_ap: float = 0.99
    """AP that the thresholds are to reach, above 0 and below 1."""
    seed: int = 0
    """Root of the random numbers of the intervals."""
    resamples: int = 200
    """Bootstrap samples of the 95 % intervals. Fewer than 40 give no interval."""


def uq(config: Uq) -> int:
    """Prints a line for each pose and then the summary; returns the exit code.

    Raises:
        UsageError: an invalid argument or file.
    """
    _check(config)
    with warnings.catch_warnings(record=True) as told, saying("judge the poses"):
        warnings.simplefilter("always", InexactRotationWarning)
        judged, summary = _judge(config)
    for warning in told:
        print(f"graspcell: warning: {warning.message}", file=sys.stderr)
    print(_HEADER)
    for pose in judged:
        result = pose.result
        mask = "" if pose.mask == UNMATCHED else str(pose.mask)
        ids = f"{result.scene_id},{result.im_id},{result.obj_id},{result.score:g}"
        print(f"{ids},{mask},{pose.c:.6f},{pose.v:.6f},{pose.u:.6f}")
    print()
    print("no true poses in the data set: uncertainties only" if summary is None else summary)
    return 0


def _judge(config: Uq) -> tuple[list[bop.JudgedPose], Summary | None]:
    try:
        dataset = bop.Dataset(config.dataset, config.split)
        judged = bop.judge_results(
            dataset,
            bop.read_results(check_input(config.results, MOST_RESULTS)),
            _masks(config, dataset),
            association=config.association,
            alpha=config.alpha,
            pixel_center=config.pixel_center,
            canvas=config.canvas,
        )
        # Evaluate before anything is printed: a broken file gives one line of error and nothing else.
        return judged, _summary(config, dataset, judged)
    except (MaskvalError, OSError) as error:
        raise UsageError(str(error)) from error


def _summary(config: Uq, dataset: bop.Dataset, judged: Sequence[bop.JudgedPose]) -> Summary | None:
    if not dataset.targets():
        return None
    return summarise(
        bop.evaluate_poses(dataset, judged, error=config.error),
        config.error_threshold_mm * 1e-3,
        demanded_ap=config.demanded_ap,
        rng=np.random.default_rng(np.random.SeedSequence((config.seed,))),
        resamples=config.resamples,
    )


def _masks(config: Uq, dataset: bop.Dataset) -> bop.MaskSource:
    if config.masks in ("mask_visib", "mask"):
        return bop.SceneMasks(dataset, visible=config.masks == "mask_visib")
    if not config.masks.endswith((".json", ".json.gz")):
        raise UsageError(f"expected --masks as a .json or .json.gz file, mask_visib or mask, got {config.masks}")
    return bop.DetectedMasks(bop.read_detections(check_input(Path(config.masks), MOST_RESULTS)))


def _check(config: Uq) -> None:
    for name, value, legal, words in (
        ("--alpha", config.alpha, 0 <= config.alpha <= 1, "in 0..1"),
        ("--pixel-center", config.pixel_center, 0 <= config.pixel_center < 1, "of at least 0 and below 1"),
        ("--demanded-ap", config.demanded_ap, 0 < config.demanded_ap < 1, "above 0 and below 1"),
        ("--resamples", config.resamples, config.resamples >= 1, "of at least 1"),
        ("--seed", config.seed, config.seed >= 0, "of at least 0"),
        (
            "--error-threshold-mm",
            config.error_threshold_mm,
            config.error_threshold_mm > 0 and math.isfinite(config.error_threshold_mm),
            "above 0",
        ),
    ):
        if not legal:
            raise UsageError(f"expected {name} {words}, got {value:g}")
