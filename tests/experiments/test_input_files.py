"""What a command reads must be a regular file of a bounded size: a device fills the memory, a pipe never answers."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from experiments.results.store import SCHEMAS
from tests.experiments.command import command
from tests.maskval import bop_dataset

UQ = ("uq", "--dataset", "bop", "--results", "bop/ours_small-test.csv", "--masks", "bop/detections.json")
REPLAY = ("--object", "handle", "--method", "maskval", "--estimator", "replay", "--recorded")

# The arguments, and the file among those that they lead to that is not what it should be.
READERS: dict[str, tuple[tuple[str, ...], str]] = {
    "compare --gap": (("compare", "--gap", "x.json"), "x.json"),
    "run --gap": (("run", "--gap", "x.json"), "x.json"),
    "compare --thresholds": (("compare", "--thresholds", "x.toml"), "x.toml"),
    "compare --objects": (("compare", "--objects", "x.toml"), "x.toml"),
    "compare --config": (("compare", "--config", "x.toml"), "x.toml"),
    "calibrate --targets": (("calibrate", "--targets", "x.toml"), "x.toml"),
    "calibrate --start": (("calibrate", "--start", "x.toml"), "x.toml"),
    "gap --targets": (("gap", "--part", "handle", "--targets", "x.toml"), "x.toml"),
    "part": (("part", "x.stl"), "x.stl"),
    "uq --results": (UQ, "bop/ours_small-test.csv"),
    "uq --masks": (UQ, "bop/detections.json"),
    "uq, models_info.json": (UQ, "bop/models/models_info.json"),
    "uq, a model": (UQ, "bop/models/obj_000001.ply"),
    "uq, scene_camera.json": (UQ, "bop/test/000002/scene_camera.json"),
    "uq, scene_gt.json": (UQ, "bop/test/000002/scene_gt.json"),
    "uq, a mask": ((*UQ[:-1], "mask_visib"), "bop/test/000002/mask_visib/000000_000000.png"),
    "recorded frames": (("compare", *REPLAY, "logs"), "logs/frames.parquet"),
    "recorded estimates": (("compare", *REPLAY, "logs"), "logs/estimates.parquet"),
    "recorded masks": (("compare", *REPLAY, "bops"), "bops/masks.json"),
    "recorded poses": (("compare", *REPLAY, "bops"), "bops/poses.csv"),
    "query, what was asked for": (("query", "logs", "select 1"), "logs/run.json"),
    "query, a table": (("query", "logs", "select 1"), "logs/attempts.parquet"),
    "report": (("report", "logs"), "logs/run.json"),
    "plan": (("plan", "logs", "ap(maskval) >= 0.5"), "logs/run.json"),
}


def pipe(path: Path) -> str:
    os.mkfifo(path)
    return "expected a regular file, got a pipe"


def device(path: Path) -> str:
    path.symlink_to("/dev/zero")
    return "expected a regular file, got a device"


def folder(path: Path) -> str:
    path.mkdir()
    return "expected a regular file, got a folder"


def too_large(path: Path) -> str:
    """A file that takes no room on the disk and a TiB of memory."""
    path.touch()
    os.truncate(path, 2**40)
    return "bytes, got 1099511627776"


SPOILT = [
    (reader, spoil)
    for reader in READERS
    for spoil in (pipe, device, folder, too_large)
    if (reader, spoil) != ("query, a table", too_large)  # which is read batch by batch
]


@pytest.fixture(scope="module")
def templates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data set, a folder of empty logs, and a recording without masks in BOP's files."""
    here = tmp_path_factory.mktemp("inputs")
    bop_dataset.write(here / "bop")
    (here / "logs").mkdir()
    for name, schema in SCHEMAS.items():
        pq.write_table(schema.empty_table(), here / "logs" / f"{name}.parquet")
    (here / "bops").mkdir()
    (here / "bops" / "masks.json").write_text("[]")
    (here / "bops" / "poses.csv").write_text("scene_id,im_id,obj_id,score,R,t,time\n")
    return here


@pytest.mark.parametrize(("reader", "spoil"), SPOILT, ids=[f"{reader}: {spoil.__name__}" for reader, spoil in SPOILT])
def test_what_is_no_file_of_a_sensible_size_is_refused_in_one_line_before_it_is_read(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    templates: Path,
    monkeypatch: pytest.MonkeyPatch,
    reader: str,
    spoil: Callable[[Path], str],
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments, name = READERS[reader]
    if "/" in name:
        copied = name.partition("/")[0]
        shutil.copytree(templates / copied, tmp_path / copied)
    (tmp_path / name).unlink(missing_ok=True)
    words = spoil(tmp_path / name)
    told = command(capsys, *arguments)
    assert (told.code, told.out.replace("reading x.stl ...\n", ""), told.err.count("\n")) == (2, "", 1)
    assert name in told.err
    assert words in told.err
