import pickle

import numpy as np
import pytest

from maskval import InvalidMeshError, Mesh, PackedMasks, Pose, depth_image
from tests.maskval import shapes

TRIANGLE = np.array([[0.0, 0, 0], [3, 0, 0], [0, 4, 0]])
FACE = np.array([[0, 1, 2]])


def test_bounds_and_diameter_of_a_cube() -> None:
    mesh = shapes.cube(0.2)
    np.testing.assert_array_equal(mesh.bounds, [[-0.1] * 3, [0.1] * 3])
    assert mesh.diameter == pytest.approx(0.2 * np.sqrt(3), rel=1e-15)


def test_the_diameter_is_the_greatest_distance_of_two_vertices() -> None:
    assert Mesh(TRIANGLE, FACE).diameter == 5
    rng = np.random.default_rng(0)
    for scale in ((1, 1, 1), (1, 0.2, 0.1), (1, 1, 0)):
        vertices = rng.normal(size=(700, 3)) * scale
        distances = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
        assert Mesh(vertices, rng.permutation(699).reshape(-1, 3)).diameter == distances.max()


def test_the_center_is_the_middle_of_the_box_and_not_the_mean_of_the_vertices() -> None:
    mesh = Mesh(np.array([[0.0, -1, 2], [3, 0, 2], [0, 4, 3]]), [[0, 1, 2]])
    assert mesh.center.tolist() == [(0 + 3) / 2, (-1 + 4) / 2, (2 + 3) / 2]


def test_nobody_can_write_to_the_center() -> None:
    with pytest.raises(ValueError, match="read-only"):
        shapes.cube().center[0] = 1


def test_a_closed_mesh_has_three_edges_for_two_faces_each_with_two_sides() -> None:
    vertices, faces = shapes.torus()
    edges = Mesh(vertices, faces).edges
    assert len(edges.tails) == 3 * len(faces) // 2
    assert (edges.rights < 2 * len(faces)).all()


def test_an_open_mesh_keeps_its_border_and_a_third_face_its_own_edge() -> None:
    sheet = shapes.square().edges
    assert len(sheet.tails) == 5
    assert np.count_nonzero(sheet.rights == 2 * 2) == 4
    # Three triangles around one edge: that edge twice, and two more of each triangle.
    fan = Mesh(
        np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]]), np.array([[0, 1, k] for k in (2, 3, 4)])
    )
    assert len(fan.edges.tails) == 2 + 3 * 2


def test_corners_at_one_place_are_welded_for_the_contour_only() -> None:
    vertices, faces = shapes.torus()
    soup = Mesh(vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3))
    assert len(soup.vertices) == 3 * len(faces)
    assert len(soup.edges.vertices_M) == len(vertices)
    assert len(soup.edges.tails) == 3 * len(faces) // 2


def test_vertices_of_no_face_do_not_count_for_the_contour() -> None:
    vertices, faces = shapes.torus()
    stray = Mesh(np.concatenate((vertices, [[0, 0, -3]])), faces)
    assert len(stray.vertices) == len(vertices) + 1
    assert stray.edges.radius == Mesh(vertices, faces).edges.radius
    X_CO = Pose.from_translation((0, 0, 0.6))
    np.testing.assert_array_equal(
        depth_image(stray, X_CO, shapes.VGA), depth_image(Mesh(vertices, faces), X_CO, shapes.VGA)
    )


def test_what_comes_out_of_a_pickle_is_the_same_and_not_writeable() -> None:
    mesh = shapes.cube()
    pose = shapes.random_poses(0, 1)[0]
    packed = PackedMasks.pack(np.eye(70, dtype=bool))
    mesh2, pose2, packed2 = pickle.loads(pickle.dumps((mesh, pose, packed)))
    np.testing.assert_array_equal(pose2.matrix, pose.matrix)
    for found, expected in ((mesh2.edges, mesh.edges), ((packed2.words,), (packed.words,))):
        for array, same in zip(found, expected, strict=True):
            np.testing.assert_array_equal(array, same)
    for array in (mesh2.vertices, mesh2.edges.planes_M, pose2.rotation, packed2.words):
        assert not array.flags.writeable


def test_nobody_can_write_to_a_mesh_and_it_keeps_copies() -> None:
    vertices = TRIANGLE.copy()
    mesh = Mesh(vertices, FACE)
    vertices[0, 0] = 7
    assert mesh.vertices[0, 0] == 0
    arrays = [mesh.vertices, mesh.faces, *(a for a in mesh.edges if isinstance(a, np.ndarray))]
    assert len(arrays) == 2 + 8
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (TRIANGLE, np.empty((0, 3), dtype=int), "at least one face, but has none"),
        (np.empty((0, 3)), np.empty((0, 3), dtype=int), "at least one face, but has none"),
        (TRIANGLE, [[0, 1, 3]], r"index the 3 vertices, but face 0 is \[0, 1, 3\]"),
        (TRIANGLE, [[0, 1, 2], [0, -1, 2]], r"index the 3 vertices, but face 1 is \[0, -1, 2\]"),
        (TRIANGLE, [[0, 1, 1]], "a face with an area, but its 0 faces have none"),
        (np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), FACE, "a face with an area, but its 1 faces have none"),
        (TRIANGLE, [[0, 1]], r"whole numbers \(F, 3\), but are int64 \(1, 2\)"),
        (TRIANGLE, [[0.0, 1, 2]], "whole numbers .* but are float64"),
        (TRIANGLE[:, :2], FACE, r"vertices must have shape \(V, 3\), but have \(3, 2\)"),
        (np.array([[0, 0, 0], [1, 0, np.nan], [0, 1, 0]]), FACE, "finite and .* but vertex 1 is"),
        (1000 * TRIANGLE, FACE, "at most 10 m, but is 5000 m: millimetres"),
    ],
)
def test_bad_meshes_are_refused(vertices, faces, words) -> None:
    with pytest.raises(InvalidMeshError, match=words):
        Mesh(vertices, faces)
