"""Where `graspcell uq` writes what it found, and its pictures."""

import contextlib
import csv
import json
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from experiments.observing.drawing import DARK
from experiments.uq.pictures import panels, write_pictures
from maskval import Pose, bop
from tests.experiments.command import command
from tests.maskval import bop_dataset
from tests.maskval.bop_dataset import CUBE, IMAGES, SCENE, X_CUBE

ORANGE, CYAN, GREEN = (255, 140, 26), (40, 220, 255), (60, 176, 96)


@pytest.fixture
def arguments(tmp_path: Path) -> list[str]:
    results, detections = bop_dataset.write(tmp_path)
    fast = ("--resamples", "5")
    return ["uq", "--dataset", str(tmp_path), "--results", str(results), "--masks", str(detections), *fast]


def test_the_table_goes_to_a_file_and_nothing_to_stdout(arguments, capsys, tmp_path) -> None:
    printed = command(capsys, *arguments)
    told = command(capsys, *arguments, "--out", tmp_path / "made" / "poses.csv")
    assert (told.code, told.out, told.err) == (0, "", printed.err)
    assert (tmp_path / "made" / "poses.csv").read_text() == printed.out


def test_json_holds_poses_warnings_and_summary(arguments, capsys) -> None:
    rows = list(csv.DictReader(command(capsys, *arguments).out.splitlines()))
    told = command(capsys, *arguments, "--json")
    whole = json.loads(told.out)
    assert [*whole] == ["poses", "warnings", "summary"]
    assert [{name: float(value) for name, value in row.items()} for row in rows] == whole["poses"]
    assert whole["warnings"] == []
    assert (whole["summary"]["poses"], whole["summary"]["auroc"]["value"]) == (2 * IMAGES, 1)
    assert [one["rule"] for one in whole["summary"]["thresholds"]] == ["all poses", "paper", "certified", "conformal"]
    assert [one["u_T"]["value"] for one in whole["summary"]["thresholds"]][::2] == [1, None]


def test_a_pose_without_a_mask_has_none_in_json(arguments, capsys, tmp_path) -> None:
    path = tmp_path / "detections.json"
    path.write_text(json.dumps(json.loads(path.read_text())[1:]))  # without the first star
    told = command(capsys, *arguments, "--json")
    assert [pose["mask"] for pose in json.loads(told.out)["poses"]].count(None) == 1


def test_a_file_that_cannot_be_written_leaves_none(arguments, capsys, tmp_path) -> None:
    (tmp_path / "poses.csv").mkdir()
    told = command(capsys, *arguments, "--out", tmp_path / "poses.csv")
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert f"cannot write {tmp_path / 'poses.csv'}: " in told.err


def test_a_reader_that_has_seen_enough_ends_uq_without_a_traceback(arguments, monkeypatch) -> None:
    from experiments.cli import main  # noqa: PLC0415

    monkeypatch.setattr("sys.stdout.write", broken, raising=True)
    monkeypatch.setattr("os.dup2", lambda *_: None)
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 141


def broken(_: str) -> int:
    raise BrokenPipeError


def judged_and_masks(folder: Path) -> Iterator[object]:
    results, detections = bop_dataset.write(folder)
    dataset, source = bop.Dataset(folder), bop.DetectedMasks(bop.read_detections(detections))
    return iter((dataset, bop.judge_results(dataset, bop.read_results(results), source), source))


def near(image: np.ndarray, color: tuple[int, int, int]) -> np.ndarray:
    return (np.abs(image.astype(int) - color) <= 8).all(axis=2)


def test_pictures_are_of_the_worst_the_median_and_the_best_pose(tmp_path) -> None:
    dataset, judged, source = judged_and_masks(tmp_path / "set")
    (tmp_path / "made").mkdir()
    assert write_pictures(tmp_path / "made", dataset, judged, source, 0.5) == ["worst.png", "median.png", "best.png"]
    order = sorted(judged, key=lambda pose: pose.u)
    for name, pose in (("best", order[0]), ("median", order[9]), ("worst", order[-1])):
        drawn = cv2.cvtColor(cv2.imread(str(tmp_path / "made" / f"{name}.png")), cv2.COLOR_BGR2RGB)
        assert drawn.shape == (394, 3 * 480, 3)
        np.testing.assert_array_equal(drawn, panels(dataset, pose, source, 0.5))
    assert order[-1].result.im_id == IMAGES - 1


def test_panels_show_the_detection_the_projection_and_what_they_share(tmp_path) -> None:
    dataset, judged, source = judged_and_masks(tmp_path)
    worst = panels(dataset, judged[2 * IMAGES - 2], source, 0.5)
    detection, projection, overlap = np.split(worst, 3, axis=1)
    assert near(detection, ORANGE).any()
    assert not near(detection, CYAN).any()
    assert near(projection, CYAN).any()
    assert not near(projection, ORANGE).any()
    assert all(near(overlap, color).any() for color in (ORANGE, CYAN, GREEN))
    best = np.split(panels(dataset, judged[0], source, 0.5), 3, axis=1)[2]
    assert near(best, GREEN).any()
    assert not near(best, ORANGE).any()


def test_panels_lie_over_the_picture_and_show_what_is_outside_of_it(tmp_path) -> None:
    dataset, _, source = judged_and_masks(tmp_path)
    photo = tmp_path / "test" / f"{SCENE:06d}" / "rgb" / "000000.png"
    photo.parent.mkdir()
    cv2.imwrite(str(photo), np.full((240, 320, 3), (10, 200, 90), dtype=np.uint8))
    aside = bop.PoseResult(SCENE, 0, CUBE, 0.5, Pose.from_translation((-0.25, 0, 0)) @ X_CUBE)
    (pose,) = bop.judge_results(dataset, [aside], source, check=False)
    drawn = panels(dataset, pose, source, 0.5)
    assert pose.v < 0.6
    assert near(drawn, (90, 200, 10)).any()
    assert near(drawn[40:], DARK)[:, :400].sum() > 2000  # beyond the picture's left border
    assert near(drawn[:, 480:960], CYAN).any()


def test_the_masks_of_a_pose_without_one_are_empty(tmp_path) -> None:
    dataset, _, source = judged_and_masks(tmp_path)
    twice = [bop.PoseResult(SCENE, 0, CUBE, 0.5, X) for X in (X_CUBE, Pose.from_translation((0.2, 0, 0)) @ X_CUBE)]
    _, alone = bop.judge_results(dataset, twice, source)
    assert not near(panels(dataset, alone, source, 0.5), ORANGE).any()


def test_uq_says_where_the_pictures_are(arguments, capsys, tmp_path) -> None:
    told = command(capsys, *arguments, "--pictures", tmp_path / "seen")
    assert told.code == 0
    assert f"pictures in {tmp_path / 'seen'}: worst.png, median.png, best.png\n" in told.err
    assert len(list((tmp_path / "seen").iterdir())) == 3


def test_progress_is_shown_on_a_terminal(arguments, capsys, monkeypatch) -> None:
    monkeypatch.setattr("experiments.uq.command.bar", counted_bar)
    _counted.clear()
    assert command(capsys, *arguments).code == 0
    assert _counted == {"pose": 2 * IMAGES, "sample": 5}


_counted: dict[str, int] = {}


@contextlib.contextmanager
def counted_bar(unit: str, what: str, total: int) -> Iterator[object]:
    assert what

    class Bar:
        def set_description(self, text: str) -> None:
            assert text

        def update(self, count: int) -> None:
            _counted[unit] = _counted.get(unit, 0) + count

    yield Bar()
    assert _counted[unit] == total
