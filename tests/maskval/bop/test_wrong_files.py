"""Files of BOP that hold nonsense: each is one error that names the file, and none is read as if nothing were wrong."""

import gzip
import os
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from maskval import ImplausibleInputWarning, InvalidFileError, bop
from maskval.bop import fields
from tests.maskval.bop_dataset import write

RESULT = "1,2,3,0.5,1 0 0 0 1 0 0 0 1,1 2 600,-1\n"
DETECTION = (
    '{"scene_id": 1, "image_id": 2, "category_id": 3, "score": 0.5, "segmentation": {"counts": [6], "size": [2, 3]}}'
)
POLYGONS = DETECTION.replace('{"counts": [6], "size": [2, 3]}', "[[0, 0, 2, 0, 2, 2]]")
TRUTH = '{"0": [{"cam_R_m2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_m2c": [1, 2, 600], "obj_id": 1}]}'
INFO = (
    '{"0": [{"bbox_obj": [1, 2, 3, 4], "bbox_visib": [1, 2, 3, 4], "px_count_all": 9, "px_count_valid": 9, '
    '"px_count_visib": 9, "visib_fract": 1.0}]}'
)
CAMERA = '{"0": {"cam_K": [300, 0, 160, 0, 300, 120, 0, 0, 1], "depth_scale": 1.0}}'
TARGET = '[{"im_id": 0, "inst_count": 1, "obj_id": 1, "scene_id": 2}]'
MODELS = (
    '{"1": {"diameter": 100, "symmetries_discrete": [[-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]], '
    '"symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}}'
)
MODEL = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n100 0 0\n0 50 0\n3 0 1 2\n"
)


def polygons(path: Path) -> object:
    return bop.read_detections(path, lambda scene_id, im_id: (4, 6))


