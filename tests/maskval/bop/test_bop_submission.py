import json

import numpy as np
import pytest

from maskval import UNMATCHED, InvalidFileError, PackedMasks, Pose, bop, mask_iou, silhouette, uncertainty
from tests.maskval import bop_dataset
from tests.maskval.bop_dataset import CAMERA, CUBE, IMAGES, POINT, SCENE, SHIFTS_M, STAR, X_CUBE, X_STAR


@pytest.fixture
def small(tmp_path):
    results, detections = bop_dataset.write(tmp_path)
    return bop.Dataset(tmp_path), bop.read_results(results), bop.DetectedMasks(bop.read_detections(detections))


def test_every_pose_of_a_submission_gets_the_uncertainty_of_its_silhouette_and_mask(small) -> None:
    dataset, results, source = small
    judged = bop.judge_results(dataset, results, source)
    assert [pose.result for pose in judged] == results
    assert len(judged) == 2 * IMAGES
    cube = dataset.mesh(CUBE)
    mask = silhouette(cube, X_CUBE, CAMERA, pixel_center=0.5).mask
    for pose, shift in zip(judged[::2], SHIFTS_M, strict=True):
        moved = silhouette(cube, Pose.from_translation((shift, 0, 0)) @ X_CUBE, CAMERA, pixel_center=0.5)
        assert pose.c == mask_iou(mask, moved.mask)
        assert (pose.v, pose.u) == (moved.visibility, 1 - pose.c)
    # A symmetry of the star changes no pixel but those on its border.
    assert [pose.u < 0.01 for pose in judged[1::2]] == [True] * IMAGES
    assert [pose.mask for pose in judged] == [0] * (2 * IMAGES)


def test_the_masks_of_the_data_set_judge_as_detections_of_them_do(small) -> None:
    dataset, results, source = small
    theirs = bop.judge_results(dataset, results, bop.SceneMasks(dataset))
    assert theirs == bop.judge_results(dataset, results, source)


def test_evaluated_poses_have_the_errors_that_they_were_made_with(small) -> None:
    dataset, results, source = small
    judged = bop.judge_results(dataset, results, source)
    evaluation = bop.evaluate_poses(dataset, judged)
    assert evaluation.images == IMAGES
    assert evaluation.pose_part.tolist() == list(range(2 * IMAGES))
    np.testing.assert_allclose(evaluation.errors_m[::2], SHIFTS_M, rtol=0, atol=1e-12)
    np.testing.assert_allclose(evaluation.errors_m[1::2], 0, rtol=0, atol=1e-12)
    # The MDD knows no symmetries: a point of the star, 0.1 m from its axis, moves by 2 r sin(π / 7).
    plain = bop.evaluate_poses(dataset, judged, error="mdd")
    np.testing.assert_allclose(plain.errors_m[1::2], 2 * 0.1 * np.sin(np.pi / 7), rtol=0, atol=1e-12)
    for error in ("add", "add-s"):
        np.testing.assert_allclose(bop.evaluate_poses(dataset, judged, error=error).errors_m[0], 0, rtol=0, atol=1e-12)


def test_what_is_no_target_is_judged_but_not_counted(small, tmp_path) -> None:
    dataset, results, source = small
    bop.write_targets(tmp_path / "test_targets_bop19.json", [bop.EvaluationTarget(SCENE, 3, STAR, 1)])
    judged = bop.judge_results(dataset, results, source)
    evaluation = bop.evaluate_poses(dataset, judged)
    assert (len(judged), len(evaluation.u), len(evaluation.part_image)) == (2 * IMAGES, 1, 1)
    (tmp_path / "test_targets_bop19.json").unlink()
    assert len(bop.evaluate_poses(dataset, judged).u) == 2 * IMAGES


def test_a_pose_without_a_mask_is_unmatched_and_one_without_a_part_is_a_false_detection(small) -> None:
    dataset, results, source = small
    again = bop.PoseResult(SCENE, 0, CUBE, 0.1, Pose.from_translation((0.2, 0, 0)) @ X_CUBE)
    judged = bop.judge_results(dataset, [*results, again], source)
    assert (judged[-1].mask, judged[-1].c, judged[-1].u) == (UNMATCHED, 0.0, 1.0)
    evaluation = bop.evaluate_poses(dataset, judged)
    assert np.count_nonzero(np.isinf(evaluation.errors_m)) == 1
    with pytest.raises(InvalidFileError, match="scene 2, image 0, object 1: 2 poses and 1 masks have no known assoc"):
        bop.judge_results(dataset, [*results, again], source, association="known")


