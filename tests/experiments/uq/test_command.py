"""`graspcell uq` on a small data set, whole and spoilt in the ways that files are."""

import csv
import gzip
import json
import re

import numpy as np
import pytest

from maskval import bop
from tests.experiments.command import command
from tests.maskval import bop_dataset
from tests.maskval.bop_dataset import IMAGES, SHIFTS_M


@pytest.fixture
def arguments(tmp_path):
    results, detections = bop_dataset.write(tmp_path)
    fast = ("--resamples", "5")
    return ["uq", "--dataset", str(tmp_path), "--results", str(results), "--masks", str(detections), *fast]


def run(arguments, capsys) -> tuple[int, str, str]:
    told = command(capsys, *arguments)
    return told.code, told.out, told.err


def test_uq_prints_u_of_every_pose_and_the_summary(arguments, capsys) -> None:
    code, out, err = run(arguments, capsys)
    assert code == 0
    rows, summary = list(csv.DictReader(out.splitlines())), err
    assert len(rows) == 2 * IMAGES
    assert [int(row["im_id"]) for row in rows] == np.repeat(np.arange(IMAGES), 2).tolist()
    u = [float(row["u"]) for row in rows[::2]]
    assert u[0] == 0
    assert all(np.diff(u) > 0)
    # 6 of 10 cubes are off by at most 15 mm, and all stars are right; u tells them apart.
    assert sum(shift <= 0.015 for shift in SHIFTS_M) == 6
    assert summary.startswith("20 poses of 20 parts in 10 images; good is an error of at most 15 mm")
    lines = {line.split()[0]: line.split() for line in summary.splitlines()}
    assert float(lines["AUROC"][1]) == 1
    assert lines["all"][2] == "inf"
    assert float(lines["paper"][1]) == pytest.approx(u[5], rel=1e-3)
    assert lines["certified"] == ["certified", "abstains"]


def test_uq_takes_the_data_sets_own_masks(arguments, capsys) -> None:
    with_detections = run(arguments, capsys)
    arguments[arguments.index("--masks") + 1] = "mask_visib"
    assert run(arguments, capsys) == with_detections


def test_uq_takes_compressed_detections(arguments, capsys, tmp_path) -> None:
    plain = run(arguments, capsys)
    compressed = tmp_path / "detections.json.gz"
    compressed.write_bytes(gzip.compress((tmp_path / "detections.json").read_bytes()))
    arguments[arguments.index("--masks") + 1] = str(compressed)
    assert plain[0] == 0
    assert run(arguments, capsys) == plain


def test_uq_says_in_one_line_that_rotations_of_a_file_are_inexact(arguments, capsys, tmp_path) -> None:
    path = tmp_path / "test" / f"{bop_dataset.SCENE:06d}" / "scene_gt.json"
    images = json.loads(path.read_text())
    for first, *_ in images.values():
        first["cam_R_m2c"][0] += 0.004
    path.write_text(json.dumps(images))
    code, out, err = run(arguments, capsys)
    assert code == 0
    words = (
        rf"graspcell: warning: {path}: {IMAGES} of {2 * IMAGES} rotations are off by more than "
        r"0.001, by up to 0.00\d+; the nearest rotations are taken\n"
    )
    first, rest = err.split("\n", 1)
    assert re.fullmatch(words, first + "\n")
    assert rest.startswith("20 poses of 20 parts")
    assert rest.endswith("\n1 warning, see above\n")
    assert run([*arguments, "--strict"], capsys) == (3, out, err)


def test_uq_without_true_poses_prints_uncertainties_only(arguments, capsys, tmp_path) -> None:
    for name in ("scene_gt.json", "scene_gt_info.json"):
        (tmp_path / "test" / "000002" / name).unlink()
    (tmp_path / "test_targets_bop19.json").unlink()
    code, out, err = run(arguments, capsys)
    assert code == 0
    assert len(out.splitlines()) == 1 + 2 * IMAGES
    assert err == "no true poses in the data set: uncertainties only\n"


