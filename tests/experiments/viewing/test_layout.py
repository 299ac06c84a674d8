"""What the Rerun viewer is given to shade bodies by."""

import numpy as np
import trimesh

from experiments.viewing.layout import faceted


def test_each_face_has_corners_of_its_own_and_the_normal_that_looks_outwards() -> None:
    box = trimesh.creation.box((2.0, 4.0, 6.0))
    corners, normals = faceted(box.vertices, box.faces)
    assert corners.shape == normals.shape == (3 * 12, 3)
    assert np.array_equal(corners.reshape(-1, 3, 3), box.vertices[box.faces])
    for corner, normal in zip(corners, normals, strict=True):
        assert sorted(np.abs(normal)) == [0, 0, 1]
        assert corner @ normal == np.abs(normal) @ (1.0, 2.0, 3.0)  # a side of the box, seen from its middle


def test_a_face_without_area_has_no_normal() -> None:
    _, normals = faceted(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    assert not normals.any()
