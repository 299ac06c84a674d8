import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from maskval import InvalidFileError, Mesh, Pose, SymmetryAxis, bop, rle_counts
from maskval.bop.detections import detection_of_mask
from maskval.bop.places import Place
from tests.maskval import shapes

POSES = shapes.random_poses(seed=30, count=3)


def assert_same_pose(X_AB: Pose, X_AB_expected: Pose) -> None:
    np.testing.assert_allclose(X_AB.matrix, X_AB_expected.matrix, rtol=0, atol=1e-14)


def test_results_survive_their_file(tmp_path) -> None:
    results = [bop.PoseResult(2, i, 5, 0.25 * i, X_CO, 0.5) for i, X_CO in enumerate(POSES)]
    bop.write_results(tmp_path / "ours_lm-test.csv", results)
    found = bop.read_results(tmp_path / "ours_lm-test.csv")
    assert [(r.scene_id, r.im_id, r.obj_id, r.score, r.time_s) for r in found] == [
        (2, i, 5, 0.25 * i, 0.5) for i in range(3)
    ]
    for result, X_CO in zip(found, POSES, strict=True):
        assert_same_pose(result.X_CO, X_CO)


def test_a_results_file_is_in_millimetres_with_nine_numbers_row_by_row(tmp_path) -> None:
    path = tmp_path / "results.csv"
    X_CO = Pose(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([0.1, -0.25, 0.5]))
    bop.write_results(path, [bop.PoseResult(1, 3, 7, 0.5, X_CO)])
    assert path.read_text().splitlines() == [
        "scene_id,im_id,obj_id,score,R,t,time",
        "1,3,7,0.5,0.0 -1.0 0.0 1.0 0.0 0.0 0.0 0.0 1.0,100.0 -250.0 500.0,-1.0",
    ]


def test_a_rotation_that_was_rounded_is_made_one_again(tmp_path) -> None:
    path = tmp_path / "results.csv"
    rotation = " ".join(f"{value:.4f}" for value in POSES[0].rotation.ravel())
    path.write_text(f"1,2,3,1.0,{rotation},1 2 3,-1\n")
    (result,) = bop.read_results(path)
    np.testing.assert_allclose(result.X_CO.rotation, POSES[0].rotation, rtol=0, atol=1e-4)
    np.testing.assert_allclose(result.X_CO.translation, (0.001, 0.002, 0.003), rtol=1e-15)


def test_scene_files_survive(tmp_path) -> None:
    truth = {0: [bop.GroundTruth(1, POSES[0]), bop.GroundTruth(2, POSES[1])], 7: []}
    bop.write_scene_gt(tmp_path / "scene_gt.json", truth)
    found = bop.read_scene_gt(tmp_path / "scene_gt.json")
    assert {im_id: [part.obj_id for part in parts] for im_id, parts in found.items()} == {0: [1, 2], 7: []}
    for part, expected in zip(found[0], truth[0], strict=True):
        assert_same_pose(part.X_CO, expected.X_CO)

    info = bop.GroundTruthInfo((-10, 5, 30, 40), (0, 5, 20, 40), 900, 600, 600, 600 / 900)
    hidden = bop.GroundTruthInfo((0, 0, 9, 9), (-1, -1, -1, -1), 81, 0, 0, 0.0)
    bop.write_scene_gt_info(tmp_path / "scene_gt_info.json", {0: [info, hidden]})
    assert bop.read_scene_gt_info(tmp_path / "scene_gt_info.json") == {0: [info, hidden]}

    cameras = {0: bop.ImageCamera(shapes.VGA.K, 0.1, POSES[2]), 7: bop.ImageCamera(shapes.VGA.K)}
    bop.write_scene_camera(tmp_path / "scene_camera.json", cameras)
    read = bop.read_scene_camera(tmp_path / "scene_camera.json")
    assert read[0].camera(640, 480) == shapes.VGA
    assert (read[0].depth_scale, read[7].depth_scale, read[7].X_CW) == (0.1, 1.0, None)
    assert_same_pose(read[0].X_CW, POSES[2])

    targets = [bop.EvaluationTarget(1, 2, 3, 4), bop.EvaluationTarget(1, 5, 3, 1)]
    bop.write_targets(tmp_path / "test_targets_bop19.json", targets)
    assert bop.read_targets(tmp_path / "test_targets_bop19.json") == targets


