"""Random poses on the belt, as a worker would leave the parts: any side up, any way round, room for the gripper."""

import numpy as np
from numpy.typing import NDArray

from cell.layout import Belt
from maskval import Pose
from sim.errors import PlacementError
from sim.model.parts import PartModel
from sim.polygons import Polygon, are_apart, convex_outline, gap

CLEARANCE = 0.055  # m between parts and to the belt's edges: a jaw with its opening fits between
DROP_HEIGHT = 0.0005  # m above contact, so that parts settle instead of starting in one another
TAKT_SPREAD = 0.15  # share of the takt by which the time between two parts on a moving belt varies
LONGEST_PART = 0.5  # m: sim.model.parts refuses larger ones
_TRIES_PER_PART = 200
_TRIES_PER_BELT = 200


def place_parts(
    model: PartModel,
    count: int,
    belt: Belt,
    rng: np.random.Generator,
    clearance: float = CLEARANCE,
    *,
    leaning: bool = False,
) -> list[Pose]:
    """X_WO of `count` parts on the belt: resting pose by its probability, any yaw, any free place.

    Args:
        model: the kind of part.
        count: how many.
        belt: where they lie, at least `CLEARANCE` from its edges.
        rng: what is drawn from.
        clearance: least distance between the parts' outlines, m.
        leaning: whether every part is pushed against an earlier one, up to the clearance.

    Raises:
        PlacementError: no room was found for all of them.
    """
    for _ in range(_TRIES_PER_BELT):
        placed = _fill_belt(model, count, belt, rng, clearance=clearance, leaning=leaning)
        if placed is not None:
            return placed
    raise PlacementError(
        f"no room for {count} × {model.part.name} on {belt.loading_length} m × {belt.width} m of belt with "
        f"{clearance * 1000:.0f} mm between them, in {_TRIES_PER_BELT} tries; ask for fewer parts or less clearance"
    )


def feed_parts(model: PartModel, count: int, belt: Belt, rng: np.random.Generator, takt: float) -> list[Pose]:
    """X_WO of `count` parts upstream on a moving belt, the first about to come into the arm's reach.

    Resting pose, yaw and place across the belt as on a belt that stands still. They follow one another every `takt`
    seconds, ± `TAKT_SPREAD` of it, but with no less than `CLEARANCE` between them.
    """
    footprints = [_footprint(model, side) for side in range(len(model.resting_poses))]
    probabilities = [pose.probability for pose in model.resting_poses]
    poses: list[Pose] = []
    start = belt.loading_length / 2
    for _ in range(count):
        side = int(rng.choice(len(footprints), p=probabilities))
        turn = _about_z(rng.uniform(-np.pi, np.pi))
        outline = footprints[side] @ turn.T
        room = belt.width / 2 - CLEARANCE
        x = rng.uniform(-room - outline[:, 0].min(), room - outline[:, 0].max())
        y = start - outline[:, 1].min()
        poses.append(_lying(model, side, turn, np.array([x, y]), belt))
        end = y + outline[:, 1].max()
        interval = takt * rng.uniform(1 - TAKT_SPREAD, 1 + TAKT_SPREAD)
        start = max(start + belt.speed * interval, end + CLEARANCE)
    return poses


def feeding_length(speed: float, takt: float, count: int) -> float:
    """Length of belt upstream, m, on which `feed_parts` has room for `count` parts, whatever they are."""
    return count * max(speed * takt * (1 + TAKT_SPREAD), LONGEST_PART + CLEARANCE)


def _footprint(model: PartModel, side: int) -> Polygon:
    """Outline of a resting pose seen from above, convex, (P, 2) m around O's origin."""
    points = (model.part.mesh.vertices @ model.resting_poses[side].rotation.T)[:, :2]
    return convex_outline(points)


def _pushed_against(outline: Polygon, other: Polygon, clearance: float) -> Polygon:
    """The outline moved straight towards the middle of another, up to the clearance."""
    way = other.mean(axis=0) - outline.mean(axis=0)
    free, blocked = 0.0, 1.0
    for _ in range(20):
        share = (free + blocked) / 2
        free, blocked = (share, blocked) if gap(outline + share * way, other) >= clearance else (free, share)
    pushed: Polygon = outline + free * way
    return pushed


def _fill_belt(
    model: PartModel, count: int, belt: Belt, rng: np.random.Generator, *, clearance: float, leaning: bool
) -> list[Pose] | None:
    footprints = [_footprint(model, side) for side in range(len(model.resting_poses))]
    outlines: list[Polygon] = []
    poses: list[Pose] = []
    bounds = np.cumsum([pose.probability for pose in model.resting_poses])
    bounds /= bounds[-1]
    room = np.array([belt.width, belt.loading_length]) / 2 - max(clearance, CLEARANCE)
    while len(poses) < count:
        for _ in range(_TRIES_PER_PART):
            side = int(bounds.searchsorted(rng.random(), side="right"))  # as rng.choice draws, without its checks
            turn = _about_z(rng.uniform(-np.pi, np.pi))
            turned = footprints[side] @ turn.T
            outline = turned + rng.uniform(-room, room)
            if leaning and outlines:
                outline = _pushed_against(outline, outlines[int(rng.integers(len(outlines)))], clearance)
            if (np.abs(outline) <= room).all() and all(are_apart(outline, other, clearance) for other in outlines):
                break
        else:
            return None
        outlines.append(outline)
        poses.append(_lying(model, side, turn, outline[0] - turned[0], belt))
    return poses


def _about_z(yaw: float) -> NDArray[np.float64]:
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.array([[cosine, -sine], [sine, cosine]])


def _lying(model: PartModel, side: int, turn: NDArray[np.float64], place: NDArray[np.float64], belt: Belt) -> Pose:
    """X_WO of a part on one of its sides, turned on the belt, at a place (2,) m from the belt's middle."""
    resting = model.resting_poses[side]
    rotation = np.eye(3)
    rotation[:2, :2] = turn
    x, y = place + [belt.center_x, 0.0]
    return Pose(rotation @ resting.rotation, np.array([x, y, belt.top_z + resting.height + DROP_HEIGHT]))
