"""Surfaces with rounded edges: an outline in the x-y plane, swept along a profile."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Point = tuple[float, float, float]

_SLICES = (12, 36)  # of a full turn, fewest and most
_SLICE = 0.009  # m: how long one would be
_SMALL_FILLET = 0.0015  # m, up to which an edge is one chamfer
_FILLET_STEPS = 3
_RING_SPACING = 0.15  # m: lights are computed at vertices, so that long faces need some in between
_MOST_RINGS = 12


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A surface.

    Attributes:
        vertices: (V, 3) m.
        normals: at the vertices, (V, 3).
        uv: where the vertices lie on it, around and along, (V, 2) m.
        faces: (F, 3), counter-clockwise from outside.
    """

    vertices: Array
    normals: Array
    uv: Array
    faces: NDArray[np.int32]

    def moved(self, rotation: Array, translation: Sequence[float] | Array) -> Self:
        """The same at another place, m."""
        return type(self)(self.vertices @ rotation.T + translation, self.normals @ rotation.T, self.uv, self.faces)


def merged(solids: Sequence[Solid]) -> Solid:
    """All of them as one."""
    offsets = np.cumsum([0, *(len(solid.vertices) for solid in solids)])[:-1]
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate([solid.normals for solid in solids]),
        np.concatenate([solid.uv for solid in solids]),
        np.concatenate([solid.faces + offset for solid, offset in zip(solids, offsets, strict=True)]).astype(np.int32),
    )


def rod(start: Point, end: Point, radius: float, fillet: float = 0.003, end_fillet: float | None = None) -> Solid:
    """A round bar between two points.

    Args:
        start: middle of its first end, m.
        end: middle of its last end, m.
        radius: m.
        fillet: radius of its edges, m.
        end_fillet: radius of the last end's edge, m; as the first end's by default.
    """
    slices = 4 * round(np.clip(2 * np.pi * radius / _SLICE, *_SLICES) / 4)  # it is as wide as it is high
    angles = np.linspace(0.0, 2 * np.pi, slices + 1)
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    axis = np.subtract(end, start)
    length = float(np.linalg.norm(axis))
    ends = (fillet, fillet if end_fillet is None else end_fillet)
    return _swept(radius * circle, circle, _profile(length, ends)).moved(_turn_to(axis / length), start)


def box(center: Point, size: Point, fillet: float = 0.003, axis: int = 2) -> Solid:
    """A box with rounded edges.

    Args:
        center: m.
        size: m.
        fillet: radius of its edges, m.
        axis: the coordinate along which its surface's second direction runs: a brushed bar's length.
    """
    others = [(axis + 1) % 3, (axis + 2) % 3]
    half = np.array([size[i] for i in others]) / 2 - fillet
    points, normals = [], []
    for quarter, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        angles = (quarter + _rising(fillet)) * np.pi / 2
        arc = np.column_stack((np.cos(angles), np.sin(angles)))
        points.append(arc * fillet + half * (x, y))
        normals.append(arc)
    outline, around = (np.concatenate([*each, each[0][:1]]) for each in (points, normals))
    solid = _swept(outline, around, _profile(size[axis], (fillet, fillet)))
    rotation = np.zeros((3, 3))
    rotation[[*others, axis], [0, 1, 2]] = 1.0
    low = np.array(center, dtype=float)
    low[axis] -= size[axis] / 2
    return solid.moved(rotation, low)


def _rising(fillet: float) -> Array:
    """Where an edge's vertices lie on its quarter of a circle, from 0 to 1."""
    return np.linspace(0.0, 1.0, 2 if fillet <= _SMALL_FILLET else _FILLET_STEPS + 1)


def _profile(length: float, fillets: tuple[float, float]) -> tuple[Array, Array]:
    """Points (outwards, along) from one end of a bar to the other, and the normals there, (P, 2)."""
    first, last = fillets
    below, above = np.pi / 2 * _rising(first), np.pi / 2 * _rising(last)
    rings = int(np.clip((length - first - last) / _RING_SPACING, 0, _MOST_RINGS))
    between = np.linspace(first, length - last, rings + 2)[1:-1]
    bottom, top = np.column_stack((np.sin(below), -np.cos(below))), np.column_stack((np.cos(above), np.sin(above)))
    points = np.concatenate(
        (
            bottom * first + (-first, first),
            np.column_stack((np.zeros(rings), between)),
            top * last + (-last, length - last),
        )
    )
    return points, np.concatenate((bottom, np.tile((1.0, 0.0), (rings, 1)), top))


def _swept(outline: Array, around: Array, profile: tuple[Array, Array]) -> Solid:
    """Moves a closed outline (its first point is also its last) outwards and along as the profile says; adds caps."""
    (points, normals), count = profile, len(outline)
    xy = outline + points[:, None, :1] * around
    z = np.broadcast_to(points[:, None, 1:], (*xy.shape[:2], 1))
    turned = np.concatenate((normals[:, None, :1] * around, np.broadcast_to(normals[:, None, 1:], z.shape)), axis=2)
    way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(outline, axis=0), axis=1))))
    uv = np.stack(np.broadcast_arrays(way, z[..., 0]), axis=2)
    ring, one = np.indices((len(points) - 1, count - 1))
    a = ring * count + one
    sides = np.concatenate(
        [
            np.stack(three, axis=-1).reshape(-1, 3)
            for three in ((a, a + 1, a + count + 1), (a, a + count + 1, a + count))
        ]
    )
    caps = [_cap(xy[end], float(points[end, 1]), up) for end, up in ((0, False), (-1, True))]
    skin = Solid(
        np.concatenate((xy, z), axis=2).reshape(-1, 3), turned.reshape(-1, 3), uv.reshape(-1, 2), sides.astype(np.int32)
    )
    return merged([skin, *caps])


def _cap(ring: Array, z: float, up: bool) -> Solid:
    """A flat end: a fan over a ring."""
    points = np.vstack((ring[:-1], ring[:-1].mean(axis=0)))
    one = np.arange(len(ring) - 1)
    following = (one + 1) % len(one)
    sides = (one, following) if up else (following, one)
    faces = np.column_stack((*sides, np.full(len(one), len(one)))).astype(np.int32)
    normal = (0.0, 0.0, 1.0 if up else -1.0)
    return Solid(np.column_stack((points, np.full(len(points), z))), np.tile(normal, (len(points), 1)), points, faces)


def _turn_to(axis: Array) -> Array:
    """A rotation that takes z to a direction."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(other, axis)
    x /= np.linalg.norm(x)
    return np.column_stack((x, np.cross(axis, x), axis))
