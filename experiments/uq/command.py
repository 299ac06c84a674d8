"""`graspcell uq`: judges the poses, and says what they are worth."""

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.errors import UsageError
from experiments.progress import bar
from experiments.results.files import write_text
from experiments.setup.checks import FAILED, writable_folder
from experiments.uq.config import Uq
from experiments.uq.tables import csv_of, json_of
from maskval import ImplausibleInputWarning, InexactRotationWarning, MaskvalError, Summary, bop, summarise


def uq(config: Uq) -> int:
    """Judges every pose, and prints or writes what was found; returns the exit code.

    Raises:
        UsageError: an invalid argument or file, or poses that certainly are not what was meant.
    """
    config.check_values()
    if config.out is not None:
        writable_folder(config.out.parent)
    if config.pictures is not None:
        writable_folder(config.pictures)
    with warnings.catch_warnings(record=True) as caught:
        for kind in (InexactRotationWarning, ImplausibleInputWarning):
            warnings.simplefilter("always", kind)
        judged, summary, drawn = _judge(config)
    told = [str(warning.message) for warning in caught]
    table = json_of(judged, summary, told) if config.json else csv_of(judged)
    if config.out is None:
        sys.stdout.write(table)
        sys.stdout.flush()  # before the summary, where both are seen
    else:
        write_text(config.out, table)
    for line in told:
        print(f"graspcell: warning: {line}", file=sys.stderr)
    if drawn:
        print(f"pictures in {config.pictures}: {', '.join(drawn)}", file=sys.stderr)
    print("no true poses in the data set: uncertainties only" if summary is None else summary, file=sys.stderr)
    if told:
        print(f"{len(told)} warning{'s' if len(told) > 1 else ''}, see above", file=sys.stderr)
    return FAILED if config.strict and told else 0


def _judge(config: Uq) -> tuple[list[bop.JudgedPose], Summary | None, list[str]]:
    try:
        dataset = bop.Dataset(config.dataset, config.split)
        results = bop.read_results(config.results)
        if not results:
            raise UsageError(f"{config.results}: expected at least one pose, got none")
        masks = _masks(config, dataset)
        judged = _with_progress(config, dataset, results, masks)
        # Evaluate before anything is printed: a broken file gives one line of error and nothing else.
        return judged, _summary(config, dataset, judged), _pictures(config, dataset, judged, masks)
    except (MaskvalError, OSError) as error:
        raise UsageError(str(error)) from error


def _with_progress(
    config: Uq, dataset: bop.Dataset, results: Sequence[bop.PoseResult], masks: bop.MaskSource
) -> list[bop.JudgedPose]:
    with bar("pose", "loading; compiling at the first use takes some 20 s", len(results)) as shown:

        def advance(count: int) -> None:
            shown.set_description("judging")
            shown.update(count)

        return bop.judge_results(
            dataset,
            results,
            masks,
            association=config.association,
            alpha=config.alpha,
            pixel_center=config.pixel_center,
            canvas=config.canvas,
            check=config.check,
            progress=advance,
        )


def _summary(config: Uq, dataset: bop.Dataset, judged: Sequence[bop.JudgedPose]) -> Summary | None:
    if not dataset.targets():
        return None
    evaluation = bop.evaluate_poses(dataset, judged, error=config.error)
    with bar("sample", "intervals", config.resamples) as shown:
        return summarise(
            evaluation,
            config.error_threshold_mm * 1e-3,
            demanded_ap=config.demanded_ap,
            rng=np.random.default_rng(np.random.SeedSequence((config.seed,))),
            resamples=config.resamples,
            progress=shown.update,
        )


def _pictures(config: Uq, dataset: bop.Dataset, judged: Sequence[bop.JudgedPose], masks: bop.MaskSource) -> list[str]:
    if config.pictures is None:
        return []
    from experiments.uq.pictures import write_pictures  # noqa: PLC0415  # OpenCV takes its time

    return write_pictures(config.pictures, dataset, judged, masks, config.pixel_center)


def _masks(config: Uq, dataset: bop.Dataset) -> bop.MaskSource:
    if config.masks in ("mask_visib", "mask"):
        return bop.SceneMasks(dataset, visible=config.masks == "mask_visib")
    return bop.DetectedMasks(bop.read_detections(Path(config.masks), dataset.image_size))