# For each kind of file: what reads it, a right one, and (what to replace, by what, words of the error).
KINDS: dict[str, tuple[Callable[[Path], object], str, list[tuple[str, str, str]]]] = {
    "results": (
        bop.read_results,
        RESULT,
        [
            ("1,2,3", "-1,2,3", ":1:1: expected scene_id as a whole number"),
            ("1,2,3", "1,-2,3", ":1:3: expected im_id"),
            ("1,2,3", "1,2,3.0", ":1:5: expected obj_id"),
            ("1,2,3", "1,2,١", ":1:5: expected obj_id"),
            ("1,2,3", "1_0,2,3", ":1:1: expected scene_id"),
            ("1,2,3", "1,0x2,3", ":1:3: expected im_id"),
            ("0.5", "0_5", ":1:7: expected score as 1 finite numbers"),
            ("0.5", "٠", ":1:7: expected score"),
            ("0.5", "", ":1:7: expected score"),
            ("0.5", "nan", ":1:7: expected score"),
            ("0.5", "9" * 400, ":1:7: expected score"),
            ("0.5", "1e400", ":1:7: expected score"),
            ("1 2 600", "1 2", ":1:29: expected t as 3 finite numbers"),
            ("1 2 600", "1 2 6e300", ":1:11: expected a translation within 1e\\+10 mm"),
            ("1 2 600", "1e300 2 600", "expected a translation within"),
            ("1 2 600", "1 2 inf", ":1:29: expected t"),
            ("1 2 600", "1 2 6_00", ":1:29: expected t"),
            ("1 0 0 0 1 0 0 0 1", "1 0 0 0 1 0 0 0 -1", "determinant"),
            ("1 0 0 0 1 0 0 0 1", "0 0 0 0 0 0 0 0 0", "expected a rotation to 0.01"),
            ("1 0 0 0 1 0 0 0 1", "1e200 0 0 0 1e200 0 0 0 1e200", "expected a rotation to 0.01"),
            ("1 0 0 0 1 0 0 0 1", "1000 0 0 0 1000 0 0 0 1000", "expected a rotation to 0.01"),
            ("1 0 0 0 1 0 0 0 1", "1 0 0 0", "expected R as 9 finite numbers"),
            (",-1", ",-5", ":1:37: expected time as seconds >= 0, or -1"),
            (",-1", ",x", ":1:37: expected time"),
            ("\n", "\n" + RESULT, ":2:1: expected each pose once, but this is that of line 1"),
            ("1,2,3,", "1;2;3;", ":1:1: expected the 7 fields"),
        ],
    ),
    "detections": (
        bop.read_detections,
        f"[{DETECTION}]",
        [
            ('scene_id": 1', 'scene_id": -1', "scene_id: expected a whole number >= 0, but found -1"),
            ('image_id": 2', 'image_id": -2', "image_id: expected a whole number >= 0"),
            ('category_id": 3', 'category_id": -3', "category_id: expected a whole number >= 0"),
            ('category_id": 3', 'category_id": "3"', "category_id: expected a whole number"),
            ('category_id": 3', 'category_id": true', "category_id: expected a whole number"),
            ('category_id": 3', 'category_id": 3.0', "category_id: expected a whole number"),
            ("0.5", "null", "score: expected a finite number"),
            ("0.5", "Infinity", "score: expected a finite number"),
            ("0.5", "9" * 5000, "expected JSON: Exceeds the limit"),
            ("0.5", "9" * 400, "score: expected a finite number"),
            ("[6]", "[-6]", "counts: counts must be whole numbers >= 0"),
            ("[6]", "[3, -3, 6]", "counts: counts must be whole numbers >= 0"),
            ("[6]", "[7]", "must add up to 2 x 3 = 6, but to 7"),
            ("[6]", "[]", "must add up to"),
            ("[6]", "6", "counts: expected run lengths"),
            ("[6]", '"é"', "compressed run lengths must be letters"),
            ("[2, 3]", "[2, -3]", "a mask must have 1 to"),
            ("[2, 3]", "[0, 0]", "a mask must have 1 to"),
            ("[2, 3]", "[2]", "size: expected height and width"),
            ("[2, 3]", "[2, 3, 1]", "size: expected height and width"),
            ("[2, 3]", '{"h": 2}', "size: expected a list"),
            ('{"counts"', '{"size": [2, 3], "counts"', "an object with each key once, but 'size'"),
            ('"score": 0.5', '"score": 0.5, "time": -3', "time: expected seconds >= 0, or -1"),
            ('{"counts": [6], "size": [2, 3]}', "[]", "segmentation: expected run lengths, or image_size for polygons"),
            ('{"counts": [6], "size": [2, 3]}', "null", "segmentation: expected an object"),
            (f"[{DETECTION}]", f"[{DETECTION}, {DETECTION}]", r"\[1\]: expected each detection once, but .* \[0\]"),
            (f"[{DETECTION}]", DETECTION, ":1:1: expected a list"),
            (f"[{DETECTION}]", "[" * 10_000 + "]" * 10_000, "expected JSON: maximum recursion depth"),
            (f"[{DETECTION}]", '{"a":' * 10_000 + "1" + "}" * 10_000, "expected JSON: maximum recursion depth"),
            (f"[{DETECTION}]", "[" * 700 + "]" * 700, "expected an object, but found"),
            (f"[{DETECTION}]", "", "expected JSON"),
        ],
    ),
    "polygons": (
        polygons,
        f"[{POLYGONS}]",
        [
            ("[[0, 0, 2, 0, 2, 2]]", "[]", "segmentation: a mask must have at least one polygon"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[]]", "u and v of at least 3 corners, but has 0"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[0, 0, 2, 0]]", "at least 3 corners, but has 4"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[0, 0, 2, 0, 2, 2, 3]]", "at least 3 corners, but has 7"),
            ("[[0, 0, 2, 0, 2, 2]]", "[0, 0, 2, 0, 2, 2]", r"\[0\]: expected a list"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[0, 0, 2, 0, 2, 1e300]]", "must lie in the image of 4 x 6"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[0, 0, 2, 0, 2, 9]]", "must lie in the image of 4 x 6"),
            ("[[0, 0, 2, 0, 2, 2]]", '[[0, 0, 2, 0, 2, "2"]]', "expected a finite number"),
            ("[[0, 0, 2, 0, 2, 2]]", "[[0, 0, 2, 0, 2, NaN]]", "expected a finite number"),
        ],
    ),
    "true poses": (
        bop.read_scene_gt,
        TRUTH,
        [
            ('"0"', '"-1"', "expected whole numbers as keys, but found '-1'"),
            ('"0"', '"²"', "expected whole numbers as keys"),
            ('"0"', '"١"', "expected whole numbers as keys"),
            ('"0"', '"1_0"', "expected whole numbers as keys"),
            ('obj_id": 1', 'obj_id": -1', "obj_id: expected a whole number >= 0"),
            ("[1, 2, 600]", "[1, 2, 1e300]", "expected a translation within 1e\\+10 mm"),
            ("[1, 2, 600]", "[1, 2]", "cam_t_m2c: expected a list of 3 numbers"),
            ('{"0": [', '{"0": [], "0": [', "an object with each key once, but '0'"),
        ],
    ),
    "infos": (
        bop.read_scene_gt_info,
        INFO,
        [
            ('px_count_all": 9', 'px_count_all": -9', "px_count_all: expected a whole number >= 0"),
            ('px_count_valid": 9', 'px_count_valid": -1', "px_count_valid: expected a whole number >= 0"),
            ('px_count_visib": 9', 'px_count_visib": 10', "px_count_visib: expected at most the 9 of px_count_all"),
            ('visib_fract": 1.0', 'visib_fract": -0.1', r"visib_fract: expected a share in \[0, 1\]"),
            ('bbox_obj": [1, 2, 3, 4]', 'bbox_obj": [1.5, 2, 3, 4]', "bbox_obj: .*expected a whole number"),
        ],
    ),
    "cameras": (
        bop.read_scene_camera,
        CAMERA,
        [
            ('depth_scale": 1.0', 'depth_scale": 0', "depth_scale: expected a scale > 0 mm"),
            ('depth_scale": 1.0', 'depth_scale": -1', "depth_scale: expected a scale > 0 mm"),
            ('depth_scale": 1.0', 'depth_scale": NaN', "depth_scale: expected a finite number"),
            ("[300,", "[0,", "cam_K: fx must be > 0 px"),
            ("[300,", "[1e300,", r"cam_K: expected intrinsics within 1e\+07 px"),
            ("160,", "-1e9,", r"cam_K: expected intrinsics within 1e\+07 px"),
            ("0, 0, 1]", "0, 0, 2]", "cam_K: K must be upper triangular"),
            ('"depth_scale": 1.0', '"cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1]', "expected the field 'cam_t_w2c'"),
        ],
    ),
    "targets": (
        bop.read_targets,
        TARGET,
        [
            ('im_id": 0', 'im_id": -1', "im_id: expected a whole number >= 0"),
            ('obj_id": 1', 'obj_id": -1', "obj_id: expected a whole number >= 0"),
            ('inst_count": 1', 'inst_count": -1', "inst_count: expected a whole number >= 0"),
            ('scene_id": 2', 'scene_id": null', "scene_id: expected a whole number"),
        ],
    ),
    "models": (
        bop.read_models_info,
        MODELS,
        [
            ("0, 0, 0, 1]]", "0, 0, 0, 2]]", "expected a symmetry whose last row is 0 0 0 1"),
            ("0, 0, 0, 1]]", "0, 0, 1, 1]]", "expected a symmetry whose last row is 0 0 0 1"),
            ("[[-1, 0", "[[-2, 0", "expected a rotation to 0.01"),
            ('"1": {', '"-1": {', "expected whole numbers as keys"),
            ("100", "0", "diameter: expected a diameter > 0 mm"),
            ("100", "-100", "diameter: expected a diameter > 0 mm"),
            ("[0, 0, 1], ", "[0, 0, 0], ", "axis: expected a direction"),
            ("[0, 0, 0]}", "[0, 0]}", "offset: expected a list of 3 numbers"),
        ],
    ),
    "a model": (
        bop.read_model,
        MODEL,
        [
            ("vertex 3", "vertex ٣", ":3:1: expected a line of a PLY header"),
            ("vertex 3", "vertex -3", ":3:1: expected a line of a PLY header"),
            ("vertex 3", "vertex 1000000000", "expected 3 numbers of vertex 3"),
            ("100 0 0", "1_00 0 0", ":11:1: expected 3 numbers of vertex 1, but found '1_00 0 0'"),
            ("3 0 1 2", "3 0 1 3", "faces must index the 3 vertices"),
            ("100 0 0\n0 50 0", "1e8 0 0\n0 50 0", "the diameter must be at most 10 m"),
            ("vertex 3", "vertex 0", "expected 4 numbers of face 0"),
            (MODEL[MODEL.index("0 0 0") :], "", ":10:1: expected 3 numbers of vertex 0"),
            (MODEL[MODEL.index("\nend_header") :], "\nend_header", ":10:1: expected 3 numbers of vertex 0"),
            (
                MODEL[MODEL.index("format") :],
                "format binary_little_endian 1.0\nelement vertex 1000000000\nend_header\n",
                "expected properties of the 1000000000 vertex",
            ),
        ],
    ),
}
ROWS = [(kind, old, new, words) for kind, (_, _, rows) in KINDS.items() for old, new, words in rows]


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_table_spoils_is_read_as_long_as_it_is_whole(tmp_path: Path, kind: str) -> None:
    read, whole, rows = KINDS[kind]
    (tmp_path / "file").write_text(whole)
    assert read(tmp_path / "file")
    assert len(rows) >= 4


