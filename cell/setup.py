"""What a policy and estimators are made with: everything that they may know beforehand, and nothing of the truth."""

from dataclasses import dataclass

from cell.layout import Layout
from cell.part import Part
from maskval import Camera


@dataclass(frozen=True, slots=True, eq=False)
class PolicySetup:
    """What a policy is made with, anew for every experiment.

    Attributes:
        part: the kind of part, with its mesh and grasps.
        layout: where everything stands.
        u_grasp: the method's u_t,g for this kind of part, in [0, 1]; 0 for a method whose u is always 0.
        u_refine: u_t,r, in [0, 1].
    """

    part: Part
    layout: Layout
    u_grasp: float
    u_refine: float


@dataclass(frozen=True, slots=True, eq=False)
class EstimatorSetup:
    """What estimators are made with, anew for every experiment.

    Attributes:
        part: the kind of part, with its mesh.
        camera: the pinhole model of all frames.
        pixel_center: where the camera samples pixel i, i + pixel_center.
        seed: the root seed, for estimators that draw random numbers.
        experiment: number of the experiment.
    """

    part: Part
    camera: Camera
    pixel_center: float
    seed: int
    experiment: int
