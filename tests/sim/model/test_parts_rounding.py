"""The last bit of a mesh or of a probability changes nothing of a part."""

import numpy as np
import pytest
import trimesh

import sim.model.parts
from sim.model.parts import load_part, resting_poses
from sim.parts.part_shapes import bow_curves, fin_curves

CURVES = {"antenna": ("fin", fin_curves), "handle": ("bow", bow_curves)}


def off_by_bits(array, rng):
    """The array, every number of it moved by at most one place of its last bit."""
    return np.nextafter(array, array + rng.integers(-1, 2, size=array.shape))


def as_numbers(poses):
    return np.array([[*pose.rotation.ravel(), pose.height, pose.probability] for pose in poses])


def test_equally_likely_sides_stand_in_the_order_of_their_rotations(monkeypatch):
    find = trimesh.poses.compute_stable_poses
    transforms, probabilities = find(trimesh.creation.box((0.1, 0.1, 0.1)), n_samples=1, sigma=0.0)
    rng, found = np.random.default_rng(0), []
    for _ in range(5):
        order = rng.permutation(len(transforms))
        shaken = off_by_bits(transforms[order], rng), off_by_bits(probabilities[order], rng)
        monkeypatch.setattr(trimesh.poses, "compute_stable_poses", lambda *_, shaken=shaken, **__: shaken)
        found.append(as_numbers(resting_poses(trimesh.creation.box((0.1, 0.1, 0.1)))).tobytes())
    assert len(set(found)) == 1


@pytest.mark.parametrize("name", CURVES)
def test_the_last_bits_of_the_curves_change_nothing(name, monkeypatch):
    key, curves = CURVES[name]
    rng, before = np.random.default_rng(0), load_part(name)
    monkeypatch.setitem(sim.model.parts._GENERATORS, key, lambda **table: off_by_bits(curves(**table), rng))
    after = load_part(name)
    assert after.part.mesh.vertices.tobytes() == before.part.mesh.vertices.tobytes()
    assert [piece.vertices.tobytes() for piece in after.pieces] == [piece.vertices.tobytes() for piece in before.pieces]
    assert after.inertia.tobytes() == before.inertia.tobytes()
    assert as_numbers(after.resting_poses).tobytes() == as_numbers(before.resting_poses).tobytes()