def test_an_image_without_detections_has_the_size_of_its_scene(small, tmp_path) -> None:
    dataset, results, _ = small
    some = [d for d in bop.read_detections(tmp_path / "detections.json") if d.im_id > 0]
    judged = bop.judge_results(dataset, results, bop.DetectedMasks(some))
    assert [(pose.mask, pose.u) for pose in judged[:2]] == [(UNMATCHED, 1.0)] * 2
    with pytest.raises(InvalidFileError, match="expected masks of the scene 2, which poses are given for: found none"):
        bop.judge_results(dataset, results, bop.DetectedMasks([]))


def test_compressed_run_lengths_are_those_of_pycocotools() -> None:
    # From pycocotools 2.0: the box of rows 2-4 and columns 3-7 in 6 x 9, and a box with a hole in 480 x 640.
    box = np.zeros((6, 9), dtype=bool)
    box[2:5, 3:8] = True
    hole = np.zeros((480, 640), dtype=bool)
    hole[100:300, 200:450] = True
    hole[150:160, 210:220] = False
    text = "Tkm2X6h8000000000000000000ZKbGj2" + 9 * "^8VMbGj2" + "^8l1" + 458 * "0" + "lnh2"
    assert PackedMasks.from_rle(["d03300000004"], 6, 9).areas_px.tolist() == [15]
    np.testing.assert_array_equal(PackedMasks.from_rle(["d03300000004"], 6, 9).words, PackedMasks.pack(box).words)
    np.testing.assert_array_equal(PackedMasks.from_rle([text], 480, 640).words, PackedMasks.pack(hole).words)


def test_a_submission_of_an_association_that_is_known_is_that_of_uncertainty(small) -> None:
    dataset, results, source = small
    found = uncertainty(
        dataset.mesh(STAR),
        [X_STAR @ POINT],
        source.masks(bop.ImageObject(SCENE, 0, STAR)),
        CAMERA,
        pixel_center=0.5,
        alpha=0.9,
        canvas="3x3",
    )
    judged = bop.judge_results(dataset, results, source, association="known", alpha=0.9, canvas="3x3")
    assert judged[1].u == found.u[0]


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        (
            "scene_camera.json",
            lambda table: table.pop("3"),
            r"scene_camera.json: expected the image 3,.* found 9 others",
        ),
        ("scene_gt.json", lambda table: table.pop("3"), "scene_gt.json: expected the parts of image 3, but there are"),
        ("scene_gt_info.json", lambda table: table["3"].pop(), "expected 2 parts as in scene_gt.json, but found 1"),
    ],
)
def test_files_that_do_not_belong_together_are_refused(small, tmp_path, name, change, words) -> None:
    path = tmp_path / "test" / "000002" / name
    table = json.loads(path.read_text())
    change(table)
    path.write_text(json.dumps(table))
    dataset, results, source = small
    with pytest.raises(InvalidFileError, match=words):
        bop.evaluate_poses(dataset, bop.judge_results(dataset, results, source))


def test_a_data_set_without_models_or_scenes_is_refused(tmp_path) -> None:
    with pytest.raises(FileNotFoundError, match="models is no folder: expected a data set in BOP's layout"):
        bop.Dataset(tmp_path)
    bop_dataset.write(tmp_path)
    with pytest.raises(FileNotFoundError, match="val is no folder"):
        bop.Dataset(tmp_path, "val")
    (tmp_path / "models" / "models_info.json").write_text("{}")
    dataset = bop.Dataset(tmp_path)
    judged = [bop.JudgedPose(bop.PoseResult(SCENE, 0, CUBE, 1.0, X_CUBE), 0, 1.0, 1.0, 0.0)]
    with pytest.raises(InvalidFileError, match=r"models_info.json: expected the object 1, but found \[\]"):
        bop.evaluate_poses(dataset, judged)