def test_a_scene_file_is_json_with_millimetres(tmp_path) -> None:
    path = tmp_path / "scene_gt.json"
    bop.write_scene_gt(path, {4: [bop.GroundTruth(9, Pose.from_translation((0.1, 0.2, 0.5)))]})
    assert json.loads(path.read_text()) == {
        "4": [{"cam_R_m2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_m2c": [100, 200, 500], "obj_id": 9}]
    }


def test_detections_survive_with_cocos_run_lengths(tmp_path) -> None:
    mask = np.zeros((6, 9), dtype=bool)
    mask[2:5, 3:8] = True
    path = tmp_path / "detections.json"
    bop.write_detections(path, [detection_of_mask(1, 2, 3, 0.75, mask), detection_of_mask(1, 2, 3, 0.5, mask & False)])
    first, second = json.loads(path.read_text())
    assert (first["image_id"], first["category_id"], first["bbox"]) == (2, 3, [3, 2, 8 - 3, 5 - 2])
    assert first["segmentation"] == {"counts": rle_counts(mask), "size": [6, 9]}
    assert second["bbox"] == [-1, -1, -1, -1]
    found = bop.read_detections(path)
    np.testing.assert_array_equal(found[0].mask, mask)
    assert (found[0].score, found[0].im_id, found[0].obj_id, found[0].time_s) == (0.75, 2, 3, -1.0)
    assert not found[1].mask.any()


def test_masks_and_depths_survive(tmp_path) -> None:
    mask = np.random.default_rng(0).random((40, 60)) > 0.5
    path = bop.mask_path(tmp_path / "000001", 3, 0)
    assert path == tmp_path / "000001" / "mask_visib" / "000003_000000.png"
    assert bop.mask_path(Path("s"), 12, 1, visible=False) == Path("s/mask/000012_000001.png")
    bop.write_mask(path, mask)
    np.testing.assert_array_equal(bop.read_mask(path), mask)

    depth = np.random.default_rng(1).random((40, 60))
    bop.write_depth(tmp_path / "depth.png", depth, depth_scale=0.1)
    # Rounded to steps of 0.1 mm.
    np.testing.assert_allclose(bop.read_depth(tmp_path / "depth.png", 0.1), depth, rtol=0, atol=0.05e-3 * 1.000001)


def test_a_model_survives_its_ply(tmp_path) -> None:
    mesh = Mesh(*shapes.star())
    bop.write_model(tmp_path / "obj_000001.ply", mesh)
    found = bop.read_model(tmp_path / "obj_000001.ply")
    np.testing.assert_allclose(found.vertices, mesh.vertices, rtol=1e-15)
    np.testing.assert_array_equal(found.faces, mesh.faces)


@pytest.mark.parametrize("order", ["<", ">"])
def test_a_binary_model_with_normals_colours_and_textures_is_read(tmp_path, order) -> None:
    name = {"<": "little", ">": "big"}[order]
    header = (
        f"ply\nformat binary_{name}_endian 1.0\ncomment TextureFile x.png\nelement vertex 3\n"
        "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty uchar red\n"
        "element face 1\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
    )
    vertex = np.dtype([("p", order + "f4", 3), ("nx", order + "f4"), ("red", "u1")])
    vertices = np.array([((0, 0, 0), 1, 9), ((100, 0, 0), 1, 9), ((0, 50, 0), 1, 9)], dtype=vertex)
    face = np.dtype([("n", "u1"), ("i", order + "i4", 3), ("m", "u1"), ("t", order + "f4", 6)])
    faces = np.array([(3, (0, 1, 2), 6, (0,) * 6)], dtype=face)
    path = tmp_path / "obj.ply"
    path.write_bytes(header.encode() + vertices.tobytes() + faces.tobytes())
    mesh = bop.read_model(path)
    np.testing.assert_allclose(mesh.vertices, [[0, 0, 0], [0.1, 0, 0], [0, 0.05, 0]], rtol=1e-7)
    assert mesh.faces.tolist() == [[0, 1, 2]]


def test_models_info_survives_with_its_symmetries(tmp_path) -> None:
    half_turn = Pose.from_rotvec((0, 0, np.pi), (0.01, 0, 0))
    axis = SymmetryAxis(np.array([0.0, 0, 1]), np.array([0.005, 0, 0]))
    mesh = shapes.cube(0.2)
    path = tmp_path / "models_info.json"
    bop.write_models_info(
        path,
        {1: (mesh, bop.ModelInfo(mesh.diameter, (half_turn,))), 2: (mesh, bop.ModelInfo(mesh.diameter, (), (axis,)))},
    )
    raw = json.loads(path.read_text())["1"]
    assert (raw["min_x"], raw["size_z"]) == (-100, 200)
    assert raw["symmetries_discrete"][0][3] == 10
    found = bop.read_models_info(path)
    assert found[1].diameter_m == pytest.approx(0.2 * np.sqrt(3))
    assert_same_pose(found[1].symmetries[0], half_turn)
    assert len(found[1].symmetry_poses()) == 2
    assert found[2].axes[0].offset_O.tolist() == [0.005, 0, 0]
    assert len(found[2].symmetry_poses()) == 315


