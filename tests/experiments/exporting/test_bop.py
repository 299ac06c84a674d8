"""A run as a BOP dataset, read back by the library's own reader and judged by `graspcell uq`."""

import csv
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from cell.layout import Layout
from experiments import load
from experiments.cli import main
from maskval import bop, mdd
from tests.experiments.command import command

METHODS = {"none": "none+always", "maskval": "maskval+threshold"}
Row = dict[str, Any]


def exported(run: Path, out: Path, *options: object) -> None:
    with pytest.raises(SystemExit) as end:
        main(["export", str(run), "--bop", str(out), *map(str, options)])
    assert end.value.code == 0


@pytest.fixture(scope="module")
def folder(small_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("exported") / "bop"
    exported(small_run, out)
    return out


@pytest.fixture
def scenes(folder: Path) -> list[Row]:
    listed: list[Row] = json.loads((folder / "scenes.json").read_text(encoding="utf-8"))
    return listed


def estimates_of(run: Path, scene: Row) -> list[Row]:
    names = ("object", "method", "policy", "experiment")
    rows: list[Row] = load(run).estimates.to_pylist()
    return [row for row in rows if all(row[name] == scene[name] for name in names)]


def test_there_is_a_scene_for_each_experiment_and_an_image_for_each_frame(
    small_run: Path, folder: Path, scenes: list[Row]
) -> None:
    frames = load(small_run).frames.to_pylist()
    dataset = bop.Dataset(folder)
    assert dataset.scene_ids == [scene["scene_id"] for scene in scenes] == [0, 1, 2, 3]
    for scene in scenes:
        of = [
            row["frame"]
            for row in frames
            if (row["method"], row["experiment"]) == (scene["method"], scene["experiment"])
        ]
        assert len(of) > 1
        assert sorted(dataset.scene(scene["scene_id"]).cameras) == of


@pytest.mark.parametrize("method", METHODS)
def test_uq_finds_the_u_of_the_log(
    small_run: Path, folder: Path, scenes: list[Row], capsys: pytest.CaptureFixture[str], method: str
) -> None:
    files = folder / "results" / f"{METHODS[method]}_graspcell-test"
    judge = ("--results", f"{files}.csv", "--masks", f"{files}.json", "--association", "known", "--resamples", 5)
    told = command(capsys, "uq", "--dataset", folder, *judge)
    assert told.code == 0, told.err
    assert "warning" not in told.err
    rows = list(csv.DictReader(told.out.split("\n\n")[0].splitlines()))
    expected = [
        (str(scene["scene_id"]), str(row["frame"]), row)
        for scene in scenes
        if scene["method"] == method
        for row in estimates_of(small_run, scene)
    ]
    assert len(expected) > 3
    for row, (scene_id, frame, estimate) in zip(rows, expected, strict=True):
        assert (row["scene_id"], row["im_id"]) == (scene_id, frame)
        assert float(row["score"]) == pytest.approx(1 - estimate["u"], rel=1e-5)
        if method == "maskval":
            assert row["u"] == f"{estimate['u']:.6f}"


def test_truth_and_results_give_the_errors_and_visibilities_of_the_log(
    small_run: Path, folder: Path, scenes: list[Row]
) -> None:
    dataset = bop.Dataset(folder)
    poses = [
        pose
        for name in METHODS.values()
        for pose in bop.read_results(folder / "results" / f"{name}_graspcell-test.csv")
    ]
    compared = 0
    for scene in scenes:
        own = [pose for pose in poses if pose.scene_id == scene["scene_id"]]
        for pose, row in zip(own, estimates_of(small_run, scene), strict=True):
            if row["true_part"] is not None:
                index = scene["parts"][str(pose.im_id)].index(row["true_part"])
                truth, info = dataset.scene(pose.scene_id).parts(pose.im_id)[index]
                error = mdd(pose.X_CO, truth.X_CO, dataset.mesh(1).vertices)
                assert error == pytest.approx(row["true_mdd_m"], rel=1e-6)
                assert info.visib_fract == pytest.approx(row["true_visibility"], abs=0.01)
                compared += 1
    assert compared > 10


def test_masks_show_what_is_visible_of_each_listed_part(folder: Path, scenes: list[Row]) -> None:
    listed = 0
    for scene in scenes:
        read = bop.Dataset(folder).scene(scene["scene_id"])
        for frame, parts in scene["parts"].items():
            infos = (read.infos or {})[int(frame)]
            assert len(infos) == len(parts)
            for index, info in enumerate(infos):
                mask = bop.read_mask(bop.mask_path(read.folder, int(frame), index))
                assert mask.sum() == info.px_count_visib > 0
                listed += 1
    assert listed > 10


def test_a_part_that_nobody_touches_keeps_its_place_in_the_world(folder: Path, scenes: list[Row]) -> None:
    scene = scenes[2]
    assert (scene["method"], scene["experiment"]) == ("maskval", 0)
    read, places = bop.Dataset(folder).scene(2), []
    for frame in (2, 3, 4, 5):  # after part 0 is placed and before part 1 is grasped
        (part,) = scene["parts"][str(frame)]
        X_CW = read.cameras[frame].X_CW
        assert part == 1
        assert X_CW is not None
        places.append((X_CW.inverse() @ read.parts(frame)[0][0].X_CO).translation)
    assert np.ptp(places, axis=0) == pytest.approx(0, abs=1e-6)


def test_pictures_and_depth_are_of_the_frames(small_run: Path, tmp_path: Path) -> None:
    exported(small_run, tmp_path / "bop", "--methods", "none", "--experiments", 1, "--rgb", "--depth")
    scene, camera = bop.Dataset(tmp_path / "bop").scene(0), Layout().camera
    assert len(scene.cameras) > 1
    for frame in scene.cameras:
        rgb = cv2.imread(str(scene.folder / "rgb" / f"{frame:06d}.png"))
        assert rgb is not None
        assert rgb.shape == (camera.height, camera.width, 3)
        depth = bop.read_depth(scene.folder / "depth" / f"{frame:06d}.png", scene.cameras[frame].depth_scale)
        mask = bop.read_mask(bop.mask_path(scene.folder, frame, 0))
        truth, info = scene.parts(frame)[0]
        z = truth.X_CO.apply(bop.Dataset(tmp_path / "bop").mesh(1).vertices)[:, 2]
        inside = (depth[mask] > z.min() - 1e-3) & (depth[mask] < z.max() + 1e-3)
        assert inside.mean() > 0.98  # at the outline, one renderer's pixel is another one's background
        assert info.px_count_valid >= info.px_count_visib


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "expected --bop DIR or --lerobot DIR, got neither"),
        (["--bop", "a", "--lerobot", "b"], "expected --bop DIR or --lerobot DIR, got both"),
        (["--lerobot", "b", "--depth"], "expected --bop with --depth"),
        (["--lerobot", "b", "--fps", 30], "expected --fps that divides 500, the steps per second, got 30"),
        (["--bop", "full"], "full is not empty: expected a new or empty folder"),
        (["--bop", "a", "--methods", "random"], "0 to 1; got none of what was chosen"),
    ],
)
def test_options_that_cannot_be_are_one_line(
    small_run: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    options: list[object],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    told = command(capsys, "export", small_run, *options)
    assert told.code == 2
    assert words in told.err
    assert told.err.count("\n") == 1
    assert not (tmp_path / "a" / "models").exists()


def test_the_folder_of_run_out_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "export", tmp_path, "--bop", tmp_path / "bop")
    assert (told.code, told.err.count("\n")) == (2, 1)
    assert "expected the folder of a run, as compare writes it, with run.json" in told.err