@pytest.mark.parametrize(("kind", "old", "new", "words"), ROWS, ids=range(len(ROWS)))
def test_nonsense_in_a_file_is_one_error_that_names_it(
    tmp_path: Path, kind: str, old: str, new: str, words: str
) -> None:
    read, whole, _ = KINDS[kind]
    assert old in whole
    (tmp_path / "file").write_text(whole.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InvalidFileError, match=words) as raised:
        read(tmp_path / "file")
    assert str(raised.value).startswith(str(tmp_path / "file"))
    assert "\n" not in str(raised.value)


def test_the_table_is_as_long_as_promised() -> None:
    assert len(ROWS) >= 100


@pytest.mark.parametrize("read", [*(read for read, _, _ in KINDS.values()), bop.read_mask, bop.read_depth])
def test_only_regular_files_are_read(tmp_path: Path, read: Callable[[Path], object]) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, kind in ((tmp_path / "pipe", "a pipe"), (Path("/dev/zero"), "a device"), (tmp_path, "a folder")):
        with pytest.raises(InvalidFileError, match=f"{path}: expected a regular file, got {kind}"):
            read(path)
    with pytest.raises(InvalidFileError, match="nowhere does not exist"):
        read(tmp_path / "nowhere")


@pytest.mark.parametrize("name", ["models/obj_000001.ply", "models/models_info.json", "test/000002/scene_gt.json"])
def test_a_pipe_in_a_data_set_is_refused_instead_of_waited_for(tmp_path: Path, name: str) -> None:
    write(tmp_path)
    (tmp_path / name).unlink()
    os.mkfifo(tmp_path / name)
    dataset = bop.Dataset(tmp_path)
    with pytest.raises(InvalidFileError, match=f"{name}: expected a regular file, got a pipe"):
        _ = dataset.mesh(1), dataset.models(), dataset.scene(2)