EYE = "1 0 0 0 1 0 0 0 1"
PLY = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
INDEXED = PLY + "property list uchar int vertex_indices\nend_header\n"
CORNERS = "0 0 0\n1 0 0\n0 1 0\n"
GT = '{"0": [{"cam_R_m2c": [1,0,0,0,1,0,0,0,1], "cam_t_m2c": [0,0,1], "obj_id": 1}]}'
DETECTION = (
    '[{"scene_id": 1, "image_id": 2, "category_id": 3, "score": 1, "segmentation": {"counts": [6], "size": [2, 3]}}]'
)


def assert_refused(path: Path, read: Callable[[Path], object], content: str, words: str) -> None:
    path.write_text(content)
    with pytest.raises(InvalidFileError, match=words):
        read(path)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (f"1,2,3,1,{EYE},1 2 3\n", r"file:1:1: expected the 7 fields .*, but found 6"),
        (f"1,2,3,1,{EYE},1 2 3,-1\n1,x,3,1,{EYE},1 2 3,-1\n", r"file:2:3: expected im_id .* found 'x'"),
        (f"1,2,3,high,{EYE},1 2 3,-1", r"file:1:7: expected score as 1 finite numbers, but found 'high'"),
        ("1,2,3,1,1 0 0,1 2 3,-1", r"file:1:9: expected R as 9 finite numbers"),
        (f"1,2,3,1,{EYE},1 2 nan,-1", r"file:1:27: expected t as 3 finite numbers, but found '1 2 nan'"),
        ("1,2,3,1,2 0 0 0 1 0 0 0 1,1 2 3,-1", r"file:1:9: expected a rotation to 0.01.*differs by 1"),
        ("1,2,3,1,1 0 0 0 1 0 0 0 -1,1 2 3,-1", r"file:1:9: .*determinant"),
    ],
)
def test_malformed_results_are_refused_with_line_and_column(tmp_path, content, words) -> None:
    assert_refused(tmp_path / "file", bop.read_results, content, words)


