"""Part shapes made in code: closed curves joined into watertight meshes, with convex pieces from the same curves."""

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

Curves = NDArray[np.float64]  # (S, P, 3) m: S closed curves of P points each, in the order in which they are joined


def plan_curve(rear: float, nose: float, half_width: float, points: int = 48) -> NDArray[np.float64]:
    """A shark fin's plan: round at the rear, straight sides, pointed at the nose; (points, 2) m, counter-clockwise."""
    rear_end, nose_start = 0.25, 0.65  # of the length; the sides between are straight, so that the part can lie on them
    s = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, points // 2 + 1))
    rear_arc = np.sqrt(np.clip(1.0 - ((rear_end - s) / rear_end) ** 2, 0.0, 1.0))
    nose_arc = 1.0 - ((s - nose_start) / (1.0 - nose_start)) ** 2
    width = half_width * np.where(s < rear_end, rear_arc, np.where(s > nose_start, nose_arc, 1.0))
    left = np.stack([rear + s * (nose - rear), width], axis=1)
    return np.vstack([left, left[-2:0:-1] * [1.0, -1.0]])[::-1]


def fin_curves(sections_mm: Sequence[Sequence[float]]) -> Curves:
    """One plan curve per row (height z, rear x, nose x, half width), millimetres in, metres out."""
    curves = []
    for height, rear, nose, half_width in np.asarray(sections_mm) / 1000.0:
        plan = plan_curve(rear, nose, half_width)
        curves.append(np.column_stack([plan, np.full(len(plan), height)]))
    return np.array(curves)


def bow_curves(
    spine_mm: Sequence[Sequence[float]], width_mm: float, thickness_mm: float, corner_mm: float, steps: int = 6
) -> Curves:
    """A bar of rounded rectangular section swept along a spine in the x-z plane; millimetres in, metres out.

    Args:
        spine_mm: corners (x, z) of the spine; consecutive ones are joined by straight bars, mitred at the corners.
        width_mm: extent along y.
        thickness_mm: extent in the x-z plane, across the spine.
        corner_mm: radius of the section's corners.
        steps: points per rounded corner.
    """
    spine = np.asarray(spine_mm, dtype=float) / 1000.0
    half_width, half_thickness, radius = width_mm / 2000.0, thickness_mm / 2000.0, corner_mm / 1000.0
    angles = np.linspace(0.0, np.pi / 2, steps)
    arc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    inner = np.array([half_width - radius, half_thickness - radius])
    quarter_turns = [np.array([[c, -s], [s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]
    signs = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    section = np.vstack([arc @ turn.T + inner * sign for turn, sign in zip(quarter_turns, signs, strict=True)])
    directions = np.diff(spine, axis=0)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    curves = []
    for index, corner in enumerate(spine):
        before, after = directions[max(index - 1, 0)], directions[min(index, len(directions) - 1)]
        bisector = before + after
        bisector /= np.linalg.norm(bisector)
        normal = np.array([-bisector[1], bisector[0]]) / (bisector @ after)  # the mitre keeps the bar's thickness
        offset = section[:, 1:] * normal
        curves.append(np.column_stack([corner[0] + offset[:, 0], section[:, 0], corner[1] + offset[:, 1]]))
    return np.array(curves)


def join(curves: Curves) -> trimesh.Trimesh:
    """The closed surface through the curves, with a fan over the first and the last one."""
    count, points = curves.shape[:2]
    ring = np.arange(points)
    following = (ring + 1) % points
    faces = []
    for level in range(count - 1):
        low, high = level * points, (level + 1) * points
        faces.append(np.column_stack([low + ring, low + following, high + following]))
        faces.append(np.column_stack([low + ring, high + following, high + ring]))
    first, last = count * points, count * points + 1
    top = (count - 1) * points
    faces.append(np.column_stack([np.full(points, first), following, ring]))
    faces.append(np.column_stack([np.full(points, last), top + ring, top + following]))
    vertices = np.vstack([curves.reshape(-1, 3), curves[0].mean(axis=0), curves[-1].mean(axis=0)])
    mesh = trimesh.Trimesh(vertices, np.vstack(faces), process=True)
    mesh.fix_normals()
    return mesh


def convex_pieces(curves: Curves) -> tuple[trimesh.Trimesh, ...]:
    """Convex hulls of runs of neighbouring curves that together fill the joined surface.

    A run grows as long as its hull is hardly larger than the hulls of its neighbouring pairs: fewer pieces, and no thin
    ones, on whose doubled edges a resting part trembles.
    """
    pairs = [_hull(curves[level : level + 2]).volume for level in range(len(curves) - 1)]
    pieces, first = [], 0
    while first < len(pairs):
        last = first + 1
        while last < len(pairs) and _hull(curves[first : last + 2]).volume < 1.005 * sum(pairs[first : last + 1]):
            last += 1
        pieces.append(_hull(curves[first : last + 1]))
        first = last
    return tuple(pieces)


def _hull(curves: Curves) -> trimesh.Trimesh:
    hull: trimesh.Trimesh = trimesh.convex.convex_hull(curves.reshape(-1, 3))
    return hull
