"""The error of a symmetric part is the least over the poses that look the same."""

import math

import numpy as np
import pytest
import trimesh

from cell.part import pose_error
from maskval import Camera, Mesh, Pose, SymmetryAxis, mdd, silhouette
from sim.parts.turns import Turn, alike

TRUE = Pose.from_rotvec((0.4, -1.1, 0.3), (0.02, -0.05, 0.6))
BOX = trimesh.creation.box((0.09, 0.05, 0.02)).apply_translation((0.01, 0, 0))
CAN = trimesh.creation.cylinder(0.03, 0.1, sections=360)
Z, X = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])


def half_turns(middle: tuple[float, float, float]) -> tuple[Pose, ...]:
    return alike([Turn(SymmetryAxis(axis, np.array(middle)), 2) for axis in (Z, X)])


def of(mesh: trimesh.Trimesh) -> Mesh:
    return Mesh(mesh.vertices, mesh.faces)


def farthest(X_est: Pose, points: np.ndarray, same: np.ndarray) -> float:
    """Over all points, each with its like in a symmetry: the definition, point by point."""
    return max(
        float(np.linalg.norm(X_est.apply(p[None])[0] - TRUE.apply(q[None])[0]))
        for p, q in zip(points, same, strict=True)
    )


def test_of_a_box_the_best_of_its_four_ways_to_look_the_same_counts() -> None:
    symmetries = half_turns((0.01, 0, 0))
    assert len(symmetries) == 4
    signs = [(1, 1, 1), (-1, -1, 1), (1, -1, -1), (-1, 1, -1)]  # half turns about z, x and y, by hand
    middle, rng = np.array([0.01, 0, 0]), np.random.default_rng(4)
    for turned in symmetries:
        small = Pose.from_rotvec(rng.normal(0, 0.05, 3), rng.normal(0, 0.004, 3))
        X_est = TRUE @ small @ turned
        ways = [farthest(X_est, BOX.vertices, middle + (BOX.vertices - middle) * sign) for sign in signs]
        error = pose_error(X_est, TRUE, of(BOX), symmetries)
        assert error == pytest.approx(min(ways), abs=1e-12)
        assert 0.001 < error < 0.03


def test_of_a_can_any_turn_about_its_axis_costs_nothing_but_a_shift_counts() -> None:
    symmetries = alike([Turn(SymmetryAxis(Z, np.zeros(3)), 0), Turn(SymmetryAxis(X, np.zeros(3)), 2)])
    for angle in (0.0, 0.7, 2.0, math.pi):
        turn = Pose.from_rotvec((0, 0, angle))
        head_over = Pose.from_rotvec((math.pi, 0, 0))
        # Turns are tried in 315 steps: half a step moves the rim by 0.03 m × π / 315.
        assert pose_error(TRUE @ turn @ head_over, TRUE, of(CAN), symmetries) < 0.03 * math.pi / 315 + 1e-9
        shifted = TRUE @ Pose.from_translation((0, 0, 0.01)) @ turn
        assert pose_error(shifted, TRUE, of(CAN), symmetries) == pytest.approx(0.01, abs=1e-5)
    assert mdd(TRUE @ Pose.from_rotvec((0, 0, math.pi)), TRUE, CAN.vertices) == pytest.approx(0.06)


def test_without_symmetries_it_is_the_mdd_to_the_last_bit() -> None:
    X_est = TRUE @ Pose.from_rotvec((0.1, 0.2, 3.0), (0.01, 0, 0))
    assert pose_error(X_est, TRUE, of(BOX)) == mdd(X_est, TRUE, BOX.vertices)


def test_symmetric_poses_have_one_silhouette_so_that_maskval_takes_them_for_one() -> None:
    camera = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
    poses = [TRUE @ same for same in half_turns((0.01, 0, 0))]
    assert len(poses) == 4
    first, *others = (silhouette(of(BOX), pose, camera).mask for pose in poses)
    assert first.sum() > 1000
    for other in others:
        assert (other != first).sum() <= 3  # of pixels whose middle lies on an outline
