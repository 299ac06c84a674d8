"""Rendered pictures with trained networks in place of generated images with simulated ones."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cell.interfaces import Detection, Frame, PoseEstimate
from experiments.dataset import sources
from experiments.dataset.batch import BatchTask, run_batch
from experiments.dataset.sources import PictureSet, poses_alike
from experiments.errors import UsageError
from experiments.rendering.command import render_dataset
from experiments.rendering.config import RenderDataset
from maskval import Correspondences, Pose, bop
from maskval.bop.images import mask_path, read_mask
from sim.model.parts import load_part
from tests.experiments.command import command


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures") / "handle"
    config = RenderDataset(style="s2", object="handle", images=3, samples=1, parts=(2, 3), jobs=1, out=folder)
    assert render_dataset(config) == 0
    return folder


class Seeing:
    """A detector and a pose network that have learned the pictures by heart; poses are off by some metres along z."""

    def __init__(self, folder: Path, off_m: float = 0.0, turned: Pose | None = None) -> None:
        self._dataset, self._off, self._turned = bop.Dataset(folder, split="test"), off_m, turned or Pose.identity()

    def detect(self, frame: Frame) -> list[Detection]:
        scene = self._dataset.scene(0)
        assert scene.truths is not None
        masks = [
            read_mask(mask_path(scene.folder, frame.index, part)) for part in range(len(scene.truths[frame.index]))
        ]
        return [Detection(mask, 1.0 - 0.01 * part) for part, mask in enumerate(masks) if mask.any()]

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[PoseEstimate]:
        scene = self._dataset.scene(0)
        assert scene.truths is not None
        truths = scene.truths[frame.index]
        known = self.detect(frame)
        visible = [i for i in range(len(truths)) if read_mask(mask_path(scene.folder, frame.index, i)).any()]
        of = {id_of(mask): part for mask, part in zip(known, visible, strict=True)}
        no_points = Correspondences(np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0))
        shift = Pose.from_translation((0.0, 0.0, self._off))
        return [PoseEstimate(shift @ truths[of[id_of(one)]].X_CO @ self._turned, no_points) for one in detections]


def id_of(detection: Detection) -> bytes:
    return np.packbits(detection.mask).tobytes()


def judged(folder: Path, monkeypatch: pytest.MonkeyPatch, seeing: Seeing, *methods: str):
    monkeypatch.setattr(sources, "networks_of", lambda part, networks: None)
    monkeypatch.setattr(sources, "learned_estimators", lambda networks, part: (seeing, (seeing, seeing)))
    task = BatchTask("handle", 0, range(3), 0.1, methods or ("maskval",), PictureSet(folder, "test", None))
    return run_batch(task)


def test_networks_that_know_the_pictures_make_no_error(pictures: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found, matches = judged(pictures, monkeypatch, Seeing(pictures), "maskval", "inliers", "render-ncc", "ensemble-add")
    truths = bop.Dataset(pictures, split="test").scene(0).truths
    assert truths is not None
    assert found.parts.tolist() == [len(truths[im_id]) for im_id in range(3)]
    assert found.mdd_m.max() < 1e-6  # m; poses stand in the file in mm with as many digits
    assert found.disagreement_m.max() == 0.0
    assert found.u["inliers"] == pytest.approx(1.0)  # there are no correspondences
    assert found.u["render-ncc"].max() < 1.0
    assert matches is not None


def test_errors_are_those_to_the_nearest_pose_that_looks_alike(pictures: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    half_turn = poses_alike(load_part("handle"), PictureSet(pictures, "test", None))[1]
    turned, _ = judged(pictures, monkeypatch, Seeing(pictures, turned=half_turn))
    assert turned.mdd_m.max() < 1e-6
    off, _ = judged(pictures, monkeypatch, Seeing(pictures, off_m=0.02))
    assert off.mdd_m == pytest.approx(0.02)


def test_simulated_networks_take_the_symmetries_of_the_parts_file() -> None:
    assert poses_alike(load_part("handle"), None) == ()


def test_fewer_pictures_than_asked_for_are_said(pictures: Path) -> None:
    PictureSet(pictures, "test", None).check(3)
    with pytest.raises(UsageError, match="expected 4 pictures in the split test, got 3"):
        PictureSet(pictures, "test", None).check(4)


WRONG = [
    (["--estimator", "networks"], ["--estimator networks and --pictures FOLDER together"]),
    (["--pictures", "."], ["--estimator networks and --pictures FOLDER together"]),
    (["--networks", "."], ["--networks . is only for --estimator networks"]),
    (["--estimator", "networks", "--pictures", ".", "--networks", "."], ["expected one object", "got several"]),
    (["--objects", "antenna", "--estimator", "networks", "--pictures", "."], ["expected trained networks in"]),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_options_that_do_not_belong_together_are_refused(
    arguments: list[str], words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = command(capsys, "dataset", *arguments, "--images", 2, "--out", tmp_path)
    assert told.code == 2
    assert all(word in told.err for word in words)
    assert told.err.count("\n") == 1
