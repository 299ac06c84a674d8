import numpy as np
import pytest
import trimesh

from sim.scenery.solids import Solid, box, merged, rod

SOLIDS = {
    "box": (box((0.1, 0.2, 0.3), (0.04, 0.06, 0.20), 0.003), (0.04, 0.06, 0.20), 0.04 * 0.06 * 0.20),
    "box along x": (box((0.1, 0.2, 0.3), (0.2, 0.06, 0.04), 0.001, axis=0), (0.2, 0.06, 0.04), 0.2 * 0.06 * 0.04),
    "rod": (rod((0.1, 0.2, 0.2), (0.1, 0.2, 0.4), 0.05), (0.1, 0.1, 0.2), np.pi * 0.05**2 * 0.2),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_has_its_size_and_nearly_its_volume(name: str) -> None:
    solid, size, volume = SOLIDS[name]
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    assert high - low == pytest.approx(size, rel=1e-9)
    assert (low + high) / 2 == pytest.approx([0.1, 0.2, 0.3], abs=1e-9)
    # Fillets of r take (4 - pi) r² per edge pair: less than 3 % of these.
    assert trimesh.Trimesh(solid.vertices, solid.faces).volume == pytest.approx(volume, rel=0.03)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_solid_is_closed_and_its_normals_point_outwards(name: str) -> None:
    solid, _, _ = SOLIDS[name]
    whole = trimesh.Trimesh(solid.vertices, solid.faces)
    whole.merge_vertices(digits_vertex=9)
    whole.update_faces(whole.nondegenerate_faces())
    assert whole.is_watertight
    assert np.linalg.norm(solid.normals, axis=1) == pytest.approx(1.0)
    corners, outwards = solid.vertices[solid.faces], solid.normals[solid.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    is_face = np.linalg.norm(across, axis=1) > 1e-12
    assert is_face.sum() > 50
    assert (np.einsum("fi,fvi->fv", across, outwards)[is_face] > 0).all()


def test_a_brushed_bars_second_direction_runs_along_it() -> None:
    bar = box((0.0, 0.0, 0.0), (0.03, 1.0, 0.09), 0.003, axis=1)
    sides = np.abs(bar.normals[:, 1]) < 1e-9
    assert sides.sum() > 20
    assert bar.uv[sides, 1] == pytest.approx(bar.vertices[sides, 1] + 0.5)


def test_merged_solids_keep_their_faces() -> None:
    one, other, _ = (solid for solid, _, _ in SOLIDS.values())
    both = merged([one, other])
    assert isinstance(both, Solid)
    assert np.array_equal(both.vertices[both.faces[: len(one.faces)]], one.vertices[one.faces])
    assert np.array_equal(both.vertices[both.faces[len(one.faces) :]], other.vertices[other.faces])
