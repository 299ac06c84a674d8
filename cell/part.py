"""A part as the controller knows it: its shape, where to grip it and the slot that it goes into."""

from dataclasses import dataclass

import numpy as np

from maskval import Mesh, Pose

MAX_TILT_DEG = 50.0  # of the approach from the vertical; beyond it the gripper's body meets the belt
MAX_TILT = np.radians(MAX_TILT_DEG)


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """One way to grip a part.

    Attributes:
        name: as the part's file calls it.
        X_OT: the tool centre point in the part's frame; z is the approach, y the closing direction.
        half_opening: distance of each jaw from the middle before closing, m.
        max_tilt: of the approach from the vertical, rad; the grasp is not used where it would be more.
    """

    name: str
    X_OT: Pose
    half_opening: float
    max_tilt: float = MAX_TILT


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One kind of part.

    Attributes:
        name: the kind's name, such as "antenna".
        mesh: its surface in frame O, metres.
        grasps: at least one for every pose in which it can lie.
        slot_size: inner size of its container slot along W's x and y, m.
    """

    name: str
    mesh: Mesh
    grasps: tuple[Grasp, ...]
    slot_size: tuple[float, float]
