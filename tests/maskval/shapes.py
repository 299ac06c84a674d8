"""Meshes, poses and a camera for the tests: made by arithmetic, and the two parts of the cell."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose
from sim.model.parts import load_part

Arrays = tuple[NDArray[np.float64], NDArray[np.int64]]

VGA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)


def grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Faces of a grid that closes on itself both ways; vertex (r, c) is r * columns + c."""
    r, c = (index.ravel() for index in np.indices((rows, columns)))
    down, right = (r + 1) % rows, (c + 1) % columns
    a, b, d, e = r * columns + c, down * columns + c, down * columns + right, r * columns + right
    return np.concatenate((np.stack((a, b, d), 1), np.stack((a, d, e), 1)))


def torus(major: float = 0.07, minor: float = 0.025, rows: int = 40, columns: int = 20) -> Arrays:
    """A ring, its axis z."""
    around, across = np.meshgrid(
        np.arange(rows) * 2 * np.pi / rows, np.arange(columns) * 2 * np.pi / columns, indexing="ij"
    )
    distance = major + minor * np.cos(across)
    points = np.stack((distance * np.cos(around), distance * np.sin(around), minor * np.sin(across)), axis=-1)
    return points.reshape(-1, 3), grid_faces(rows, columns)


def star(points: int = 7, outer: float = 0.1, inner: float = 0.035, height: float = 0.04) -> Arrays:
    """A prism over a star, its axis z."""
    angle = np.arange(2 * points) * np.pi / points
    radius = np.where(np.arange(2 * points) % 2, inner, outer)
    ring = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)
    count = len(ring)
    vertices = np.concatenate(
        [np.column_stack((ring, np.full(count, z))) for z in (-height / 2, height / 2)]
        + [np.array([[0, 0, -height / 2], [0, 0, height / 2]])]
    )
    i = np.arange(count)
    j = (i + 1) % count
    sides = np.concatenate((np.stack((i, j, count + j), 1), np.stack((i, count + j, count + i), 1)))
    caps = np.concatenate(
        (
            np.stack((j, i, np.full(count, 2 * count)), 1),
            np.stack((count + i, count + j, np.full(count, 2 * count + 1)), 1),
        )
    )
    return vertices, np.concatenate((sides, caps))


@cache
def antenna() -> Arrays:
    """The cell's shark-fin antenna."""
    return _part("antenna")


@cache
def handle() -> Arrays:
    """The cell's door handle."""
    return _part("handle")


def _part(name: str) -> Arrays:
    mesh = load_part(name).part.mesh
    return mesh.vertices, mesh.faces.astype(np.int64)


def square(side: float = 0.1) -> Mesh:
    """One square sheet in the plane z = 0, around the origin."""
    half = side / 2
    corners = np.array([[-half, -half, 0], [half, -half, 0], [half, half, 0], [-half, half, 0]])
    return Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def cube(side: float = 0.1) -> Mesh:
    """A closed cube around the origin."""
    half = side / 2
    corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Mesh(corners, np.array([face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]))


def random_poses(seed: int, count: int, depth: tuple[float, float] = (0.4, 0.8), reach: float = 0.3) -> list[Pose]:
    """Poses of any rotation; with the default reach and VGA about a fifth of them touch the image's border."""
    rng = np.random.default_rng(seed)
    return [
        Pose.from_quaternion_wxyz(
            (q := rng.normal(size=4)) / np.linalg.norm(q),
            (rng.uniform(-reach, reach), 0.75 * rng.uniform(-reach, reach), rng.uniform(*depth)),
        )
        for _ in range(count)
    ]
