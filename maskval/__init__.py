"""MaskVal: how far can a 6D pose be trusted, judged by the mask that it should project to."""

from importlib.metadata import version

from maskval.association import UNMATCHED, associate
from maskval.camera import Camera
from maskval.correspondences import Correspondences
from maskval.errors import (
    ImplausibleInputError,
    ImplausibleInputWarning,
    InexactRotationWarning,
    InvalidArgumentError,
    InvalidCameraError,
    InvalidEstimatesError,
    InvalidEvaluationError,
    InvalidFileError,
    InvalidMaskError,
    InvalidMeshError,
    InvalidPoseError,
    MaskvalError,
    MissingRendererError,
)
from maskval.estimates import Estimates, Needs, UncertaintyMethod, needs_of
from maskval.evaluation.matching import NO_PART, Counting, Evaluation, ImageErrors, match_images
from maskval.evaluation.metrics import RecallCurve, rates, recall_curve
from maskval.evaluation.ranking import aurc, auroc, bootstrap_interval, spearman
from maskval.evaluation.summary import Measured, Summary, Threshold, summarise
from maskval.evaluation.thresholds import Certificate, certified_threshold, conformal_threshold, paper_threshold
from maskval.evaluation.visible_surface import vsd
from maskval.geometry import Pose, PoseLike, PosesLike, angle_between
from maskval.masks import PackedMasks, mask_from_rle, mask_iou, rle_counts
from maskval.mesh import Mesh
from maskval.methods import METHODS, NETWORK_METHODS
from maskval.methods.baselines import DetectorScore, NoUncertainty, RandomUncertainty
from maskval.methods.combined import Combined
from maskval.methods.depth_agreement import DepthConsistency
from maskval.methods.ensemble import Ensemble
from maskval.methods.mask_agreement import MaskVal, Uncertainties, maskval_uncertainty, uncertainty
from maskval.methods.outline_agreement import ContourDistance, chamfer_distance
from maskval.methods.picture_agreement import RenderNcc
from maskval.methods.point_agreement import InlierShare, PnpCovariance
from maskval.methods.view_agreement import TemporalConsistency
from maskval.pose_errors import add, add_s, mdd, mspd, mssd, rotation_error, translation_error
from maskval.rendering.depth import DepthCrop, depth_crop, depth_image
from maskval.rendering.silhouettes import Silhouette, silhouette, silhouette_boxes, silhouette_iou
from maskval.statistics.intervals import bootstrap_mean_interval, mean_interval, proportion_interval
from maskval.symmetry import SymmetryAxis, symmetry_poses

__all__ = [
    "METHODS",
    "NETWORK_METHODS",
    "NO_PART",
    "UNMATCHED",
    "Camera",
    "Certificate",
    "Combined",
    "ContourDistance",
    "Correspondences",
    "Counting",
    "DepthConsistency",
    "DepthCrop",
    "DetectorScore",
    "Ensemble",
    "Estimates",
    "Evaluation",
    "ImageErrors",
    "ImplausibleInputError",
    "ImplausibleInputWarning",
    "InexactRotationWarning",
    "InlierShare",
    "InvalidArgumentError",
    "InvalidCameraError",
    "InvalidEstimatesError",
    "InvalidEvaluationError",
    "InvalidFileError",
    "InvalidMaskError",
    "InvalidMeshError",
    "InvalidPoseError",
    "MaskVal",
    "MaskvalError",
    "Measured",
    "Mesh",
    "MissingRendererError",
    "Needs",
    "NoUncertainty",
    "PackedMasks",
    "PnpCovariance",
    "Pose",
    "PoseLike",
    "PosesLike",
    "RandomUncertainty",
    "RecallCurve",
    "RenderNcc",
    "Silhouette",
    "Summary",
    "SymmetryAxis",
    "TemporalConsistency",
    "Threshold",
    "Uncertainties",
    "UncertaintyMethod",
    "add",
    "add_s",
    "angle_between",
    "associate",
    "aurc",
    "auroc",
    "bootstrap_interval",
    "bootstrap_mean_interval",
    "certified_threshold",
    "chamfer_distance",
    "conformal_threshold",
    "depth_crop",
    "depth_image",
    "mask_from_rle",
    "mask_iou",
    "maskval_uncertainty",
    "match_images",
    "mdd",
    "mean_interval",
    "mspd",
    "mssd",
    "needs_of",
    "paper_threshold",
    "proportion_interval",
    "rates",
    "recall_curve",
    "rle_counts",
    "rotation_error",
    "silhouette",
    "silhouette_boxes",
    "silhouette_iou",
    "spearman",
    "summarise",
    "symmetry_poses",
    "translation_error",
    "uncertainty",
    "vsd",
]


def __getattr__(name: str) -> str:
    if name == "__version__":  # of the distribution, looked up when it is asked for: that takes milliseconds
        return version("graspcell")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
