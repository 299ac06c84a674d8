"""A part's symmetries, found by turning its surface onto itself."""

import numpy as np
import scipy
import trimesh
from numpy.typing import NDArray

from maskval import SymmetryAxis
from sim.part_making.samples import SurfacePoints, sample_surface
from sim.parts.turns import Turn

TOLERANCE = 0.004  # of the diameter by which a turned surface may miss itself: 0.5 mm of a part of 125 mm
MOST_FOLD = 36
_ODD_ANGLES = (1.0, 0.37, 2.6)  # rad; what looks the same after all of these turns about an axis is round
_CHECKED = 2_000  # points that are turned
_NEAREST = 12  # points of the surface that a turned point is compared with
_SNAP = np.cos(np.radians(0.5))  # an axis so near to one of the frame's is meant to be it
_STEPS = 360  # directions across a main axis in which a half turn is tried

Array = NDArray[np.float64]


def find_symmetries(mesh: trimesh.Trimesh) -> tuple[Turn, ...]:
    """The axes through the centre of mass about which turns leave the surface as it is, the most symmetric first.

    Looks along the principal axes of inertia and the frame's own axes, and across the most symmetric of them.
    """
    surface = _TurnedSurface(mesh)
    found: list[tuple[Array, int]] = []
    for axis in _candidates(mesh):
        fold = surface.fold(axis)
        if fold != 1:
            found.append((axis, fold))
    found.sort(key=lambda entry: -(entry[1] or np.inf))
    if found and (found[0][1] == 0 or found[0][1] > 2):
        found += [(axis, 2) for axis in surface.half_turns_across(found[0][0]) if _is_new(axis, found)]
    center = np.round(mesh.center_mass, 6)
    return tuple(Turn(SymmetryAxis(axis, center), fold) for axis, fold in found)


class _TurnedSurface:
    """A surface that can be turned about axes through its centre of mass."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        sampled: SurfacePoints = sample_surface(mesh)
        self._points = sampled.points - mesh.center_mass
        self._normals = sampled.normals
        self._tree = scipy.spatial.cKDTree(self._points)
        self._limit = TOLERANCE * float(np.linalg.norm(mesh.extents))
        self._reach = 3.0 * np.sqrt(mesh.area / len(self._points))
        farthest = np.argsort(-np.linalg.norm(self._points, axis=1), kind="stable")
        some = self._points[:: max(1, len(self._points) // _CHECKED)]
        self._tried = np.vstack([self._points[farthest[:200]], some])

    def fold(self, axis: Array) -> int:
        """Equal turns about the axis that make a full one and are symmetries: 0 for any turn, 1 for none."""
        if all(self.fits(axis, angle) for angle in _ODD_ANGLES):
            return 0
        return next((fold for fold in range(MOST_FOLD, 1, -1) if self.fits(axis, 2 * np.pi / fold)), 1)

    def fits(self, axis: Array, angle: float) -> bool:
        """Whether the surface, so turned, is itself."""
        few = self._tried[:: max(1, len(self._tried) // 150)]
        return self._miss(few, axis, angle) <= self._limit and self._miss(self._tried, axis, angle) <= self._limit

    def half_turns_across(self, axis: Array) -> list[Array]:
        """An axis across this one about which half a turn is a symmetry, if there is one."""
        one = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        one /= np.linalg.norm(one)
        other = np.cross(axis, one)
        few = self._tried[:: max(1, len(self._tried) // 150)]
        angles = np.pi * np.arange(_STEPS) / _STEPS
        across = [np.cos(angle) * one + np.sin(angle) * other for angle in angles]
        best = min(across, key=lambda direction: round(self._miss(few, direction, np.pi), 6))
        return [best] if self.fits(best, np.pi) else []

    def _miss(self, points: Array, axis: Array, angle: float) -> float:
        """How far turned points are from the surface at most, m: from the planes of the points near to them."""
        turned = points @ scipy.spatial.transform.Rotation.from_rotvec(angle * axis).as_matrix().T
        distances, near = self._tree.query(turned, k=_NEAREST)
        heights = np.abs(((turned[:, None] - self._points[near]) * self._normals[near]).sum(axis=2))
        heights[distances > self._reach] = np.inf
        lowest = np.minimum(heights.min(axis=1), distances[:, 0])
        return float(lowest.max())


def _candidates(mesh: trimesh.Trimesh) -> list[Array]:
    axes: list[Array] = []
    frame = np.eye(3)
    for axis in [*frame, *np.asarray(mesh.principal_inertia_vectors)]:
        snapped = next((own for own in frame if abs(own @ axis) > _SNAP), axis)
        if not any(abs(snapped @ other) > _SNAP for other in axes):
            axes.append(np.round(snapped / np.linalg.norm(snapped), 9))
    return axes


def _is_new(axis: Array, found: list[tuple[Array, int]]) -> bool:
    return not any(abs(axis @ other) > _SNAP for other, _ in found)
