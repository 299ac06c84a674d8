"""Random poses on the belt, as a worker would leave the parts: any side up, any way round, room for the gripper."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from cell.layout import Belt
from maskval import Pose
from sim.errors import PlacementError
from sim.parts import PartModel

CLEARANCE = 0.055  # m between parts and to the belt's edges: a jaw with its opening fits between
DROP_HEIGHT = 0.0005  # m above contact, so that parts settle instead of starting in one another
_TRIES_PER_PART = 200
_TRIES_PER_BELT = 200

Polygon = NDArray[np.float64]


def place_parts(
    model: PartModel, count: int, belt: Belt, rng: np.random.Generator, clearance: float = CLEARANCE
) -> list[Pose]:
    """X_WO of `count` parts on the belt: resting pose by its probability, any yaw, any free place.

    Raises:
        PlacementError: no room was found for all of them.
    """
    for _ in range(_TRIES_PER_BELT):
        placed = _fill_belt(model, count, belt, rng, clearance)
        if placed is not None:
            return placed
    raise PlacementError(
        f"no room for {count} × {model.part.name} on {belt.loading_length} m × {belt.width} m of belt with "
        f"{clearance * 1000:.0f} mm between them, in {_TRIES_PER_BELT} tries; ask for fewer parts or less clearance"
    )


def _footprint(model: PartModel, side: int) -> Polygon:
    """Outline of a resting pose seen from above, convex, (P, 2) m around O's origin."""
    points = (model.part.mesh.vertices @ model.resting_poses[side].rotation.T)[:, :2]
    outline: Polygon = points[ConvexHull(points).vertices]
    return outline


def _fill_belt(
    model: PartModel, count: int, belt: Belt, rng: np.random.Generator, clearance: float
) -> list[Pose] | None:
    footprints = [_footprint(model, side) for side in range(len(model.resting_poses))]
    outlines: list[Polygon] = []
    poses: list[Pose] = []
    probabilities = [pose.probability for pose in model.resting_poses]
    room = np.array([belt.width, belt.loading_length]) / 2 - clearance
    while len(poses) < count:
        for _ in range(_TRIES_PER_PART):
            side = int(rng.choice(len(footprints), p=probabilities))
            yaw = rng.uniform(-np.pi, np.pi)
            turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
            outline = footprints[side] @ turn.T + rng.uniform(-room, room)
            offset = outline - footprints[side] @ turn.T
            if np.all(np.abs(outline) <= room) and all(gap(outline, other) >= clearance for other in outlines):
                break
        else:
            return None
        resting = model.resting_poses[side]
        rotation = np.eye(3)
        rotation[:2, :2] = turn
        outlines.append(outline)
        x, y = offset[0] + [belt.center_x, 0.0]
        poses.append(Pose(rotation @ resting.rotation, np.array([x, y, belt.top_z + resting.height + DROP_HEIGHT])))
    return poses


def gap(one: Polygon, other: Polygon) -> float:
    """A lower bound of the distance between two convex polygons, m; negative if they overlap (separating axes)."""
    return max(_gap_along_edges(one, other), _gap_along_edges(other, one))


def _gap_along_edges(one: Polygon, other: Polygon) -> float:
    edges = np.roll(one, -1, axis=0) - one  # counter-clockwise: the outward normal is the edge turned right
    normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1, keepdims=True)
    return float(((other @ normals.T).min(axis=0) - (one * normals).sum(axis=1)).max())
