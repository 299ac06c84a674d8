"""A small data set in BOP's layout, whose every number follows from how it is made."""

from pathlib import Path

import numpy as np

from maskval import Camera, Mesh, Pose, bop, silhouette
from maskval.bop.detections import detection_of_mask
from tests.maskval import shapes

CAMERA = Camera(300.0, 300.0, 160.5, 120.0, 320, 240)
SCENE = 2
CUBE, STAR = 1, 5
IMAGES = 10
# How far the pose of each image's cube is off, along the camera's x, metres: half of them less than 15 mm.
SHIFTS_M = tuple(0.003 * image for image in range(IMAGES))
X_CUBE = Pose.from_rotvec((0.2, 0.3, 0.4), (-0.1, 0.02, 0.6))
X_STAR = Pose.from_rotvec((0.3, -0.2, 0.1), (0.12, -0.03, 0.6))
# A turn of the star by one of its seven points.
POINT = Pose.from_rotvec((0, 0, 2 * np.pi / 7))


def write(folder: Path, *, split: str = "test") -> tuple[Path, Path]:
    """Writes models, one scene, its masks, targets, poses and detections; the last two as paths.

    Every image has a cube, whose pose is off by `SHIFTS_M`, and a star, whose pose is the true one turned by a
    symmetry. Detections are the true silhouettes, the star's first.
    """
    meshes = {CUBE: shapes.cube(0.08), STAR: Mesh(*shapes.star())}
    models, scene = folder / "models", folder / split / f"{SCENE:06d}"
    models.mkdir(parents=True)
    scene.mkdir(parents=True)
    for obj_id, mesh in meshes.items():
        bop.write_model(models / f"obj_{obj_id:06d}.ply", mesh)
    turns = tuple(Pose.from_rotvec((0, 0, 2 * np.pi * k / 7)) for k in range(1, 7))
    bop.write_models_info(
        models / "models_info.json",
        {
            CUBE: (meshes[CUBE], bop.ModelInfo(meshes[CUBE].diameter)),
            STAR: (meshes[STAR], bop.ModelInfo(meshes[STAR].diameter, turns)),
        },
    )
    truths = {im_id: [bop.GroundTruth(CUBE, X_CUBE), bop.GroundTruth(STAR, X_STAR)] for im_id in range(IMAGES)}
    infos, results, detections = {}, [], []
    for im_id, parts in truths.items():
        drawn = [silhouette(meshes[part.obj_id], part.X_CO, CAMERA, pixel_center=0.5) for part in parts]
        infos[im_id] = [_info(found.mask, found.visibility) for found in drawn]
        for index, found in enumerate(drawn):
            bop.write_mask(bop.mask_path(scene, im_id, index), found.mask)
        results.append(
            bop.PoseResult(SCENE, im_id, CUBE, 0.5, Pose.from_translation((SHIFTS_M[im_id], 0, 0)) @ X_CUBE, 0.1)
        )
        results.append(bop.PoseResult(SCENE, im_id, STAR, 0.9, X_STAR @ POINT, 0.1))
        detections += [
            detection_of_mask(SCENE, im_id, obj_id, 1.0, drawn[index].mask) for obj_id, index in ((STAR, 1), (CUBE, 0))
        ]
    bop.write_scene_gt(scene / "scene_gt.json", truths)
    bop.write_scene_gt_info(scene / "scene_gt_info.json", infos)
    bop.write_scene_camera(scene / "scene_camera.json", {im_id: bop.ImageCamera(CAMERA.K) for im_id in truths})
    bop.write_targets(
        folder / f"{split}_targets_bop19.json",
        [bop.EvaluationTarget(SCENE, im_id, obj_id, 1) for im_id in truths for obj_id in (CUBE, STAR)],
    )
    bop.write_results(folder / f"ours_small-{split}.csv", results)
    bop.write_detections(folder / "detections.json", detections)
    return folder / f"ours_small-{split}.csv", folder / "detections.json"


def _info(mask: np.ndarray, visibility: float) -> bop.GroundTruthInfo:
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = (int(columns[0]), int(rows[0]), int(np.ptp(columns)) + 1, int(np.ptp(rows)) + 1)
    pixels = int(np.count_nonzero(mask))
    return bop.GroundTruthInfo(box, box, pixels, pixels, pixels, visibility)
