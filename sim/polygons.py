"""Convex polygons seen from above: outlines, and whether two of them are apart."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from maskval.compiled import jit

Polygon = NDArray[np.float64]  # convex, counter-clockwise, (P, 2) m


def convex_outline(points: NDArray[np.float64]) -> Polygon:
    """The convex outline of points (N, 2 or more) seen from above, counter-clockwise, (P, 2) m."""
    seen = points[:, :2]
    outline: Polygon = seen[ConvexHull(seen).vertices]
    return outline


@jit
def are_apart(one: Polygon, other: Polygon, clearance: float) -> bool:
    """Whether two convex polygons are apart by a clearance, m: their boxes, or an axis along an edge, show it."""
    for axis in range(2):
        lowest, highest = one[:, axis].min(), one[:, axis].max()
        if other[:, axis].min() - highest >= clearance or lowest - other[:, axis].max() >= clearance:
            return True
    return gap(one, other) >= clearance


@jit
def gap(one: Polygon, other: Polygon) -> float:
    """A lower bound of the distance between two convex polygons, m; negative if they overlap (separating axes)."""
    return max(_gap_along_edges(one, other), _gap_along_edges(other, one))


@jit
def _gap_along_edges(one: Polygon, other: Polygon) -> float:
    largest = -np.inf
    for corner in range(len(one)):
        following = (corner + 1) % len(one)
        x, y = one[corner]
        along_x, along_y = one[following, 0] - x, one[following, 1] - y
        nearest = np.inf  # along the outward normal: the edge turned right, since the outline is counter-clockwise
        for point in range(len(other)):
            nearest = min(nearest, (other[point, 0] - x) * along_y - (other[point, 1] - y) * along_x)
        largest = max(largest, nearest / np.sqrt(along_x * along_x + along_y * along_y))
    return largest
