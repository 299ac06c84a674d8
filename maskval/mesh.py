"""A triangle mesh in its object frame O, prepared once for the silhouette."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from maskval.contour import ContourEdges, contour_edges
from maskval.errors import InvalidMeshError
from maskval.inputs.arrays import floats

# The parts of this field are centimetres long: ten metres mean that the file was in millimetres.
MAXIMUM_DIAMETER_M = 10.0
# Squares of larger numbers may overflow before the diameter is known.
MAXIMUM_PLACE_M = 1e100


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh; it may be open, flipped, non-manifold or unwelded.

    Args:
        vertices: Corners in the object frame O, (V, 3), metres.
        faces: Indices of each triangle's corners, (F, 3), F >= 1.

    Raises:
        InvalidMeshError: If a shape is wrong, a number is not finite or beyond 1e100, an index is out of range, no face
            has an area, or the diameter exceeds 10 m.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.integer[Any]]
    edges: ContourEdges = field(init=False, repr=False)

    def __post_init__(self) -> None:
        vertices = np.ascontiguousarray(floats("vertices", self.vertices, InvalidMeshError))
        faces = _indices(self.faces)
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise InvalidMeshError(f"vertices must have shape (V, 3), but have {vertices.shape}")
        if len(faces) == 0:
            raise InvalidMeshError("a mesh must have at least one face, but has none")
        placed = (np.abs(vertices) <= MAXIMUM_PLACE_M).all(axis=1)  # not where a number is none
        if not placed.all():
            index = int(np.flatnonzero(~placed)[0])
            raise InvalidMeshError(
                f"vertices must be finite and within {MAXIMUM_PLACE_M:g} m, but vertex {index} is "
                f"{vertices[index].tolist()}"
            )
        if faces.min() < 0 or faces.max() >= len(vertices):
            index = int(np.flatnonzero(((faces < 0) | (faces >= len(vertices))).any(axis=1))[0])
            raise InvalidMeshError(
                f"faces must index the {len(vertices)} vertices, but face {index} is {faces[index].tolist()}"
            )
        vertices.setflags(write=False)
        faces.setflags(write=False)
        object.__setattr__(self, "vertices", vertices)
        object.__setattr__(self, "faces", faces)
        if np.linalg.norm(np.ptp(vertices, axis=0)) > MAXIMUM_DIAMETER_M and self.diameter > MAXIMUM_DIAMETER_M:
            raise InvalidMeshError(
                f"the diameter must be at most {MAXIMUM_DIAMETER_M:g} m, but is {self.diameter:g} m: millimetres?"
            )
        object.__setattr__(self, "edges", contour_edges(vertices, faces))

    def __reduce__(self) -> tuple[type[Self], tuple[NDArray[np.float64], NDArray[np.integer[Any]]]]:
        # What comes out of a pickle is not writeable either: Numba would compile the kernel anew for arrays that are.
        return type(self), (self.vertices, self.faces)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """Least and greatest corner of the axis-aligned box around the vertices, (2, 3), metres."""
        return np.stack((self.vertices.min(axis=0), self.vertices.max(axis=0)))

    @cached_property
    def center(self) -> NDArray[np.float64]:
        """Middle of the axis-aligned box around the vertices, (3,), metres in O."""
        center: NDArray[np.float64] = self.bounds.mean(axis=0)
        center.setflags(write=False)
        return center

    @cached_property
    def is_solid(self) -> bool:
        """Whether the mesh bounds a volume: closed, all faces outwards, in each of its connected pieces."""
        count = len(self.edges.faces)
        one, other = self.edges.lefts.astype(np.int64), self.edges.rights.astype(np.int64)
        # Each edge has two faces, of which one runs from tail to head and the other back.
        if ((one < count) == (other < count)).any() or (other == 2 * count).any():
            return False
        neighbours = scipy.sparse.coo_array((np.ones(len(one)), (one % count, other % count)), shape=(count, count))
        _, piece = scipy.sparse.csgraph.connected_components(neighbours, directed=False)
        a, b, c = np.moveaxis(self.edges.vertices_M[self.edges.faces], 1, 0)
        return bool((np.bincount(piece, np.einsum("ij,ij->i", a, np.cross(b, c))) > 0).all())

    @cached_property
    def diameter(self) -> float:
        """Greatest distance between two vertices, metres."""
        radii = np.linalg.norm(self.vertices - self.center, axis=1)
        far = self.vertices[np.argmax(radii)]
        reached = float(np.linalg.norm(self.vertices - far, axis=1).max())
        # Both ends of a pair at least `reached` apart lie at least this far from the centre.
        ends = self.vertices[radii >= reached - radii.max() - 1e-12]
        blocks = np.array_split(ends, -(-len(ends) // 256))
        return max(float(np.linalg.norm(ends[:, None] - block[None], axis=2).max()) for block in blocks)


def _indices(faces: NDArray[Any]) -> NDArray[np.int32]:
    try:
        indices = np.asarray(faces)
    except ValueError as error:  # ragged lists
        raise InvalidMeshError(f"faces must be triangles, (F, 3), but are not of one length: {error}") from error
    if indices.size == 0:
        return np.empty((0, 3), dtype=np.int32)
    if indices.ndim != 2 or indices.shape[1] != 3 or indices.dtype.kind not in "iu":
        raise InvalidMeshError(f"faces must be whole numbers (F, 3), but are {indices.dtype} {indices.shape}")
    if indices.max() >= 2**31:
        raise InvalidMeshError(f"faces must index at most 2^31 vertices, but one index is {indices.max()}")
    return np.array(indices, dtype=np.int32, order="C")
