import json
from pathlib import Path

import pytest

from sim.errors import NetworkError
from sim.learned.weights import load_networks, networks_of, open_network

MANIFEST = {
    "format": 1,
    "part": "antenna",
    "box_m": [-0.1, -0.1, 0.0, 0.1, 0.1, 0.1],
    "detector_s": 0.02,
    "pose_s": 0.03,
    "correspondence_weight": {"s1": 0.01, "s2": 0.03},
    "training": {"pictures": 3000},
}


def written(folder: Path, **changes: object) -> Path:
    content = {name: value for name, value in {**MANIFEST, **changes}.items() if value is not None}
    (folder / "manifest.json").write_text(json.dumps(content))
    return folder


def test_a_manifest_is_read_as_it_was_written(tmp_path: Path) -> None:
    manifest = load_networks(written(tmp_path)).manifest
    assert manifest.correspondence_weight == {"s1": 0.01, "s2": 0.03}
    assert (manifest.part, manifest.detector_s, manifest.pose_s) == ("antenna", 0.02, 0.03)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"format": 2}, ["expected format 1, got 2"]),
        ({"format": None}, ["expected what `graspcell train` writes", "format"]),
        ({"pose_s": None}, ["expected what `graspcell train` writes", "pose_s"]),
        ({"extra": 1}, ["expected what `graspcell train` writes", "extra"]),
        ({"detector_s": "fast"}, ["expected what `graspcell train` writes", "fast"]),
        ({"correspondence_weight": {"s1": 0.01}}, ["settings for s1, s2"]),
        ({"correspondence_weight": [1, 2]}, ["expected what `graspcell train` writes"]),
        ({"box_m": [0.0]}, ["finite numbers"]),
        ({"pose_s": float("inf")}, ["finite numbers"]),
    ],
)
def test_an_unfit_manifest_is_refused(tmp_path: Path, changes: dict[str, object], words: list[str]) -> None:
    with pytest.raises(NetworkError) as error:
        load_networks(written(tmp_path, **changes))
    assert all(word in str(error.value) for word in ("manifest.json", *words))


def test_a_manifest_that_is_no_json_is_refused(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text("[")
    with pytest.raises(NetworkError, match="expected what `graspcell train` writes"):
        load_networks(tmp_path)


def test_missing_networks_name_the_command_that_makes_them(tmp_path: Path) -> None:
    for folder in (None, tmp_path):
        with pytest.raises(NetworkError, match=r"expected trained networks in .*`graspcell train` makes"):
            networks_of("bracket", folder)


def test_a_file_that_is_no_network_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "s1.onnx"
    path.write_bytes(b"no network")
    with pytest.raises(NetworkError, match=r"s1\.onnx: expected a network in ONNX"):
        open_network(path)
    with pytest.raises(NetworkError, match=r"detector\.onnx"):
        open_network(tmp_path / "detector.onnx")
