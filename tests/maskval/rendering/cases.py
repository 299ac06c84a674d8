"""What rendering is tried with: both implementations, small images, and meshes that are spoilt."""

import numpy as np
import pytest
from numpy.typing import NDArray

from maskval import Camera
from maskval.masks import Implementation
from tests.maskval import shapes

IMPLEMENTATIONS: tuple[Implementation, ...] = ("numba", "numpy")
SMALL = Camera(150.0, 160.0, 80.5, 59.0, 160, 120, skew=2.0)
both = pytest.mark.parametrize("implementation", IMPLEMENTATIONS)
both_shapes = pytest.mark.parametrize("shape", [shapes.torus, shapes.star], ids=["torus", "star"])


def opened(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    kept = np.random.default_rng(3).random(len(faces)) > 0.3
    return vertices, faces[kept]


def flipped(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    turned = np.random.default_rng(4).random(len(faces)) > 0.5
    return vertices, np.where(turned[:, None], faces[:, ::-1], faces)


def unwelded(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    return vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)


def doubled(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    """Faces listed twice and thrice, and faces without an area."""
    thin = np.stack((faces[:50, 0], faces[:50, 1], faces[:50, 1]), axis=1)
    return vertices, np.concatenate((faces, faces[::2], faces[::3, ::-1], thin))


def crumpled(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    """Noise that folds the surface, so that rows have more crossings than are sorted by insertion."""
    return vertices + np.random.default_rng(5).normal(scale=0.006, size=vertices.shape), faces


def everything(vertices: NDArray[np.float64], faces: NDArray[np.int64]) -> shapes.Arrays:
    return unwelded(*flipped(*opened(*crumpled(vertices, faces))))
