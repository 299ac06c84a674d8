"""`graspcell uq` on files as other tools write them."""

import gzip
import json
import re
from pathlib import Path

import pytest

from tests.experiments.command import command
from tests.maskval import bop_dataset


def arguments(folder: Path, masks: Path, results: Path) -> list[str]:
    paths = ("--dataset", str(folder), "--results", str(results), "--masks", str(masks))
    return ["uq", *paths, "--resamples", "5"]


def test_uq_takes_compressed_detections(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    results, detections = bop_dataset.write(tmp_path)
    plain = command(capsys, *arguments(tmp_path, detections, results))
    compressed = tmp_path / "detections.json.gz"
    compressed.write_bytes(gzip.compress(detections.read_bytes()))
    assert plain.code == 0
    assert command(capsys, *arguments(tmp_path, compressed, results)) == plain


def test_uq_says_in_one_line_that_rotations_of_a_file_are_inexact(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    results, detections = bop_dataset.write(tmp_path)
    path = tmp_path / "test" / f"{bop_dataset.SCENE:06d}" / "scene_gt.json"
    images = json.loads(path.read_text())
    for first, *_ in images.values():
        first["cam_R_m2c"][0] += 0.004
    path.write_text(json.dumps(images))
    told = command(capsys, *arguments(tmp_path, detections, results))
    assert told.code == 0
    words = (
        rf"graspcell: warning: {path}: {bop_dataset.IMAGES} of {2 * bop_dataset.IMAGES} rotations are off by more than "
        r"0.001, by up to 0.00\d+; the nearest rotations are taken\n"
    )
    assert re.fullmatch(words, told.err)
