from itertools import combinations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from maskval import Pose
from sim.errors import DivergenceError
from sim.images import heap
from sim.images.heap import Heap, drop, random_shape, settle
from sim.model.parts import PartModel

DEEPEST = 0.002  # m; contacts are soft, and a heap presses


def dropped(model: PartModel, seed: int, parts: int = 5, clutter: int = 6) -> Heap:
    return drop(model, parts, clutter, 0.05, np.random.default_rng(seed))


def corners(model: PartModel, found: Heap) -> list[list[NDArray[np.float64]]]:
    """The corners in W of every body's convex pieces."""
    parts = [[X.apply(piece.vertices) for piece in model.pieces] for X in found.X_WO]
    return parts + [[X.apply(mesh.vertices)] for mesh, X in found.clutter]


def depth_inside(points: NDArray[np.float64], hull: ConvexHull) -> float:
    """How deep the deepest point is inside of a convex body, m; negative if none is inside."""
    return float((-(points @ hull.equations[:, :3].T + hull.equations[:, 3])).min(axis=1).max())


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_bodies_lie_on_the_floor_and_not_in_one_another(part: str, request: pytest.FixtureRequest) -> None:
    model: PartModel = request.getfixturevalue(part)
    compared, heights = 0, []
    for seed in range(3):
        bodies = corners(model, dropped(model, seed))
        assert len(bodies) == 11
        lowest = [min(piece[:, 2].min() for piece in body) for body in bodies]
        assert min(lowest) > -DEEPEST
        heights += lowest
        hulls = [[ConvexHull(piece) for piece in body] for body in bodies]
        for one, other in combinations(range(len(bodies)), 2):
            for a, hull_a in zip(bodies[one], hulls[one], strict=True):
                for b, hull_b in zip(bodies[other], hulls[other], strict=True):
                    compared += 1
                    assert max(depth_inside(a, hull_b), depth_inside(b, hull_a)) < DEEPEST
    assert compared >= 3 * 55
    assert max(heights) > 0.01  # some lie on others


def test_what_came_to_rest_stays_where_it_is(antenna: PartModel) -> None:
    moved = []
    for seed in range(3):
        found = dropped(antenna, seed)
        before = [*found.X_WO, *(X for _, X in found.clutter)]
        after = settle(heap.build(antenna, 5, [mesh for mesh, _ in found.clutter]), before)
        assert after is not None
        moved += [np.linalg.norm(a.translation - b.translation) for a, b in zip(before, after, strict=True)]
    assert len(moved) == 33
    assert max(moved) < 0.002


def test_a_heap_is_a_function_of_its_generator(handle: PartModel) -> None:
    one, same, other = (dropped(handle, seed, parts=2, clutter=3) for seed in (1, 1, 2))
    for a, b in zip(one.X_WO, same.X_WO, strict=True):
        assert np.array_equal(a.matrix, b.matrix)
    assert not np.allclose(one.X_WO[0].matrix, other.X_WO[0].matrix)


def test_what_floats_never_comes_to_rest(antenna: PartModel) -> None:
    assert settle(heap.build(antenna, 1, []), [Pose.from_translation((0.0, 0.0, 90.0))]) is None  # 4 s fall 78 m


def test_a_heap_that_never_rests_is_an_error(antenna: PartModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(heap, "settle", lambda *_: None)
    with pytest.raises(DivergenceError, match="none of 20 heaps of 5 × antenna and 6 other bodies"):
        dropped(antenna, 0)


def test_clutter_is_convex_and_of_the_parts_size() -> None:
    rng = np.random.default_rng(0)
    shapes = [random_shape(rng) for _ in range(60)]
    for mesh in shapes:
        assert mesh.is_solid
        assert 0.02 < mesh.diameter < 0.4
        hull = ConvexHull(mesh.vertices)
        assert depth_inside(mesh.vertices, hull) < 1e-9
    assert len({len(mesh.vertices) for mesh in shapes}) > 8
