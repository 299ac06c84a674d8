"""The edges of a mesh that can lie on its contour, and the sides on which its faces see the camera.

Give every face that looks at the camera the sign +1, every other face -1, and let every face run around its border
in the image with that sign: then each face winds once, in the same sense, around the pixels it covers, so the winding
number of all borders together counts the faces over a pixel. It is not zero exactly inside the silhouette. An edge
adds up what its faces run along it; between two faces that look to the same side this is nothing, and what remains is
the contour: some 2 % of the edges. Nothing here needs the mesh to be closed or its faces to agree: an edge of one
face keeps that face's sign, and an edge of three or more is listed as several of at most two.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidMeshError


class ContourEdges(NamedTuple):
    """A mesh laid out for the kernels (Numba reads named tuples); made by `contour_edges`, its arrays not writeable.

    Args:
        centre_O: Middle of the mesh's box, (3,), metres; it is the origin of the frame M below.
        radius: Radius of a sphere about the centre that holds the mesh, metres.
        vertices_M: Distinct corners, (V, 3), metres.
        planes_M: Unit normal and offset of each face, (4, F), float32: a face looks at a camera at p if n p + d > 0.
        faces: Corners of each face, (F, 3).
        tails: First vertex of each edge, (E,); the lower index, so that an edge listed twice is computed alike.
        heads: Second vertex of each edge, (E,).
        lefts: What one face adds to the edge, as an index of the sides, (E,).
        rights: The same of the other face. The 2 F + 1 sides are the signs of the faces, for those that run from tail
            to head, their negatives, for those that run back, and a 0 for an edge without a second face.
    """

    centre_O: NDArray[np.float64]
    radius: float
    vertices_M: NDArray[np.float64]
    planes_M: NDArray[np.float32]
    faces: NDArray[np.uint32]
    tails: NDArray[np.uint32]
    heads: NDArray[np.uint32]
    lefts: NDArray[np.uint32]
    rights: NDArray[np.uint32]


def contour_edges(vertices_O: NDArray[np.float64], faces: NDArray[np.int32]) -> ContourEdges:
    """The edges, planes and bounding sphere of a mesh.

    Args:
        vertices_O: Corners, (V, 3), metres.
        faces: Indices of the triangles' corners, (F, 3).

    Raises:
        InvalidMeshError: If no face has an area.
    """
    vertices, faces = _weld(vertices_O, faces)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_areas = np.linalg.norm(normals, axis=1)
    flat = doubled_areas > 0
    if not flat.any():
        raise InvalidMeshError(f"a mesh must have a face with an area, but its {len(faces)} faces have none")
    faces, corners, normals = faces[flat], corners[flat], normals[flat] / doubled_areas[flat, None]
    used = corners.reshape(-1, 3)
    centre = (used.min(axis=0) + used.max(axis=0)) / 2
    offsets = -np.einsum("ij,ij->i", normals, corners.mean(axis=1) - centre)
    planes = np.column_stack((normals, offsets)).T.astype(np.float32, order="C")
    radius = float(np.linalg.norm(used - centre, axis=1).max())
    return ContourEdges(
        _frozen(centre),
        radius,
        _frozen(vertices - centre),
        _frozen(planes),
        _frozen(faces.astype(np.uint32)),
        *_pair(faces),
    )


def _weld(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Corners at the same place become one; faces that thereby lose a corner go, and corners of no face."""
    order = np.lexsort(vertices.T)
    placed = vertices[order]
    new = np.concatenate(([True], (placed[1:] != placed[:-1]).any(axis=1)))
    index_of = np.empty(len(vertices), dtype=np.int32)
    index_of[order] = np.cumsum(new) - 1
    welded = index_of[faces]
    a, b, c = welded.T
    used, renamed = np.unique(welded[(a != b) & (b != c) & (c != a)], return_inverse=True)
    return placed[new][used], renamed.reshape(-1, 3).astype(np.int32)


def _pair(faces: NDArray[np.int32]) -> Iterator[NDArray[np.uint32]]:
    """Tails, heads, lefts and rights of the edges, sorted by left side."""
    starts = faces.ravel()
    ends = np.roll(faces, -1, axis=1).ravel()
    tails, heads = np.minimum(starts, ends), np.maximum(starts, ends)
    owners = np.repeat(np.arange(len(faces)), 3)
    sides = np.where(starts < ends, owners, owners + len(faces))

    order = np.lexsort((owners, heads, tails))
    tails, heads, sides = tails[order], heads[order], sides[order]
    first = np.concatenate(([True], (tails[1:] != tails[:-1]) | (heads[1:] != heads[:-1])))
    # Of the faces around one edge, the first is a left, the second its right, the third a left again, ...
    firsts = np.flatnonzero(first)
    rank = np.arange(len(tails)) - np.repeat(firsts, np.diff(firsts, append=len(tails)))
    left = np.flatnonzero(rank % 2 == 0)
    paired = np.append(rank % 2 == 1, False)[left + 1]
    rights = np.where(paired, np.append(sides, 0)[left + 1], 2 * len(faces))
    by_left = left[np.argsort(order[left], kind="stable")]
    rights = rights[np.argsort(order[left], kind="stable")]
    return (_frozen(column.astype(np.uint32)) for column in (tails[by_left], heads[by_left], sides[by_left], rights))


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    contiguous = np.ascontiguousarray(array)
    contiguous.setflags(write=False)
    return contiguous
