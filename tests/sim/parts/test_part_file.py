"""What a part's file may hold: each wrong value is one line that names the key, the value and what is valid."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from sim.errors import PartFileError
from sim.model.parts import load_part
from sim.parts.part_checks import warnings_of

TEXT = """
name = "brick"
mass_kg = 0.2
friction = 0.6
rgba = [0.5, 0.1, 0.1, 1.0]
specular = 0.1
shininess = 0.1
noise = "handle"
[mesh]
file = "brick.stl"
[slot]
size_mm = [200, 120]
[[grasps]]
name = "top"
tcp_mm = [0, 0, 5]
approach = [0, 0, -1]
closing = [0, 1, 0]
half_opening_mm = 45
"""
BOX = trimesh.creation.box((0.1, 0.05, 0.02))


def brick(folder: Path, text: str = TEXT, surface: trimesh.Trimesh = BOX) -> str:
    surface.export(folder / "brick.stl")
    (folder / "brick.toml").write_text(text)
    return str(folder / "brick.toml")


def refusal(folder: Path, text: str = TEXT, surface: trimesh.Trimesh = BOX) -> str:
    name = brick(folder, text, surface)
    with pytest.raises(PartFileError) as caught:
        load_part(name)
    message = str(caught.value)
    assert message.startswith(name)
    assert "\n" not in message
    return message


VALUES = [
    ("mass_kg = 0.2", f"mass_kg = {value}", "mass_kg: expected a number in 0.001..8, got ")
    for value in ("true", "150", "1e-300", "1e300", "inf", "nan", '"heavy"', "[1]", "-0.2", "0")
]
VALUES += [
    ("friction = 0.6", f"friction = {value}", "friction: expected a number in 0.05..2, got ")
    for value in ("inf", "1e300", "0", "-1", "false", "'steel'")
]
VALUES += [
    (f"{key} = 0.1", f"{key} = {value}", f"{key}: expected a number in 0..1, got {value}")
    for key in ("specular", "shininess")
    for value in ("nan", "-1", "5")
]
VALUES += [
    ("rgba = [0.5, 0.1, 0.1, 1.0]", f"rgba = {value}", words)
    for value, words in (
        ("[-5, 9, 0, 2]", "rgba[0]: expected a number in 0..1, got -5"),
        ("[0, 0, 0, 2]", "rgba[3]: expected a number in 0..1, got 2"),
        ("[0, 0, 0]", "rgba: expected 4 numbers"),
        ("'red'", "rgba: expected 4 numbers, got 'red'"),
    )
]
VALUES += [
    ("size_mm = [200, 120]", f"size_mm = {value}", words)
    for value, words in (
        ("[1, 1]", "slot.size_mm[0]: expected a number in 20..500, got 1"),
        ("[200, 1e9]", "slot.size_mm[1]: expected a number in 20..500, got 1000000000.0"),
        ("200", "slot.size_mm: expected 2 numbers, got 200"),
        ("[90, 120]", "slot.size_mm: expected at least [100.0, 50.0], the part in its stable pose 0"),
        ("[200, 120]\ndepth_mm = 3", "unknown key 'slot.depth_mm': expected size_mm"),
    )
]
VALUES += [
    ('name = "brick"', f"name = {value}", "name: expected 1 to 60 letters")
    for value in ('""', "3", '["a"]', '"../../x"', '"a\\nb"', '"a\\u0000b"', '"<worldbody/>"', f'"{"a" * 10_000}"')
]
for path in ("../../etc/passwd", "/etc/passwd", "../brick.stl", "sub/../../brick.stl"):
    WORDS = f"expected a file in the folder of the part's file, got '{path}'"
    VALUES += [
        ('"brick.stl"', f'"{path}"', f"mesh.file: {WORDS}"),
        ('"brick.stl"', f'"brick.stl"\npieces = ["brick.stl", "{path}"]', f"mesh.pieces[1]: {WORDS}"),
    ]
VALUES += [
    ('name = "brick"', 'name = "antenna"', "name: expected another one than those of the shipped parts"),
    ('noise = "handle"', "noise = 3", "noise: expected a printable text"),
    ('noise = "handle"', "color = 3", "unknown key 'color': expected name, mass_kg"),
    ('[mesh]\nfile = "brick.stl"', 'mesh = "brick.stl"', "mesh: expected a table, got 'brick.stl'"),
    ('file = "brick.stl"', "file = 3", "mesh.file: expected a printable text"),
    ('file = "brick.stl"', "pieces = []", "mesh.file is missing"),
    ('file = "brick.stl"', 'file = "brick.toml"', "expected one file with the whole mesh"),
    ('file = "brick.stl"', 'file = "brick.stl"\nscale = 2', "unknown key 'mesh.scale': expected file, pieces"),
    ('file = "brick.stl"', 'file = "brick.stl"\npieces = "a"', "mesh.pieces: expected 1 to 128 names of files"),
    ('file = "brick.stl"', f'file = "brick.stl"\npieces = {["a.stl"] * 300}', "1 to 128 names of files"),
    ('file = "brick.stl"', 'generator = "fin"\nheight = 3', "unfit arguments of the generator fin"),
    ("tcp_mm = [0, 0, 5]", "tcp_mm = [0, 0, 1e9]", "grasps[0].tcp_mm[2]: expected a number in -1000..1000"),
    ("tcp_mm = [0, 0, 5]", "tcp_mm = [0, 0, 90]", "grasps[0].tcp_mm: expected a point within 30 mm of the part's box"),
    ("half_opening_mm = 45", "half_opening_mm = inf", "grasps[0].half_opening_mm: expected a number in 1..55, got inf"),
    ("half_opening_mm = 45", "half_opening_mm = 56", "grasps[0].half_opening_mm: expected a number in 1..55, got 56"),
    ("half_opening_mm = 45", "max_tilt_deg = 30", "grasps[0].half_opening_mm is missing"),
    ("half_opening_mm = 45", "half_opening_mm = 45\nmax_tilt_deg = 80", "max_tilt_deg: expected a number in 1..50"),
    ("half_opening_mm = 45", "half_opening_mm = 45\nspeed = 1", "unknown key 'grasps[0].speed': expected name, tcp_mm"),
    ("closing = [0, 1, 0]", "closing = [0, 0, 1]", "at a right angle to the approach"),
    ("closing = [0, 1, 0]", "closing = [0, 0, 0]", "grasps[0].closing: expected a direction of length 1"),
    (TEXT[TEXT.index("[[grasps]]") :], "", "the key 'grasps' is missing"),
    ("noise =", "grasps = []\nnoise =", "no TOML"),
    ("[slot]", "[[poses]]\nup = [0, 0, 1]\nprobability = 3\n[slot]", "poses[0].probability: expected a number in"),
    ("[slot]", "[[poses]]\nup = [0, 0, 1]\nprobability = 0.1\n[slot]", "probabilities that add up to 0.5 to 1, got"),
    ("[slot]", "[[poses]]\nup = [0, 0.6, 0.8]\nprobability = 1\n[slot]", "poses[0].up: expected a direction in which"),
    ("[slot]", "[[symmetries]]\naxis = [0, 0, 1]\npoint_mm = [0, 0, 0]\nfold = 1\n[slot]", "symmetries[0].fold"),
]


@pytest.mark.parametrize(("before", "after", "words"), VALUES, ids=[f"{i}" for i in range(len(VALUES))])
def test_a_wrong_value_is_refused_in_a_line_with_its_key(tmp_path: Path, before: str, after: str, words: str) -> None:
    assert before in TEXT
    assert words in refusal(tmp_path, TEXT.replace(before, after, 1))


@pytest.mark.parametrize("content", [b"\xff\xfe" + TEXT.encode("utf-16-le"), TEXT.encode() + b"# 50\xb0", b"\x80"])
def test_a_text_that_is_not_utf_8_is_refused(tmp_path: Path, content: bytes) -> None:
    path = Path(brick(tmp_path))
    path.write_bytes(content)
    with pytest.raises(PartFileError, match=rf"^part file {path} cannot be read: expected UTF-8 text: .*$"):
        load_part(str(path))


def test_a_mesh_of_327_000_faces_is_sent_to_the_command_that_simplifies_it(tmp_path: Path) -> None:
    fine = trimesh.creation.icosphere(subdivisions=7, radius=0.04)
    assert "has 327680 faces, expected at most 200000; `graspcell part` simplifies a mesh" in refusal(
        tmp_path, surface=fine
    )


def test_there_must_be_a_grasp_and_names_differ(tmp_path: Path) -> None:
    rows = TEXT[TEXT.index("[[grasps]]") :]
    none = TEXT.replace(rows, "").replace("noise =", "grasps = []\nnoise =", 1)
    assert "grasps: expected 1 to 64 rows, got []" in refusal(tmp_path, none)
    assert "grasps[1].name: expected another name than those of the other grasps" in refusal(tmp_path, TEXT + rows)


def test_a_deep_nest_is_refused(tmp_path: Path) -> None:
    assert "deep nest" in refusal(tmp_path, TEXT + "x = " + "[" * 5000 + "]" * 5000)


def test_a_number_of_thousands_of_digits_is_refused(tmp_path: Path) -> None:
    assert "digits" in refusal(tmp_path, TEXT.replace("mass_kg = 0.2", f"mass_kg = {'9' * 5000}"))


def moved(by: float) -> trimesh.Trimesh:
    return BOX.copy().apply_translation((by, 0, 0))


@pytest.mark.parametrize(
    ("surface", "words"),
    [
        (moved(5.0), "the mesh lies 4.95 m from its frame's origin, expected at most 0.5 m"),
        (BOX.copy().apply_scale(1e-7), "expected at least 0.003 m"),
        (BOX.copy().apply_scale((1, 1, 0)), "the mesh is open"),
    ],
    ids=["far away", "nanometres", "flat"],
)
def test_a_mesh_of_another_size_or_place_is_refused(tmp_path: Path, surface: trimesh.Trimesh, words: str) -> None:
    assert words in refusal(tmp_path, surface=surface)


@pytest.mark.parametrize("content", [b"", b"solid x", b"\x00" * 84 + b"\xff" * 30, b"PK\x03\x04", b"{}"])
@pytest.mark.parametrize("kind", [".stl", ".ply", ".obj", ".glb", ".zip", ".dae", ".json"])
def test_a_broken_mesh_file_is_refused_in_a_line(tmp_path: Path, content: bytes, kind: str) -> None:
    (tmp_path / f"broken{kind}").write_bytes(content)
    told = refusal(tmp_path, TEXT.replace("brick.stl", f"broken{kind}"))
    assert f"mesh file broken{kind}" in told


@pytest.mark.parametrize(
    ("piece", "words"),
    [
        (moved(0.2), "mesh.pieces[0]: expected a piece within the part's box"),
        (BOX.copy().apply_scale(1000.0), "mesh.pieces[0]: expected a piece within the part's box"),
        (BOX.copy().apply_scale(0.2), "mesh.pieces: expected pieces that fill the part's box"),
        (BOX.copy().apply_scale((1, 1, 0)), "expected a mesh with a volume"),
    ],
    ids=["elsewhere", "millimetres", "too small", "flat"],
)
def test_pieces_that_are_not_the_parts_are_refused(tmp_path: Path, piece: trimesh.Trimesh, words: str) -> None:
    piece.export(tmp_path / "piece.stl")
    assert words in refusal(tmp_path, TEXT.replace('file = "brick.stl"', 'file = "brick.stl"\npieces = ["piece.stl"]'))


def test_stable_poses_of_the_file_replace_those_of_the_hull(tmp_path: Path) -> None:
    rows = "".join(
        f"[[poses]]\nup = {up}\nprobability = {share}\n" for up, share in (("[0, 0, -1]", 0.6), ("[0, 1, 0]", 0.3))
    )
    model = load_part(brick(tmp_path, TEXT + rows))
    one, other = model.resting_poses
    assert (one.probability, other.probability) == pytest.approx((2 / 3, 1 / 3))
    assert one.rotation == pytest.approx(np.diag([1.0, -1.0, -1.0]))
    assert (one.height, other.height) == pytest.approx((0.01, 0.025))
    assert other.rotation @ [0, 1, 0] == pytest.approx([0, 0, 1])


def test_the_symmetries_of_the_file_are_those_of_the_part_in_metres(tmp_path: Path) -> None:
    rows = "[[symmetries]]\naxis = [0, 0, 1]\npoint_mm = [10, 0, 0]\nfold = 2\n"
    part = load_part(brick(tmp_path, TEXT + rows)).part
    same, turned = part.symmetries
    assert same.apply(np.array([[0.01, 0.02, 0.03]]))[0] == pytest.approx((0.01, 0.02, 0.03))
    assert turned.apply(np.array([[0.01, 0.02, 0.03]]))[0] == pytest.approx((0.01, -0.02, 0.03))
    assert load_part("handle").part.symmetries == ()  # its file lists none


def test_a_stable_pose_without_a_grasp_is_a_warning(tmp_path: Path) -> None:
    model = load_part(brick(tmp_path))
    told = warnings_of(model.part, model.resting_poses, model.pieces)
    assert len(model.resting_poses) >= 2
    assert len(told) == len(model.resting_poses) - 1  # all but the one that the grasp from above is for
    assert "no grasp from above" in told[0]


def test_a_hull_that_is_far_larger_than_the_part_is_a_warning(tmp_path: Path) -> None:
    bar, post = trimesh.creation.box((0.1, 0.005, 0.02)), trimesh.creation.box((0.005, 0.05, 0.02))
    frame = trimesh.util.concatenate([bar, post.apply_translation((0, 0.03, 0))])
    model = load_part(brick(tmp_path, surface=frame))
    assert any("times the part's volume" in line for line in warnings_of(model.part, model.resting_poses, model.pieces))


@pytest.mark.parametrize("name", ["antenna", "handle"])
def test_the_shipped_parts_have_nothing_to_warn_of(name: str) -> None:
    model = load_part(name)
    assert warnings_of(model.part, model.resting_poses, model.pieces) == []
