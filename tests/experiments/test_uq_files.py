"""`graspcell uq` on files as other tools write them."""

import gzip
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