def replaced(path, old, new) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("name", "old", "new", "words"),
    [
        ("ours_small-test.csv", "2,0,1,0.5", "2,0,1", "csv:2:1: expected the 7 fields .*, but found 6"),
        ("ours_small-test.csv", "2,0,1,0.5", "2,zero,1,0.5", "csv:2:3: expected im_id as a whole number, .* 'zero'"),
        ("ours_small-test.csv", "2,0,1,0.5,", "2,0,1,0.5,1 ", r"csv:2:11: expected R as 9 finite numbers"),
        ("ours_small-test.csv", "2,0,1,0.5,0", "2,0,1,0.5,5", r"csv:2:11: expected a rotation to 0.01,"),
        ("ours_small-test.csv", "2,0,1", "7,0,1", "expected masks of the scene 7, .* found none"),
        ("ours_small-test.csv", "2,0,1", "2,77,1", "expected the image 77, .* found 10 others"),
        ("ours_small-test.csv", "2,0,1", "2,0,9", "obj_000009.ply"),
        ("detections.json", '"counts": [', '"counts": [1, ', r"detections.json:2:\d+: \[0\]: .*counts must add up"),
        ("detections.json", "[\n", "[[\n", r"detections.json:\d+:\d+: expected JSON"),
        ("models/obj_000001.ply", "ply", "off", "obj_000001.ply:1:1: expected"),
        ("models/models_info.json", '"5"', '"6"', "models_info.json: expected the object 5"),
        ("test/000002/scene_camera.json", "300.0", "-300.0", "scene_camera.json:2:18: 0: cam_K: fx must be > 0"),
        ("test/000002/scene_camera.json", "[300.0, 0.0", "[300.0, 1e400", "finite"),
        ("test/000002/scene_gt.json", "cam_R_m2c", "cam_R", "expected the field 'cam_R_m2c'"),
        ("test/000002/scene_gt_info.json", '"visib_fract": 1.0', '"visib_fract": 1.5', r"a share in \[0, 1\]"),
        ("test_targets_bop19.json", '"im_id": 0', '"im_id": 99', "expected the parts of image 99"),
    ],
)
def test_a_malformed_file_ends_uq_with_one_line_and_code_2(arguments, capsys, tmp_path, name, old, new, words) -> None:
    replaced(tmp_path / name, old, new)
    code, out, err = run(arguments, capsys)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert re.search(words, err), err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"--dataset": "nowhere"}, "models is no folder: expected a data set in BOP's layout"),
        ({"--results": "nowhere.csv"}, "nowhere.csv"),
        ({"--masks": "nowhere.json"}, "nowhere.json"),
        ({"--masks": "masks.txt"}, "expected --masks as a .json or .json.gz file, mask_visib or mask, got masks.txt"),
        ({"--alpha": "1.5"}, "expected --alpha in 0..1, got 1.5"),
        ({"--pixel-center": "1"}, "expected --pixel-center of at least 0 and below 1, got 1"),
        ({"--demanded-ap": "1"}, "expected --demanded-ap above 0 and below 1, got 1"),
        ({"--error-threshold-mm": "nan"}, "expected --error-threshold-mm above 0 and at most 10000, got nan"),
        ({"--error-threshold-mm": "1e300"}, "expected --error-threshold-mm above 0 and at most 10000, got 1e+300"),
        ({"--resamples": "0"}, "expected --resamples of 1 to 100000, got 0"),
        ({"--resamples": "1000000000"}, "expected --resamples of 1 to 100000, got 1e+09"),
        ({"--seed": "-1"}, "expected --seed of at least 0 and below 2^63, got -1"),
        ({"--seed": str(2**63)}, "expected --seed of at least 0 and below 2^63, got 9.2"),
        ({"--alpha": "nan"}, "expected --alpha in 0..1, got nan"),
        ({"--out": "poses.txt"}, "expected --out as a .csv file, got 'poses.txt'"),
        ({"--out": ""}, "expected a value after '--out', got an empty text"),
        ({"--out": "/dev/null/poses.csv"}, "cannot write to /dev/null: "),
        ({"--pictures": "/dev/null"}, "cannot write to /dev/null: "),
    ],
)
def test_a_wrong_argument_ends_uq_with_one_line_and_code_2(arguments, capsys, change, words) -> None:
    given = dict(zip(arguments[1::2], arguments[2::2], strict=True)) | change
    code, out, err = run(["uq", *(word for pair in given.items() for word in pair)], capsys)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert words in err


def test_a_mask_that_is_no_mask_is_refused(arguments, capsys, tmp_path) -> None:
    arguments[arguments.index("--masks") + 1] = "mask_visib"
    path = bop.mask_path(tmp_path / "test" / "000002", 0, 0)
    path.write_text("no image")
    code, out, err = run(arguments, capsys)
    assert (code, out) == (2, "")
    assert "000000_000000.png: expected an image" in err
