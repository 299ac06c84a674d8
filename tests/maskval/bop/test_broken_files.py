"""Files that promise more than they hold, or hold numbers that no machine has room for: one clear error each."""

import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from maskval import InvalidFileError, InvalidMeshError, Mesh, bop
from maskval.bop.ply import read_ply
from maskval.masks import MAXIMUM_PIXELS
from tests.maskval import bop_dataset

VERTEX = "property float x\nproperty float y\nproperty float z\n"
FACE = "property list uchar int vertex_indices\n"
ROWS = "0 0 0\n100 0 0\n0 50 0\n3 0 1 2\n"


def ply(form: str = "ascii", vertices: str = "3", faces: str = "1", vertex: str = VERTEX, face: str = FACE) -> str:
    elements = f"element vertex {vertices}\n{vertex}element face {faces}\n{face}"
    return f"ply\nformat {form} 1.0\n{elements}end_header\n"


def refused(path: Path, content: str, words: str) -> None:
    path.write_text(content)
    with pytest.raises(InvalidFileError, match=words):
        bop.read_model(path)


@pytest.mark.parametrize("count", ["1000000000", "1000000000000", "9" * 18])
def test_a_text_model_that_promises_more_rows_than_it_has_lines_allocates_no_room_for_them(tmp_path, count) -> None:
    tracemalloc.start()
    try:
        refused(
            tmp_path / "file", ply(vertices=count) + ROWS, "file:13:1: expected 3 numbers of vertex 3, but found '3 0"
        )
        refused(tmp_path / "file", ply(faces=count) + ROWS, "file:14:1: expected 4 numbers of face 1, but found ''")
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 2**20


def test_rows_without_numbers_are_not_counted_to_the_end(tmp_path) -> None:
    empty = ply().replace("element face", "element nothing 1000000000\nelement face")
    refused(tmp_path / "file", empty + ROWS.replace("3 0 1 2\n", "\n"), "file:15:1: expected 0 numbers of nothing 1")


def test_a_binary_model_that_promises_more_rows_than_it_has_bytes_is_refused(tmp_path) -> None:
    refused(
        tmp_path / "file", ply("binary_little_endian", vertices="9" * 18), r"9{18} of vertex up to byte \d{20}, but"
    )


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (ply(vertices="1" * 19), "file:3:1: expected a line of a PLY header"),
        (ply(vertices="1" * 5000), "file:3:1: expected a line of a PLY header"),
        (ply(vertex=VERTEX + "property float x\n"), "file:7:1: .* 'property float x'"),
        (ply(vertex=VERTEX + "property list uchar int y\n"), "file:7:1: .* 'property list uchar int y'"),
        (ply("binary_big_endian", vertex=VERTEX + "property float x\n"), "file:7:1: .* 'property float x'"),
        (ply().replace("element face", "element vertex 1\nproperty float a\nelement face"), "file:7:1: .* vertex 1'"),
        ("ply\nformat ascii 1.0\nproperty float x\nend_header\n", "file:3:1: .* 'property float x'"),
        (ply()[:-1], "file:10:1: expected 3 numbers of vertex 0, but found ''"),
        (ply() + ROWS.replace("1 2\n", "1 1.7\n"), "file: expected whole numbers below 2\\^31 as vertex_indices"),
        (ply() + ROWS.replace("1 2\n", "1 nan\n"), "file: expected whole numbers below 2\\^31 as vertex_indices"),
        (ply() + ROWS.replace("1 2\n", "1 inf\n"), "file: expected whole numbers below 2\\^31 as vertex_indices"),
        (ply() + ROWS.replace("1 2\n", f"1 {2**31}\n"), "file: expected whole numbers below 2\\^31 as vertex_indices"),
        (ply() + ROWS.replace("1 2\n", f"1 {2**31 - 1}\n"), "file: faces must index the 3 vertices"),
        (
            ply() + ROWS.replace("100 0 0", "1e308 0 0"),
            r"file: vertices must be finite and within 1e\+100 m, but vertex 1",
        ),
    ],
)
def test_a_model_with_a_header_or_numbers_that_none_has_is_refused(tmp_path, content, words) -> None:
    refused(tmp_path / "file", content, words)


@pytest.mark.parametrize("place", [1.01e100, -1e308, np.inf, -np.inf, np.nan])
def test_a_vertex_beyond_all_measure_is_refused_before_its_square_overflows(place) -> None:
    with pytest.raises(InvalidMeshError, match=r"within 1e\+100 m, but vertex 2 is"):
        Mesh([[0, 0, 0], [1, 0, 0], [0, place, 0]], [[0, 1, 2]])
    with pytest.raises(InvalidMeshError, match=r"at most 10 m, but is 1e\+100 m: millimetres"):
        Mesh([[0, 0, 0], [1, 0, 0], [0, 1e100, 0]], [[0, 1, 2]])


