"""`graspcell uq` on poses, masks and data sets that are spoilt as a whole: none is judged as if nothing were wrong."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from maskval import Pose, bop
from tests.experiments.command import Told, command
from tests.maskval import bop_dataset
from tests.maskval.bop_dataset import CAMERA, IMAGES, SCENE, STAR

X_CW = Pose.from_rotvec((2.0, 0.3, -0.4), (0.1, 0.2, 0.9))
IN_SCENE = f"test/{SCENE:06d}"


def judged(capsys: pytest.CaptureFixture[str], folder: Path, *options: str) -> Told:
    fast = ("--resamples", "1", *options)
    results, detections = folder / "ours_small-test.csv", folder / "detections.json"
    return command(capsys, "uq", "--dataset", folder, "--results", results, "--masks", detections, *fast)


def poses(change: Callable[[Pose], Pose]) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        path = folder / "ours_small-test.csv"
        given = bop.read_results(path)
        bop.write_results(path, [bop.PoseResult(r.scene_id, r.im_id, r.obj_id, r.score, change(r.X_CO)) for r in given])

    return spoil


def file(name: str, change: Callable[[object], object]) -> Callable[[Path], None]:
    """Changes what a JSON file holds, in place or by what is returned."""

    def spoil(folder: Path) -> None:
        content = json.loads((folder / name).read_text())
        changed = change(content)
        (folder / name).write_text(json.dumps(content if changed is None else changed))

    return spoil


def world(folder: Path) -> None:
    poses(lambda X: X_CW.inverse() @ X)(folder)
    cameras = {im_id: bop.ImageCamera(CAMERA.K, X_CW=X_CW) for im_id in range(IMAGES)}
    bop.write_scene_camera(folder / IN_SCENE / "scene_camera.json", cameras)


def another_size(height: int, width: int) -> Callable[[Path], None]:
    return lambda folder: (folder / "camera.json").write_text(json.dumps({"height": height, "width": width})) and None


def each(name: str, change: Callable[[dict], object]) -> Callable[[Path], None]:
    return file(name, lambda rows: [change(row) for row in rows] and None)


CERTAIN: list[tuple[str, Callable[[Path], object], str]] = [
    ("metres", poses(lambda X: Pose(X.rotation, X.translation / 1000)), "metres where millimetres are expected"),
    ("world frame", world, "poses are in the world frame"),
    ("inverse", poses(Pose.inverse), "poses are those of the camera in the object"),
    ("behind", poses(lambda X: Pose(X.rotation, X.translation * (1, 1, -1))), "20 of 20 poses lie behind the camera"),
    ("OpenGL", poses(lambda X: Pose(np.diag((1.0, -1, -1)), np.zeros(3)) @ X), "OpenGL's camera axes"),
    ("far aside", poses(lambda X: Pose.from_translation((9, 0, 0)) @ X), "show less than 1 % of their silhouette"),
    ("elsewhere", poses(lambda X: Pose.from_translation((0, 0.2, 0)) @ X), "20 of 20 silhouettes meet no mask"),
    ("another size", another_size(480, 640), r"masks of the image's 480 x 640 \(H x W\), got 240 x 320"),
    ("sizes swapped", another_size(320, 240), "got 240 x 320: height and width are swapped"),
    ("camera.json", another_size(-3, 240), "camera.json:1:12: height: expected a whole number >= 0"),
    (
        "categories",
        each("detections.json", lambda row: row.update(category_id=row["category_id"] + 90)),
        "20 of 20 poses have no mask of their object in their image: do obj_id and category_id",
    ),
    (
        "images",
        each("detections.json", lambda row: row.update(image_id=row["image_id"] + 100)),
        "have no mask of their object in their image: do .* im_id and image_id, agree",
    ),
    (
        "a diameter",
        file("models/models_info.json", lambda models: models[str(STAR)].update(diameter=0.2)),
        "the diameter of object 5 is 0.2 mm, that of its model 199.* mm: another unit or object",
    ),
    (
        "no models_info",
        lambda folder: (folder / "models" / "models_info.json").unlink(),
        "models_info.json does not exist: mssd needs the symmetries in it; mdd, add and add-s need none",
    ),
    (
        "no such object",
        lambda folder: (folder / "models" / f"obj_{STAR:06d}.ply").unlink(),
        "obj_000005.ply does not exist: expected the model of the object 5, got obj_000001.ply",
    ),
    (
        "truth behind",
        file(f"{IN_SCENE}/scene_gt.json", lambda images: images["0"][0].update(cam_t_m2c=[0, 0, -600])),
        "scene_gt.json: scene 2, image 0, object 1: expected a visible part before the camera, got z < 0",
    ),
    (
        "truth twice",
        file(f"{IN_SCENE}/scene_gt.json", lambda images: images["0"].__setitem__(1, images["0"][0])),
        "scene_gt.json: 0: expected each part once, but two have one pose",
    ),
    (
        "no poses",
        lambda folder: (folder / "ours_small-test.csv").write_text("scene_id,im_id,obj_id,score,R,t,time\n"),
        "expected at least one pose, got none",
    ),
    (
        "polygons of no size",
        each("detections.json", lambda row: row.update(segmentation=[[1, 1, 9, 1, 9, 9]])),
        "expected the size of image 0 of scene 2, from camera.json",
    ),
]


@pytest.mark.parametrize(("spoil", "words"), [row[1:] for row in CERTAIN], ids=[row[0] for row in CERTAIN])
def test_what_is_certainly_wrong_ends_uq_with_one_line(capsys, tmp_path, spoil, words) -> None:
    bop_dataset.write(tmp_path)
    spoil(tmp_path)
    told = judged(capsys, tmp_path)
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert told.err.startswith("graspcell: error: ")
    assert re.search(words, told.err), told.err


def one_pose_behind(folder: Path) -> None:
    path = folder / "ours_small-test.csv"
    given = bop.read_results(path)
    bop.write_results(path, [bop.PoseResult(SCENE, 0, STAR, 0.5, Pose.from_translation((0, 0, -0.5))), *given[2:]])


LIKELY: list[tuple[str, Callable[[Path], object], str]] = [
    ("behind", one_pose_behind, "1 of 19 poses lie behind the camera"),
    (
        "a diameter",
        file("models/models_info.json", lambda models: models[str(STAR)].update(diameter=150.0)),
        "the diameter of object 5 is 150 mm",
    ),
    (
        "half without masks",
        file("detections.json", lambda rows: [row for row in rows if row["category_id"] == STAR]),
        "10 of 20 poses have no mask of their object",
    ),
    (
        "scores",
        each("detections.json", lambda row: row.update(score=97.5)),
        "expected scores in 0..1, got 97.5 to 97.5",
    ),
]


@pytest.mark.parametrize(("spoil", "words"), [row[1:] for row in LIKELY], ids=[row[0] for row in LIKELY])
def test_what_is_only_odd_is_a_warning_and_strict_makes_it_a_failure(capsys, tmp_path, spoil, words) -> None:
    bop_dataset.write(tmp_path)
    spoil(tmp_path)
    told, strict = judged(capsys, tmp_path), judged(capsys, tmp_path, "--strict")
    assert (told.code, strict.code) == (0, 3)
    assert words in told.err
    assert told.err.startswith("graspcell: warning: ")
    assert told.err.endswith("1 warning, see above\n")
    assert (strict.out, strict.err) == (told.out, told.err)
    assert words in json.loads(judged(capsys, tmp_path, "--json").out)["warnings"][0]


def test_nothing_is_odd_about_right_poses(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    another_size(240, 320)(tmp_path)
    told = judged(capsys, tmp_path, "--strict")
    assert told.code == 0
    assert "warning" not in told.err


def test_no_check_takes_the_poses_as_they_are(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    poses(lambda X: Pose(X.rotation, X.translation / 1000))(tmp_path)
    told = judged(capsys, tmp_path, "--no-check")
    assert told.code == 0
    assert len(told.out.splitlines()) == 1 + 2 * IMAGES


def test_polygons_are_taken_for_masks(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    another_size(240, 320)(tmp_path)
    box = [[60, 60, 120, 60, 120, 160, 60, 160]]
    each("detections.json", lambda row: row.update(segmentation=box))(tmp_path)
    told = judged(capsys, tmp_path, "--no-check")
    assert told.code == 0
    assert len(told.out.splitlines()) == 1 + 2 * IMAGES


def test_without_models_info_other_errors_are_measured(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    (tmp_path / "models" / "models_info.json").unlink()
    assert judged(capsys, tmp_path, "--error", "add").code == 0
