"""JSON files that other tools compress, cut off or overfill."""

import gzip
from pathlib import Path

import pytest

from maskval import InvalidFileError, bop
from maskval.bop.fields import read_json
from tests.maskval import bop_dataset


def compress(path: Path, to: Path) -> Path:
    to.write_bytes(gzip.compress(path.read_bytes()))
    return to


@pytest.mark.parametrize("name", ["detections.json.gz", "detections.json"])
def test_compressed_detections_are_the_plain_ones_whatever_their_name(tmp_path, name) -> None:
    _, plain = bop_dataset.write(tmp_path / "set")
    found, expected = bop.read_detections(compress(plain, tmp_path / name)), bop.read_detections(plain)
    assert len(found) == 2 * bop_dataset.IMAGES
    assert [(d.im_id, d.obj_id, d.rle) for d in found] == [(d.im_id, d.obj_id, d.rle) for d in expected]


def test_compressed_annotations_are_read_and_their_errors_have_a_place(tmp_path) -> None:
    bop_dataset.write(tmp_path)
    path = tmp_path / "test" / f"{bop_dataset.SCENE:06d}" / "scene_camera.json"
    assert bop.read_scene_camera(compress(path, path)).keys() == set(range(bop_dataset.IMAGES))
    path.write_bytes(gzip.compress(b'{"0":\n []}'))
    with pytest.raises(InvalidFileError, match=r"scene_camera.json:2:2: 0: expected an object"):
        bop.read_scene_camera(path)


WHOLE = gzip.compress(b"[]" * 100, mtime=0)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (WHOLE[:-6], "file: expected a whole gzip file: Compressed file ended"),
        (WHOLE[:2] + b"\7" + WHOLE[3:], "file: expected a whole gzip file: "),
        (WHOLE[:-8] + bytes(8), "file: expected a whole gzip file: CRC check failed"),
        (WHOLE[:12] + b"\xff" * 9, "file: expected a whole gzip file"),
        (b"\xff\xfe[]", "file: expected JSON: 'utf-8' codec can't decode"),
        (b"1" * 5000, "file: expected JSON: "),
        (b"[" * 200_000, "file: expected JSON: "),
    ],
)
def test_a_file_that_is_no_json_is_refused_with_its_name(tmp_path, content, words) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    with pytest.raises(InvalidFileError, match=words):
        read_json(path)
