"""The assumptions behind the robot prediction that the paper does not settle: each variant changes one of them."""

from collections.abc import Callable
from dataclasses import replace

from experiments.prediction.setting import Setting
from experiments.setup.thresholds import load_thresholds
from sim.networks.domain_gap import Reach

Variant = Callable[[Setting], Setting]


def _noise(**values: float) -> Variant:
    """Other values of the error models, by key with the dot written as two underscores."""
    changed = tuple((name.replace("__", "."), value) for name, value in values.items())
    return lambda setting: replace(setting, noise=changed)


def _reach(second: float = 1.0, detector: float = 0.0) -> Variant:
    """Another share of the domain gap for S2 or the detector."""
    return lambda setting: replace(setting, reach=Reach(second, detector))


_OUTLIERS_OWN = _noise(pose__second_outlier_correlation=0.0, pose__second_same_content_share=0.0)
_GAP_FIRST_ONLY = _reach(second=0.0)

VARIANTS: dict[str, Variant] = {
    "base": lambda setting: setting,
    "views-alike": _noise(view__direction_length_deg=44.0, view__distance_length=0.8),
    "views-unlike": _noise(view__direction_length_deg=11.0, view__distance_length=0.2),
    "inference-free": _noise(timing__detector_s=0.0, timing__pose_s=0.0),
    "inference-slow": _noise(timing__detector_s=1.0, timing__pose_s=0.8),
    "speed-moderate": lambda setting: replace(setting, speed="moderate"),
    "speed-fast": lambda setting: replace(setting, speed="fast"),
    "refine-near": lambda setting: replace(setting, refine_distance=0.30),
    "refine-far": lambda setting: replace(setting, refine_distance=0.55),
    "outliers-own": _OUTLIERS_OWN,
    "outliers-shared": _noise(pose__second_outlier_correlation=0.9, pose__second_same_content_share=0.9),
    "outliers-small": _noise(pose__gross_rotation_deg=17.5, pose__gross_depth_mm=25.0, pose__gross_lateral_mm=6.0),
    "outliers-flips": _noise(pose__flip_share=0.5),
    "outliers-along-the-ray": _noise(
        pose__gross_rotation_deg=3.0, pose__gross_depth_mm=80.0, pose__gross_lateral_mm=3.0
    ),
    "gap-first-only": _GAP_FIRST_ONLY,
    "gap-first-only-outliers-own": lambda setting: _OUTLIERS_OWN(_GAP_FIRST_ONLY(setting)),
    "gap-masks": _reach(detector=1.0),
    "errors-renewed": _noise(view__renewed_share=0.5),
    "depth-good": _noise(pose__depth_ratio=1.5),
    "depth-poor": _noise(pose__depth_ratio=4.0),
    "no-false-detections": _noise(mask__false_alarms_per_image=0.0),
    "thresholds-derived": lambda setting: replace(setting, thresholds=load_thresholds("derived")),
}
