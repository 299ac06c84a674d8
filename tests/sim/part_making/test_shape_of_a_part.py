"""Stable poses, symmetries and convex pieces of shapes whose answers are known."""

import numpy as np
import pytest
import trimesh

from maskval import Mesh
from sim.part_making.pieces import AGREEMENT, cut_into_pieces
from sim.part_making.pose_search import representatives, sphere_directions, stable_poses
from sim.part_making.solids import solid_of
from sim.part_making.symmetry_search import find_symmetries
from sim.parts.turns import continuous_axes, discrete_symmetries, model_symmetries
from tests.part_shapes import shape

BOX = trimesh.creation.box((0.09, 0.05, 0.02))
CYLINDER = trimesh.creation.cylinder(0.03, 0.1, sections=64)


def test_a_box_lies_on_its_six_sides_the_largest_likeliest_in_a_fixed_order() -> None:
    poses = stable_poses(BOX)
    ups = [pose.rotation[2].round(6).tolist() for pose in poses]
    assert ups[:4] == [[0, 0, -1], [0, 0, 1], [0, -1, 0], [0, 1, 0]]
    assert sum(pose.probability for pose in poses) == pytest.approx(1.0, abs=1e-3)
    for pose in poses:
        assert (BOX.vertices @ pose.rotation[2] + pose.height).min() == pytest.approx(0.0, abs=1e-9)


def test_a_round_side_counts_though_none_of_its_facets_is_likely() -> None:
    poses = stable_poses(CYLINDER)
    on_its_side = [pose for pose in poses if abs(pose.rotation[2, 2]) < 0.1]
    assert len(on_its_side) > 8
    assert sum(pose.probability for pose in on_its_side) > 0.5


def test_few_poses_stand_for_a_round_side() -> None:
    poses = stable_poses(CYLINDER)
    few = representatives(poses, find_symmetries(CYLINDER))
    on_its_side = [pose for pose in few if abs(pose.rotation[2, 2]) < 0.1]
    assert (len(few), len(on_its_side)) == (6, 4)
    assert sum(pose.probability for pose in few) == pytest.approx(1.0, abs=2e-3)
    cosines = np.array([[one.rotation[2] @ other.rotation[2] for other in on_its_side] for one in on_its_side])
    assert (cosines - np.eye(4)).max() < np.cos(np.radians(70.0))  # about a right angle from one to the next


def test_directions_are_spread_evenly() -> None:
    directions = sphere_directions(400)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(np.ones(400))
    assert np.abs(directions.mean(axis=0)).max() < 0.01


@pytest.mark.parametrize(
    ("mesh", "folds", "discrete"),
    [
        (BOX, [2, 2, 2], 3),
        (trimesh.creation.box((0.05, 0.05, 0.02)), [4, 2, 2], 7),
        (CYLINDER, [0, 2, 2], 1),
        (shape("gear").apply_scale(1e-3), [20], 19),
        (shape("elbow").apply_scale(1e-3), [2], 1),
        (shape("bracket").apply_scale(1e-3), [], 0),
    ],
    ids=["box", "square", "cylinder", "gear", "elbow", "bracket"],
)
def test_symmetries_are_found(mesh: trimesh.Trimesh, folds: list[int], discrete: int) -> None:
    turns = find_symmetries(mesh)
    assert [turn.fold for turn in turns][: len(folds)] == folds[: len(turns)]
    assert bool(turns) is bool(folds)
    assert len(continuous_axes(turns)) == folds.count(0)
    found = discrete_symmetries(turns)
    assert len(found) >= discrete
    solid = solid_of(mesh)
    assert solid is not None
    for X in found:
        turned = solid.transform(X.matrix[:3])
        assert (turned - solid).volume() < 0.01 * solid.volume()


def test_models_without_listed_turns_have_their_right_angles() -> None:
    discrete, axes = model_symmetries((), Mesh(BOX.vertices, BOX.faces))
    assert (len(discrete), axes) == (3, ())


def test_a_convex_part_is_one_piece() -> None:
    pieces = cut_into_pieces(BOX)
    assert (len(pieces.hulls), pieces.share) == (1, pytest.approx(1.0))


def test_pieces_fill_a_part_whose_hull_is_far_too_large() -> None:
    mesh = shape("clip").apply_scale(1e-3)
    assert mesh.convex_hull.volume > 3 * mesh.volume
    pieces = cut_into_pieces(mesh)
    assert pieces.agree
    assert abs(pieces.share - 1.0) <= AGREEMENT
    assert all(hull.is_convex for hull in pieces.hulls)