def png(width: int, height: int) -> bytes:
    """A PNG file that begins as a grey image of this size."""

    def block(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    size = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + block(b"IHDR", size) + block(b"IDAT", zlib.compress(b"")) + block(b"IEND", b"")


@pytest.mark.parametrize("read", [bop.read_mask, bop.read_depth])
@pytest.mark.parametrize(("width", "height"), [(2**31 - 1, 2**31 - 1), (2**20, 2**10), (2**14 + 1, 2**14)])
def test_an_image_of_more_pixels_than_any_camera_has_is_refused_by_its_header(tmp_path, read, width, height) -> None:
    path = tmp_path / "image.png"
    path.write_bytes(png(width, height))
    words = f"image.png: expected at most {MAXIMUM_PIXELS} pixels, but found {width} x {height}"
    with pytest.raises(InvalidFileError, match=words):
        read(path)


def test_a_png_file_that_is_cut_off_in_its_header_is_no_image(tmp_path) -> None:
    path = tmp_path / "image.png"
    path.write_bytes(png(4, 4)[:20])
    with pytest.raises(InvalidFileError, match="expected an image, but it cannot be read as one"):
        bop.read_mask(path)


def test_masks_of_two_sizes_in_one_image_are_refused(tmp_path) -> None:
    bop_dataset.write(tmp_path)
    scene = tmp_path / "test" / f"{bop_dataset.SCENE:06d}"
    truths = bop.read_scene_gt(scene / "scene_gt.json")
    bop.write_scene_gt(scene / "scene_gt.json", {0: [truths[0][0], truths[0][0]]})  # two cubes in the first image
    bop.write_mask(bop.mask_path(scene, 0, 1), np.zeros((4, 4), dtype=bool))
    source = bop.SceneMasks(bop.Dataset(tmp_path))
    words = r"image 0: expected masks of one size, but found \[\(4, 4\), \(240, 320\)\]"
    with pytest.raises(InvalidFileError, match=words):
        source.masks(bop.ImageObject(bop_dataset.SCENE, 0, bop_dataset.CUBE))


DETECTION = (
    '[{"scene_id": 1, "image_id": 2, "category_id": 3, "score": 1, "segmentation": {"counts": [6], "size": [2, 3]}}]'
)
RESULT = "1,2,3,1,1 0 0 0 1 0 0 0 1,1 2 3,-1"


@pytest.mark.parametrize(
    ("read", "content", "words"),
    [
        (bop.read_detections, DETECTION.replace("[6]", str([2**62] * 3 + [2**62 + 6])), "counts: .* 6, but to 184467"),
        (bop.read_detections, DETECTION.replace("[2, 3]", "[1000000, 1000000]"), "counts: a mask must have 1 to"),
        (bop.read_detections, DETECTION.replace("[2, 3]", "[-2, -3]"), "counts: a mask must have 1 to"),
        (bop.read_detections, DETECTION.replace('_id": 1', f'_id": {2**63}'), "scene_id: expected a whole number, but"),
        (bop.read_detections, DETECTION.replace('re": 1', f're": {"1" * 400}'), "score: expected a finite number, but"),
        (
            bop.read_detections,
            DETECTION.replace('re": 1', 're": NaN'),
            "score: expected a finite number, but found NaN",
        ),
        (bop.read_scene_gt, '{"²": []}', "file:1:1: expected whole numbers as keys, but found '²'"),
        (bop.read_scene_gt, f'{{"{"1" * 19}": []}}', "file:1:1: expected whole numbers as keys"),
        (bop.read_results, RESULT.replace("1,2,", "1,²,"), "file:1:3: expected im_id as a whole number, but found '²'"),
        (bop.read_results, RESULT.replace("1,2,", f"1,{'2' * 5000},"), "file:1:3: expected im_id as a whole number"),
        (bop.read_results, RESULT.replace("1,2,", "1,ÿ,"), "file cannot be read: expected UTF-8 text"),
    ],
)
def test_numbers_that_no_file_of_bop_has_are_refused_with_their_place(tmp_path, read, content, words) -> None:
    path = tmp_path / "file"
    path.write_bytes(content.encode("latin-1" if "ÿ" in content else "utf-8"))
    with pytest.raises(InvalidFileError, match=words):
        read(path)


def test_folders_that_are_no_scenes_are_passed_over(tmp_path) -> None:
    bop_dataset.write(tmp_path)
    (tmp_path / "test" / "²").mkdir()
    assert bop.Dataset(tmp_path).scene_ids == [bop_dataset.SCENE]


def test_the_greatest_whole_numbers_are_read(tmp_path) -> None:
    path = tmp_path / "file"
    path.write_text(
        DETECTION.replace('scene_id": 1', f'scene_id": {2**63 - 1}').replace('e_id": 2', f'e_id": {2**63 - 1}')
    )
    (found,) = bop.read_detections(path)
    assert (found.scene_id, found.im_id) == (2**63 - 1, 2**63 - 1)
    path.write_text(ply() + ROWS)
    assert read_ply(path)[1].tolist() == [[0, 1, 2]]
