"""Clutter on a belt that stands still: parts close together or touching, and things that are no parts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from cell.layout import Belt
from maskval import Pose
from sim.errors import PlacementError
from sim.model.bodies import FURNITURE_FRICTION, PART_SOLREF
from sim.model.conditions import Clutter
from sim.model.placement import CLEARANCE, DROP_HEIGHT
from sim.polygons import Polygon, are_apart

# Least distance between outlines, m. A finger is 21 mm thick: it fits between parts 55 mm apart, but hardly at 15 mm.
CLEARANCES: dict[Clutter, float] = {"none": CLEARANCE, "close": 0.015, "touching": 0.0005, "distractors": CLEARANCE}
DISTRACTOR_CLEARANCE = 0.015  # m to parts and to other distractors
_TRIES = 2000


@dataclass(frozen=True, slots=True)
class Distractor:
    """Something on the belt that is no part: a box of half extents, or a cylinder of radius and half height."""

    half_extents: tuple[float, ...]  # m
    rgba: tuple[float, float, float, float]

    @property
    def radius(self) -> float:
        """Of the circle around it, seen from above, m."""
        return self.half_extents[0] if self.is_cylinder else math.hypot(*self.half_extents[:2])

    @property
    def is_cylinder(self) -> bool:
        """Whether it is round."""
        return len(self.half_extents) == 2

    @property
    def half_height(self) -> float:
        """Half of its height, m."""
        return self.half_extents[-1]


# Of the parts' size: boxes of 80 × 50 × 40 and 60 × 60 × 24 mm, tins of 50 and 70 mm across; no dearer reason.
DISTRACTORS = (
    Distractor((0.040, 0.025, 0.020), (0.85, 0.65, 0.20, 1.0)),
    Distractor((0.025, 0.025), (0.55, 0.57, 0.60, 1.0)),
    Distractor((0.030, 0.030, 0.012), (0.25, 0.35, 0.55, 1.0)),
    Distractor((0.035, 0.015), (0.10, 0.10, 0.11, 1.0)),
)
_DENSITY = 800.0  # kg/m³: 51 to 128 g


def distractors_of(clutter: Clutter) -> tuple[Distractor, ...]:
    """What lies among the parts."""
    return DISTRACTORS if clutter == "distractors" else ()


def distractor_body(index: int) -> str:
    """Name of the body of distractor `index`."""
    return f"distractor_{index}"


def add_distractor(spec: mujoco.MjSpec, index: int, thing: Distractor) -> None:
    """Adds a free body to `spec`."""
    body = spec.worldbody.add_body(name=distractor_body(index), pos=(1.0, 2.0 + index, 1.0))
    body.add_freejoint(name=distractor_body(index))
    kind = mujoco.mjtGeom.mjGEOM_CYLINDER if thing.is_cylinder else mujoco.mjtGeom.mjGEOM_BOX
    size = [*thing.half_extents, 0.0][:3]
    body.add_geom(
        type=kind, size=size, rgba=thing.rgba, density=_DENSITY, friction=FURNITURE_FRICTION, solref=PART_SOLREF
    )


def place_distractors(
    things: Sequence[Distractor], taken: Sequence[Polygon], belt: Belt, rng: np.random.Generator
) -> list[Pose]:
    """X_WO of distractors among the parts, upright, any yaw, any free place of the loaded stretch.

    Args:
        things: the distractors.
        taken: the parts' outlines in W, convex, counter-clockwise, (P, 2) m each.
        belt: where they lie.
        rng: draws place and yaw.

    Raises:
        PlacementError: no room was found for all of them.
    """
    outlines, poses = list(taken), []
    around = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
    circle = np.column_stack([np.cos(around), np.sin(around)])
    for thing in things:
        room = np.array([belt.width, belt.loading_length]) / 2 - thing.radius - DISTRACTOR_CLEARANCE
        for _ in range(_TRIES):
            place = rng.uniform(-room, room) + [belt.center_x, 0.0]
            outline = place + thing.radius * circle
            if all(are_apart(outline, other, DISTRACTOR_CLEARANCE) for other in outlines):
                break
        else:
            raise PlacementError(f"no room for {len(things)} distractors among the parts; ask for fewer parts")
        outlines.append(outline)
        yaw = Pose.from_rotvec((0.0, 0.0, rng.uniform(-np.pi, np.pi)))
        poses.append(Pose(yaw.rotation, np.array([*place, belt.top_z + thing.half_height + DROP_HEIGHT])))
    return poses
