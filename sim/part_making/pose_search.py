"""Every way in which a part may lie, round sides included: stable facets of its hull, neighbours taken together."""

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from cell.rounding import rounded
from sim.parts.stable_poses import RAREST_RESTING_POSE, RestingPose
from sim.parts.turns import Turn

NEIGHBOURS = np.radians(15.0)  # facets within this of one another are one way to lie
_DIRECTIONS = 1500  # in which the hull's corners are kept: finer curves change no pose by more than a degree
_ROUND = 8  # equal turns of an axis from which a part is taken for round
_OF_A_ROUND = 4  # poses that stand for a round group
_SAME_HEIGHT = 0.1  # of the axis' component along the vertical, within which poses belong to a group
_DIGITS = 6  # decimals of probabilities and directions, so that the order of equals is the same everywhere


def stable_poses(mesh: trimesh.Trimesh) -> tuple[RestingPose, ...]:
    """The ways to lie of at least 2 %, likeliest first; of equals the one whose up direction has the lesser entries.

    A round side has hundreds of facets, each of which is hardly likely. Those near to one another count as one pose,
    the likeliest of them. The probabilities add up to 1.
    """
    hull = _thinned(mesh.convex_hull)
    transforms, shares = trimesh.poses.compute_stable_poses(hull, center_mass=mesh.center_mass, n_samples=1, sigma=0.0)
    ups, shares = rounded(transforms[:, 2, :3], _DIGITS), rounded(shares, _DIGITS)
    order = sorted(range(len(shares)), key=lambda index: (-shares[index], *ups[index]))
    chosen: list[int] = []
    sums: list[float] = []
    for index in order:
        near = [np.dot(ups[index], ups[other]) for other in chosen]
        if near and max(near) >= np.cos(NEIGHBOURS):
            sums[int(np.argmax(rounded(near, _DIGITS)))] += shares[index]
        else:
            chosen.append(index)
            sums.append(float(shares[index]))
    kept = [(share, ups[index]) for index, share in zip(chosen, sums, strict=True) if share >= RAREST_RESTING_POSE]
    total = sum(share for share, _ in kept)
    kept.sort(key=lambda entry: (-round(entry[0], 4), *entry[1]))
    return tuple(
        RestingPose.from_up(up / np.linalg.norm(up), mesh.vertices, float(rounded(share / total, 4)))
        for share, up in kept
    )


def sphere_directions(count: int) -> NDArray[np.float64]:
    """Directions spread evenly over the sphere, (count, 3), by the golden angle."""
    index = np.arange(count) + 0.5
    z = 1.0 - 2.0 * index / count
    angle = np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])


def _thinned(hull: trimesh.Trimesh) -> trimesh.Trimesh:
    """The hull of those corners that are farthest in some direction: no more than some thousand facets."""
    if len(hull.vertices) <= _DIRECTIONS:
        return hull
    farthest = np.unique(np.argmax(sphere_directions(_DIRECTIONS) @ hull.vertices.T, axis=1))
    thinned: trimesh.Trimesh = trimesh.convex.convex_hull(hull.vertices[farthest])
    return thinned


def representatives(poses: Sequence[RestingPose], turns: Sequence[Turn]) -> tuple[RestingPose, ...]:
    """The poses, with few of those that turns about a round axis lead to: they look, lie and are gripped the same way.

    Args:
        poses: as `stable_poses` returns them.
        turns: the part's symmetries; those of at least `_ROUND` equal turns count as round.

    Returns:
        Of each round group `_OF_A_ROUND` poses, spread evenly, which share the group's probability.
    """
    axis = next((turn.axis.axis_O for turn in turns if turn.fold == 0 or turn.fold >= _ROUND), None)
    if axis is None:
        return tuple(poses)
    heights = [float(pose.rotation[2] @ axis) for pose in poses]
    groups: list[list[int]] = []
    for index, height in enumerate(heights):
        group = next((one for one in groups if abs(heights[one[0]] - height) < _SAME_HEIGHT), None)
        groups.append([index]) if group is None else group.append(index)
    made: list[RestingPose] = []
    for group in groups:
        kept = [poses[index] for index in group]
        if len(kept) > _OF_A_ROUND:
            kept = _spread(kept, axis)
        total = sum(poses[index].probability for index in group)
        made += [RestingPose(pose.rotation, pose.height, float(rounded(total / len(kept), 4))) for pose in kept]
    return tuple(sorted(made, key=lambda pose: (-pose.probability, *pose.rotation[2])))


def _spread(poses: Sequence[RestingPose], axis: NDArray[np.float64]) -> list[RestingPose]:
    """`_OF_A_ROUND` of the poses, each the nearest to one of as many directions about the axis, from the first on."""
    first = poses[0].rotation[2]
    flat = first - (first @ axis) * axis
    side = np.cross(axis, flat)
    kept: list[RestingPose] = []
    for angle in 2 * np.pi * np.arange(_OF_A_ROUND) / _OF_A_ROUND:
        wanted = np.cos(angle) * flat + np.sin(angle) * side
        left = [pose for pose in poses if all(pose is not other for other in kept)]
        kept.append(max(left, key=lambda pose: round(float(pose.rotation[2] @ wanted), _DIGITS)))
    return kept
