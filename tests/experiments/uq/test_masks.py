"""The masks that `graspcell uq` takes: those of the data set, and whole files in COCO's layout."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from maskval import bop
from tests.experiments.command import Told, command
from tests.maskval import bop_dataset
from tests.maskval.bop_dataset import CUBE, IMAGES, SCENE, STAR

IN_SCENE = f"test/{SCENE:06d}"
Change = Callable[[Path], object]


def arguments(folder: Path, masks: object) -> list[str]:
    results = folder / "ours_small-test.csv"
    given = ("--dataset", folder, "--results", results, "--masks", masks, "--resamples", 1)
    return ["uq", *map(str, given)]


def judged(capsys: pytest.CaptureFixture[str], folder: Path, masks: object) -> Told:
    return command(capsys, *arguments(folder, masks))


def polygons_of(mask: np.ndarray) -> list[list[int]]:
    """A rectangle for each run of pixels in a row: together they are the mask."""
    edges = np.diff(np.pad(mask.astype(int), ((0, 0), (1, 1))), axis=1)
    runs = zip(*np.nonzero(edges == 1), np.nonzero(edges == -1)[1], strict=True)
    return [[int(u), int(v), int(w), int(v), int(w), int(v) + 1, int(u), int(v) + 1] for v, u, w in runs]


def whole_coco(folder: Path) -> dict[str, Any]:
    """The detections as a tool for annotation exports them: polygons, ids from 1, and no scores."""
    found = bop.read_detections(folder / "detections.json")
    return {
        "info": {"description": "labelled by hand"},
        "images": [
            {"id": 1 + im_id, "file_name": f"{SCENE:06d}/rgb/{im_id:06d}.png", "height": 240, "width": 320}
            for im_id in range(IMAGES)
        ],
        "annotations": [
            {
                "id": 1 + index,
                "image_id": 1 + one.im_id,
                "category_id": one.obj_id,
                "segmentation": polygons_of(one.mask),
                "iscrowd": 0,
            }
            for index, one in enumerate(found)
        ],
        "categories": [{"id": CUBE, "name": "cube"}, {"id": STAR, "name": "star"}],
    }


def written(folder: Path, content: object, name: str = "coco.json") -> Path:
    (folder / name).write_text(json.dumps(content))
    return folder / name


def test_a_whole_coco_file_with_polygons_is_taken(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    expected = judged(capsys, tmp_path, tmp_path / "detections.json")
    assert expected.code == 0
    assert len(expected.out.splitlines()) == 1 + 2 * IMAGES
    assert judged(capsys, tmp_path, written(tmp_path, whole_coco(tmp_path))) == expected


def test_the_folder_of_a_coco_file_tells_the_scene_and_run_lengths_and_scores_are_taken(capsys, tmp_path) -> None:
    bop_dataset.write(tmp_path)
    content = whole_coco(tmp_path)
    rows = json.loads((tmp_path / "detections.json").read_text())
    for image in content["images"]:
        image.update(file_name=f"rgb/frame-{image['id']}.png", id=image["id"] - 1)
    for row, annotation in zip(rows, content["annotations"], strict=True):
        annotation.update(image_id=row["image_id"], segmentation=row["segmentation"], score=0.25)
    path = written(tmp_path / IN_SCENE, content)
    assert [one.score for one in bop.read_detections(path)] == [0.25] * 2 * IMAGES
    expected = judged(capsys, tmp_path, tmp_path / "detections.json")
    assert judged(capsys, tmp_path, path) == expected


def each(table: str, **values: object) -> Callable[[dict[str, Any]], object]:
    return lambda content: [row.update(values) for row in content[table]]


def lacking(table: str, name: str) -> Callable[[dict[str, Any]], object]:
    return lambda content: [row.pop(name) for row in content[table]]


COCO: list[tuple[Callable[[dict[str, Any]], object], str]] = [
    (
        lambda content: content.pop("images"),
        "expected the field 'images', but found only annotations, categories, info",
    ),
    (lambda content: content.pop("categories"), "expected the field 'categories'"),
    (lambda content: content.update(images=[]), r"image_id: expected the id of one of the images, but found 1"),
    (lambda content: content.update(images={}), "images: expected a list"),
    (lambda content: content.update(annotations=7), "annotations: expected a list, but found 7"),
    (lambda content: content.update(categories=[{"name": "a"}]), "expected the field 'id', but found only name"),
    (lambda content: content["images"].append(content["images"][0]), r"images: \[10\]: expected each image once"),
    (
        lambda content: content["images"][1].update(file_name=content["images"][0]["file_name"]),
        r"images: \[1\]: expected each image once, but id or file_name stand there twice",
    ),
    (lambda content: content["annotations"].append(content["annotations"][0]), "expected each detection once"),
    (lacking("images", "height"), "expected the field 'height'"),
    (lacking("images", "file_name"), "expected the field 'file_name'"),
    (lacking("annotations", "segmentation"), "expected the field 'segmentation'"),
    (lacking("annotations", "category_id"), "expected the field 'category_id'"),
    (each("images", file_name="000000.png"), r"file_name: expected SCENE/rgb/IMAGE.png, or this file in the folder of"),
    (each("images", file_name=3), "file_name: expected a text, but found 3"),
    (each("images", height=-1), "height: expected a whole number >= 0, but found -1"),
    (each("images", width=10**9), "a mask must have 1 to"),
    (each("images", height=480, width=640), r"masks of the image's 240 x 320 \(H x W\), got 480 x 640"),
    (each("annotations", category_id=2), "category_id: expected the id of one of the categories, but found 2"),
    (each("annotations", category_id="cube"), "category_id: expected a whole number"),
    (each("annotations", image_id=77), "image_id: expected the id of one of the images, but found 77"),
    (each("annotations", segmentation=[]), "segmentation: a mask must have at least one polygon"),
    (each("annotations", segmentation=[[1, 2]]), "segmentation: "),
    (each("annotations", segmentation=[[1, 2, None, 4, 5, 6]]), "expected a finite number, but found null"),
    (each("annotations", score="high"), "score: expected a finite number"),
]


@pytest.mark.parametrize(("change", "words"), COCO, ids=[f"{index}" for index in range(len(COCO))])
def test_a_spoilt_coco_file_ends_uq_with_one_line(capsys, tmp_path, change, words) -> None:
    bop_dataset.write(tmp_path)
    (tmp_path / "camera.json").write_text('{"height": 240, "width": 320}')
    content = whole_coco(tmp_path)
    change(content)
    refused(judged(capsys, tmp_path, written(tmp_path, content)), words)


def refused(told: Told, words: str) -> None:
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1), told.err
    assert re.search(words, told.err), told.err


def all_masks(change: Callable[[np.ndarray], np.ndarray], ending: str = "png", coding: str = ".png") -> Change:
    def spoil(folder: Path) -> None:
        files = sorted((folder / IN_SCENE / "mask_visib").iterdir())
        assert len(files) == 2 * IMAGES
        for file in files:
            image = change(cv2.imread(str(file), cv2.IMREAD_UNCHANGED))
            file.unlink()
            file.with_suffix(f".{ending}").write_bytes(cv2.imencode(coding, image)[1].tobytes())

    return spoil


def one_is_smaller(folder: Path) -> None:
    path = bop.mask_path(folder / IN_SCENE, 3, 1)
    bop.write_mask(path, bop.read_mask(path)[:200])


def as_it_is(image: np.ndarray) -> np.ndarray:
    return image


OWN: list[tuple[str, Change, str]] = [
    ("cut", all_masks(lambda image: image[:200]), r"masks of the image's 240 x 320 \(H x W\), got 200 x 320"),
    ("on their side", all_masks(lambda image: image.T), "got 320 x 240: height and width are swapped"),
    ("none of one size", all_masks(lambda image: image[:1, :1]), r"masks of the image's 240 x 320 .*, got 1 x 1"),
    ("grey", all_masks(lambda image: image // 2), "000000_000000.png: .* 0 and 255, but found 127, and"),
    ("0 and 1", all_masks(lambda image: image // 255), "0 and 255, but found 1, and"),
    ("in colour", all_masks(lambda image: np.dstack([image] * 3)), r"0 and 255, but found uint8 \(240, 320, 3\)"),
    ("16 bits", all_masks(lambda image: image.astype(np.uint16) * 257), r"0 and 255, but found uint16 \(240, 320\)"),
    (
        "JPEG",
        all_masks(as_it_is, "jpg", ".jpg"),
        r"000.png does not exist: .* PNG file, but found 000000_000000.jpg: JPEG",
    ),
    (
        "JPEG as PNG",
        all_masks(as_it_is, "png", ".jpg"),
        r"0 and 255, but found \d+, and \d+ pixels of other values in all",
    ),
    ("one smaller", one_is_smaller, r"240 x 320 .*, got 200 x 320"),
]


@pytest.mark.parametrize(("spoil", "words"), [row[1:] for row in OWN], ids=[row[0] for row in OWN])
def test_masks_of_the_data_set_that_are_none_or_of_another_size_end_uq_with_one_line(
    capsys, tmp_path, spoil, words
) -> None:
    bop_dataset.write(tmp_path)
    (tmp_path / "camera.json").write_text('{"height": 240, "width": 320}')
    spoil(tmp_path)
    refused(judged(capsys, tmp_path, "mask_visib"), words)


def test_who_reads_one_line_only_closes_the_pipe_and_sees_no_traceback(tmp_path: Path) -> None:
    bop_dataset.write(tmp_path)
    program = [sys.executable, "-m", "experiments.cli", *arguments(tmp_path, tmp_path / "detections.json")]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as uq:
        with subprocess.Popen(["head", "-c", "0"], stdin=uq.stdout) as head:
            assert uq.stdout is not None
            uq.stdout.close()
            head.wait()
        assert uq.stderr is not None
        told = uq.stderr.read()
    assert uq.returncode == 141
    assert "Traceback" not in told
    assert "Error" not in told
