"""The cell as its controller knows it: kinematics, motion, perception ports and the cycle. No simulator, no truth.

Exported is what policies, estimators and other stations are written against.
"""

from cell.interfaces import (
    Action,
    Contact,
    Decision,
    Detection,
    Frame,
    Image,
    MaskEstimator,
    Observation,
    Outcome,
    Policy,
    PoseEstimator,
    Referee,
    Station,
    Touch,
)
from cell.layout import Layout
from cell.part import Grasp, Part
from cell.setup import EstimatorSetup, PolicySetup

__all__ = [
    "Action",
    "Contact",
    "Decision",
    "Detection",
    "EstimatorSetup",
    "Frame",
    "Grasp",
    "Image",
    "Layout",
    "MaskEstimator",
    "Observation",
    "Outcome",
    "Part",
    "Policy",
    "PolicySetup",
    "PoseEstimator",
    "Referee",
    "Station",
    "Touch",
]