@pytest.mark.parametrize(
    ("read", "content", "words"),
    [
        (bop.read_scene_gt, '{"0": [\n{"obj_id": }]}', r"file:2:12: expected JSON"),
        (bop.read_scene_gt, "[]", r"file:1:1: expected an object of entries by their id, but found \[\]"),
        (bop.read_scene_gt, '{"first": []}', r"file:1:1: expected whole numbers as keys, but found 'first'"),
        (bop.read_scene_gt, '{"0": {}}', r"file:1:7: 0: expected a list, but found \{\}"),
        (bop.read_scene_gt, GT.replace("obj_id", "object"), r"0: \[0\]: expected the field 'obj_id', .* cam_R_m2c"),
        (bop.read_scene_gt, GT.replace("[0,0,1]", "[0,1]"), r"0: \[0\]: cam_t_m2c: expected a list of 3 numbers"),
        (bop.read_scene_gt, GT.replace("[0,0,1]", '[0,1,"a"]'), r'\[2\]: expected a finite number, but found "a"'),
        (bop.read_scene_gt, GT.replace("[1,0", "[3,0"), r"\[0\]: cam_R_m2c: expected a rotation"),
        (bop.read_scene_gt, GT.replace(": 1}", ": 1.5}"), r"obj_id: expected a whole number, but found 1.5"),
        (bop.read_scene_camera, '{"0": {"cam_K": [1,0,0,2,1,0,0,0,1]}}', r"0: cam_K: K must be upper triangular"),
        (bop.read_targets, '[{"im_id": 1}]', r"\[0\]: expected the field 'scene_id', but found only im_id"),
        (bop.read_detections, DETECTION.replace("[6]", "6"), "counts: expected run lengths, a list .*, but found 6"),
        (
            bop.read_detections,
            DETECTION.replace("[6]", '"6P"'),
            "counts: compressed run lengths must end with a number",
        ),
        (bop.read_detections, DETECTION.replace("[6]", '"6~"'), "letters from '0' to 'o', but hold '~'"),
        (bop.read_detections, DETECTION.replace("[6]", "[7]"), r"counts: counts must add up to 2 x 3 = 6, but to 7"),
        (bop.read_detections, DETECTION.replace("[2, 3]", "[2]"), r"size: expected height and width"),
        (bop.read_models_info, '{"1": {"diameter": 0}}', r"1: diameter: expected a diameter > 0 mm, but found 0"),
    ],
)
def test_malformed_json_is_refused_with_its_place(tmp_path, read, content, words) -> None:
    assert_refused(tmp_path / "file", read, content, words)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("stl", r"file:1:1: expected a PLY file"),
        (PLY.replace("float y", "real y") + "end_header\n", r"file:5:1: expected a line .* 'property real y'"),
        (PLY.replace("format ascii 1.0\n", "") + "end_header\n", r"file:2:1: expected a format"),
        (INDEXED + CORNERS, r"file:13:1: expected 4 numbers of face 0, but found ''"),
        (INDEXED + CORNERS.replace("1 0 0", "1 0") + "3 0 1 2\n", r"file:11:1: expected 3 numbers of vertex 1"),
        (INDEXED + CORNERS.replace("1 0 0", "1") + "3 0 1 2\n", r"file:11:1: expected 3 numbers of vertex 1"),
        (INDEXED + CORNERS.replace("1 0 0", "1 0 a") + "3 0 1 2\n", r"file:11:1: .*, but found '1 0 a'"),
        (INDEXED + CORNERS + "4 0 1 2\n", r"file:13:1: expected a list of 3 \(triangles only\), .* of 4"),
        (INDEXED + CORNERS + "3 0 1 9\n", r"file: faces must index the 3 vertices, but face 0"),
        (INDEXED.replace("float x", "float a") + CORNERS + "3 0 1 2\n", "expected x, y, z and vertex_indices"),
        (INDEXED.replace("ascii", "binary_little_endian") + "xx", r"3 of vertex up to byte \d+, but found"),
    ],
)
def test_malformed_models_are_refused_with_their_line(tmp_path, content, words) -> None:
    assert_refused(tmp_path / "file", bop.read_model, content, words)


def test_the_place_in_a_json_file_is_its_line_and_column(tmp_path) -> None:
    lines = ('{"0": [],', ' "12": [{"cam_R_m2c": [1,0,0,0,1,0,0,0,1],', '   "cam_t_m2c": [0, 1, "a"]}]}')
    # The third element of the third line's list begins at its 24th letter.
    assert lines[2][24 - 1 :].startswith('"a"')
    words = r'scene_gt.json:3:24: 12: \[0\]: cam_t_m2c: \[2\]: expected a finite number, but found "a"'
    content = "\n".join(lines).replace("]}]}", '], "obj_id": 1}]}')
    assert_refused(tmp_path / "scene_gt.json", bop.read_scene_gt, content, words)


@pytest.mark.parametrize("key", ["a", 'b"\\n', "é", "]}"])
def test_the_place_of_a_value_is_found_past_others_of_every_kind(key) -> None:
    before = {"x": [1, {"y": "]}"}], "z": {}, "w": [], "n": None, "f": -1.5e3, "t": True}
    text = json.dumps({"outer": [before, {**before, key: 7}]}, indent=1)
    line, column = str(Place("file", text, ("outer", 1, key))).split(": ")[0].split(":")[1:]
    assert text.splitlines()[int(line) - 1][int(column) - 1 :] == "7"
    # JSON means the last of equal keys.
    assert str(Place("file", '{"a": 1, "a": 2}', ("a",))) == "file:1:15: a"


def test_images_that_are_no_masks_or_depths_are_refused(tmp_path) -> None:
    path = tmp_path / "image.png"
    with pytest.raises(InvalidFileError, match=r"image.png does not exist"):
        bop.read_mask(path)
    bop.write_depth(path, np.ones((4, 4)))
    with pytest.raises(InvalidFileError, match=r"image.png: expected a grey image of 0 and 255, but found uint16"):
        bop.read_mask(path)
    bop.write_mask(path, np.ones((4, 4), dtype=bool))
    with pytest.raises(InvalidFileError, match=r"expected a grey image of 16 bits, but found uint8 \(4, 4\)"):
        bop.read_depth(path)
    path.write_text("no image")
    with pytest.raises(InvalidFileError, match="expected an image, but it cannot be read as one"):
        bop.read_mask(path)
    with pytest.raises(ValueError, match="0 to 65,535 steps of 1 mm, but is up to 70000"):
        bop.write_depth(path, np.full((4, 4), 70.0))
