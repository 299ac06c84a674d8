"""MaskVal: how far can a 6D pose be trusted, judged by the mask that it should project to."""

from maskval.association import UNMATCHED, associate
from maskval.camera import Camera
from maskval.ensemble import EnsembleAdd, EnsembleMdd, EnsembleRotation, EnsembleTranslation
from maskval.errors import (
    InvalidCameraError,
    InvalidEstimatesError,
    InvalidMaskError,
    InvalidMeshError,
    InvalidPoseError,
    MaskvalError,
)
from maskval.estimates import Estimates, NoUncertainty, UncertaintyMethod
from maskval.geometry import Pose, angle_between
from maskval.intervals import bootstrap_mean_interval, proportion_interval
from maskval.masks import PackedMasks, mask_from_rle, mask_iou, rle_counts
from maskval.mesh import Mesh
from maskval.pose_error import add, add_s, mdd, mspd, mssd, rotation_error, translation_error
from maskval.silhouette import Silhouette, silhouette, silhouette_iou
from maskval.symmetry import SymmetryAxis, symmetry_poses
from maskval.uncertainty import MaskVal, Uncertainties, maskval_uncertainty, uncertainty

__all__ = [
    "UNMATCHED",
    "Camera",
    "EnsembleAdd",
    "EnsembleMdd",
    "EnsembleRotation",
    "EnsembleTranslation",
    "Estimates",
    "InvalidCameraError",
    "InvalidEstimatesError",
    "InvalidMaskError",
    "InvalidMeshError",
    "InvalidPoseError",
    "MaskVal",
    "MaskvalError",
    "Mesh",
    "NoUncertainty",
    "PackedMasks",
    "Pose",
    "Silhouette",
    "SymmetryAxis",
    "Uncertainties",
    "UncertaintyMethod",
    "add",
    "add_s",
    "angle_between",
    "associate",
    "bootstrap_mean_interval",
    "mask_from_rle",
    "mask_iou",
    "maskval_uncertainty",
    "mdd",
    "mspd",
    "mssd",
    "proportion_interval",
    "rle_counts",
    "rotation_error",
    "silhouette",
    "silhouette_iou",
    "symmetry_poses",
    "translation_error",
    "uncertainty",
]
