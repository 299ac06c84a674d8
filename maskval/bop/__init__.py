"""Files of the BOP benchmark: read and written in its millimetres, held in metres.

Paths are of the layout that BOP calls its format: `models/obj_000001.ply`, `models/models_info.json`,
`test/000001/scene_gt.json`, `scene_gt_info.json`, `scene_camera.json`, `mask_visib/000003_000000.png`.
"""

from maskval.bop.dataset import Dataset, DetectedMasks, ImageObject, MaskSource, Scene, SceneMasks
from maskval.bop.detections import DetectionResult, read_detections, write_detections
from maskval.bop.images import mask_path, read_depth, read_mask, write_depth, write_mask
from maskval.bop.models import ModelInfo, read_model, read_models_info, write_model, write_models_info
from maskval.bop.results import PoseResult, read_results, write_results
from maskval.bop.scenes import (
    EvaluationTarget,
    GroundTruth,
    GroundTruthInfo,
    ImageCamera,
    read_scene_camera,
    read_scene_gt,
    read_scene_gt_info,
    read_targets,
    write_scene_camera,
    write_scene_gt,
    write_scene_gt_info,
    write_targets,
)
from maskval.bop.submission import JudgedPose, evaluate_poses, judge_results

__all__ = [
    "Dataset",
    "DetectedMasks",
    "DetectionResult",
    "EvaluationTarget",
    "GroundTruth",
    "GroundTruthInfo",
    "ImageCamera",
    "ImageObject",
    "JudgedPose",
    "MaskSource",
    "ModelInfo",
    "PoseResult",
    "Scene",
    "SceneMasks",
    "evaluate_poses",
    "judge_results",
    "mask_path",
    "read_depth",
    "read_detections",
    "read_mask",
    "read_model",
    "read_models_info",
    "read_results",
    "read_scene_camera",
    "read_scene_gt",
    "read_scene_gt_info",
    "read_targets",
    "write_depth",
    "write_detections",
    "write_mask",
    "write_model",
    "write_models_info",
    "write_results",
    "write_scene_camera",
    "write_scene_gt",
    "write_scene_gt_info",
    "write_targets",
]