@pytest.mark.parametrize(
    ("read", "content"),
    [
        (bop.read_results, RESULT.replace("0.5", "2")),
        (bop.read_results, RESULT.replace("0.5", "-1")),
        (bop.read_detections, f"[{DETECTION.replace('0.5', '2')}]"),
        (bop.read_detections, f"[{DETECTION.replace('0.5', '-1')}]"),
    ],
)
def test_scores_that_are_no_confidences_are_read_with_a_warning(tmp_path: Path, read, content: str) -> None:
    (tmp_path / "file").write_text(content)
    with pytest.warns(ImplausibleInputWarning, match=r"file: expected scores in 0\.\.1, got (2 to 2|-1 to -1)"):
        assert len(read(tmp_path / "file")) == 1


def test_a_small_gzip_file_does_not_fill_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fields, "MOST_RESULTS", 1000)
    (tmp_path / "file").write_bytes(gzip.compress(b" " * 1001))
    with pytest.raises(InvalidFileError, match="file: expected at most 1000 bytes once unpacked"):
        bop.read_detections(tmp_path / "file")
    (tmp_path / "file").write_bytes(gzip.compress(b"[]".ljust(1000)))
    assert bop.read_detections(tmp_path / "file") == []


def test_polygons_are_the_masks_that_coco_draws(tmp_path: Path) -> None:
    # COCO's corners are those of the pixels: (0, 0) to (4, 2) covers columns 0 to 3 of rows 0 and 1.
    (tmp_path / "file").write_text(
        f"[{POLYGONS.replace('[[0, 0, 2, 0, 2, 2]]', '[[0, 0, 4, 0, 4, 2, 0, 2], [5, 3, 6, 3, 6, 4, 5, 4]]')}]"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        (found,) = bop.read_detections(tmp_path / "file", lambda scene_id, im_id: (4, 6) if im_id == 2 else (1, 1))
    assert found.mask.tolist() == [[(v < 2 and u < 4) or (u, v) == (5, 3) for u in range(6)] for v in range(4)]
