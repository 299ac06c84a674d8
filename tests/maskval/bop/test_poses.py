"""Rotations as files have them: LM-O's own true poses are printed with few digits, some off by up to 0.0046."""

import json
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from maskval import InexactRotationWarning, InvalidFileError, Pose, bop
from maskval.bop.places import Place
from maskval.bop.poses import PoseReader

TURN = Pose.from_rotvec((0.3, -1.1, 0.7)).rotation
Matrix = NDArray[np.float64]


def leaned(e: float) -> Matrix:
    # The second factor is symmetric and positive, so that TURN is the nearest rotation (polar decomposition).
    return TURN @ np.array([[1, 0, 0], [0, np.cos(e), np.sin(e)], [0, np.sin(e), np.cos(e)]])


def scene_gt(folder: Path, rotations: list[Matrix]) -> tuple[Path, Callable[[], list[Pose]]]:
    path = folder / "scene_gt.json"
    parts = [{"cam_R_m2c": R.ravel().tolist(), "cam_t_m2c": [0, 0, 500], "obj_id": 1} for R in rotations]
    path.write_text(json.dumps({"0": parts}))
    return path, lambda: [part.X_CO for part in bop.read_scene_gt(path)[0]]


def scene_camera(folder: Path, rotations: list[Matrix]) -> tuple[Path, Callable[[], list[Pose]]]:
    path = folder / "scene_camera.json"
    K = [600, 0, 320, 0, 600, 240, 0, 0, 1]
    cameras = {
        str(k): {"cam_K": K, "cam_R_w2c": R.ravel().tolist(), "cam_t_w2c": [0, 0, 1]} for k, R in enumerate(rotations)
    }
    path.write_text(json.dumps(cameras))
    return path, lambda: [camera.X_CW for camera in bop.read_scene_camera(path).values() if camera.X_CW is not None]


def results(folder: Path, rotations: list[Matrix]) -> tuple[Path, Callable[[], list[Pose]]]:
    path = folder / "ours_lmo-test.csv"
    path.write_text("".join(f"1,2,3,1.0,{' '.join(map(repr, R.ravel().tolist()))},1 2 3,-1\n" for R in rotations))
    return path, lambda: [result.X_CO for result in bop.read_results(path)]


def models_info(folder: Path, rotations: list[Matrix]) -> tuple[Path, Callable[[], list[Pose]]]:
    path = folder / "models_info.json"
    symmetries = []
    for R in rotations:
        X = np.eye(4)
        X[:3, :3] = R
        symmetries.append(X.ravel().tolist())
    path.write_text(json.dumps({"1": {"diameter": 100, "symmetries_discrete": symmetries}}))
    return path, lambda: list(bop.read_models_info(path)[1].symmetries)


FILES = [scene_gt, scene_camera, results, models_info]


@pytest.mark.parametrize("write", FILES)
def test_inexact_rotations_become_the_nearest_ones_and_one_warning_tells_of_all_of_them(tmp_path, write) -> None:
    sizes = (0.0, 0.0005, 0.002, 0.0046, 0.003)
    path, read = write(tmp_path, [leaned(e) for e in sizes])
    off = max(float(np.abs(leaned(e) - TURN).max()) for e in sizes)
    with pytest.warns(InexactRotationWarning) as told:
        poses = read()
    assert [str(one.message) for one in told] == [
        f"{path}: 3 of 5 rotations are off by more than 0.001, by up to {off:.2g}; the nearest rotations are taken"
    ]
    assert len(poses) == 5
    for pose in poses:
        np.testing.assert_allclose(pose.rotation, TURN, rtol=0, atol=1e-14)


@pytest.mark.parametrize("write", FILES)
def test_what_was_rounded_to_three_decimals_is_read_without_a_word(tmp_path, write) -> None:
    _, read = write(tmp_path, [np.round(TURN, 3)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (pose,) = read()
    np.testing.assert_allclose(pose.rotation, TURN, rtol=0, atol=0.001)


@pytest.mark.parametrize("write", FILES)
def test_a_matrix_farther_from_a_rotation_than_a_hundredth_is_refused_without_a_warning(tmp_path, write) -> None:
    path, read = write(tmp_path, [leaned(0.004), leaned(0.02)])
    off = float(np.abs(leaned(0.02) - TURN).max())
    words = rf"{path.name}:\d+:\d+.*: expected a rotation to 0.01, but the nearest one differs by {off:.3g}$"
    with pytest.raises(InvalidFileError, match=words):
        read()


@pytest.mark.parametrize(("off", "words"), [(0.0099, None), (0.0101, "expected a rotation to 0.01")])
def test_the_limits_are_a_hundredth_and_a_thousandth_of_an_element(tmp_path, off, words) -> None:
    reader, place = PoseReader(tmp_path), Place("file", "")
    stretched = np.diag([1 + off, 1, 1]).ravel()
    if words is None:
        assert reader.pose(stretched, np.zeros(3), place).rotation.tolist() == np.eye(3).tolist()
    else:
        with pytest.raises(InvalidFileError, match=words):
            reader.pose(stretched, np.zeros(3), place)


@pytest.mark.parametrize(("off", "count"), [(0.00099, 0), (0.00101, 1)])
def test_a_warning_comes_from_a_thousandth_on(tmp_path, off, count) -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        with PoseReader(tmp_path) as reader:
            reader.pose(np.diag([1 + off, 1, 1]).ravel(), np.zeros(3), "file")
    assert len(told) == count


@pytest.mark.parametrize("R", [np.full((3, 3), 1e308), np.zeros((3, 3)), np.diag([1.0, 1, -1]), np.diag([2.0, 2, 2])])
def test_a_matrix_that_is_no_rotation_at_all_is_refused(tmp_path, R) -> None:
    with pytest.raises(InvalidFileError, match=r"^file: "):
        PoseReader(tmp_path).pose(R.ravel(), np.zeros(3), "file")
