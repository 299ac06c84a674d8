"""The uncertainty methods by name, of all that need nothing but the estimates."""

from collections.abc import Callable

from maskval.estimates import UncertaintyMethod
from maskval.methods.baselines import DetectorScore, NoUncertainty
from maskval.methods.combined import Combined
from maskval.methods.depth_agreement import DepthConsistency
from maskval.methods.ensemble import Ensemble
from maskval.methods.mask_agreement import MaskVal
from maskval.methods.outline_agreement import ContourDistance
from maskval.methods.picture_agreement import RenderNcc
from maskval.methods.point_agreement import InlierShare, PnpCovariance
from maskval.methods.view_agreement import TemporalConsistency

# Each call makes a new one: "temporal" remembers what it has seen. The scales of the ensembles begin at 0.
METHODS: dict[str, Callable[[], UncertaintyMethod]] = {
    "none": NoUncertainty,
    "maskval": MaskVal,
    "maskval-no-visibility": lambda: MaskVal(alpha=0.0),
    "ensemble-add": lambda: Ensemble("add"),
    "ensemble-mdd": lambda: Ensemble("mdd"),
    "ensemble-translation": lambda: Ensemble("translation"),
    "ensemble-rotation": lambda: Ensemble("rotation"),
    "maskval-ensemble": lambda: Combined((MaskVal(), Ensemble("add"))),
    "contour": ContourDistance,
    "depth": DepthConsistency,
    "score": DetectorScore,
    "temporal": TemporalConsistency,
}

# Those that need what only networks which look at pictures have: the picture, or correspondences.
NETWORK_METHODS: dict[str, Callable[[], UncertaintyMethod]] = {
    "inliers": InlierShare,
    "pnp-covariance": PnpCovariance,
    "render-ncc": RenderNcc,
}
