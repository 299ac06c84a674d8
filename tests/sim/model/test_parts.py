import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from sim.errors import PartFileError
from sim.model import parts
from sim.model.parts import PartModel, check_mesh, load_part, part_names, resting_poses

NAMES = ("antenna", "handle")


def test_the_parts_of_the_paper_are_there() -> None:
    assert part_names() == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_a_part_is_watertight_and_its_mass_is_that_of_its_file(name: str) -> None:
    model = load_part(name)
    mesh = trimesh.Trimesh(model.part.mesh.vertices, model.part.mesh.faces)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    mesh.density = model.mass / mesh.volume
    assert model.inertia == pytest.approx(mesh.moment_inertia, rel=1e-6)


@pytest.mark.parametrize(("name", "size_mm"), [("antenna", (150, 62, 60)), ("handle", (200, 26, 58.5))])
def test_a_part_has_the_size_that_its_file_says(name: str, size_mm: tuple[float, ...]) -> None:
    vertices = load_part(name).part.mesh.vertices
    assert np.ptp(vertices, axis=0) * 1000 == pytest.approx(size_mm, abs=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_the_convex_pieces_fill_the_part(name: str) -> None:
    model = load_part(name)
    mesh = trimesh.Trimesh(model.part.mesh.vertices, model.part.mesh.faces)
    assert all(piece.is_convex for piece in model.pieces)
    assert sum(piece.volume for piece in model.pieces) == pytest.approx(mesh.volume, rel=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_resting_poses_are_stable_and_their_probabilities_add_up_to_one(name: str) -> None:
    model = load_part(name)
    assert sum(pose.probability for pose in model.resting_poses) == pytest.approx(1.0)
    assert len(model.resting_poses) >= 3
    for pose in model.resting_poses:
        vertices = model.part.mesh.vertices @ pose.rotation.T + [0, 0, pose.height]
        assert vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
        support = ConvexHull(vertices[vertices[:, 2] < 1e-5][:, :2])
        center = (pose.rotation @ model.center_of_mass)[:2]
        assert np.all(support.equations[:, :2] @ center + support.equations[:, 2] < 0)  # over its support


@pytest.mark.parametrize("name", NAMES)
def test_every_resting_pose_has_a_grasp_from_above(name: str) -> None:
    model = load_part(name)
    for pose in model.resting_poses:
        steepest = min((pose.rotation @ grasp.X_OT.rotation[:, 2])[2] for grasp in model.part.grasps)
        assert steepest < -np.cos(np.radians(35.0))


BOX = trimesh.creation.box((0.1, 0.05, 0.02))
OPEN_BOX = trimesh.Trimesh(BOX.vertices, BOX.faces[:-1])
INSIDE_OUT = trimesh.Trimesh(BOX.vertices, BOX.faces[:, ::-1], process=False)
NOT_FINITE = trimesh.Trimesh(BOX.vertices.copy(), BOX.faces, process=False)
NOT_FINITE.vertices[0, 0] = np.inf


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (OPEN_BOX, ["open", "3 of 18 edges"]),
        (trimesh.Trimesh(), ["no faces"]),
        (BOX.copy().apply_scale(1000.0), ["100 m large", "at most 0.5 m", "millimetres"]),
        (BOX.copy().apply_scale(10.0), ["1 m large", "at most 0.5 m"]),
        (INSIDE_OUT, ["inside out"]),
        (NOT_FINITE, ["not finite"]),
    ],
    ids=["open", "empty", "millimetres", "too large", "inside out", "not finite"],
)
def test_a_bad_mesh_is_refused_with_the_reason(mesh: trimesh.Trimesh, words: list[str]) -> None:
    with pytest.raises(PartFileError) as caught:
        check_mesh(mesh, "my.toml")
    assert all(word in str(caught.value) for word in ["my.toml", *words])


PART_FILE = """
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


def brick_file(folder: Path, text: str = PART_FILE) -> str:
    BOX.export(folder / "brick.stl")
    path = folder / "brick.toml"
    path.write_text(text)
    return str(path)


def test_a_third_part_is_one_file_beside_its_mesh(tmp_path: Path) -> None:
    model: PartModel = load_part(brick_file(tmp_path))
    assert model.part.name == "brick"
    assert np.ptp(model.part.mesh.vertices, axis=0) == pytest.approx((0.1, 0.05, 0.02))
    assert model.center_of_mass == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    # A box of mass m and sides b, c turns about its a axis with m (b² + c²) / 12.
    assert model.inertia[0, 0] == pytest.approx(0.2 * (0.05**2 + 0.02**2) / 12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("mass_kg = 0.2\n", ""), ["'mass_kg' is missing"]),
        (('file = "brick.stl"', 'file = "none.stl"'), ["none.stl does not exist"]),
        (('file = "brick.stl"', 'generator = "star"'), ["'star'", "fin, bow"]),
        (("closing = [0, 1, 0]", "closing = [0, 1, 1]"), ["orthonormal"]),
        (("approach = [0, 0, -1]", "approach = [0, 0]"), ["brick.toml"]),
        (("mass_kg = 0.2", "mass_kg = -0.2"), ["mass_kg", "0.001..8", "-0.2"]),
        (("[slot]", "[slots]"), ["'slot' is missing"]),
        (("name =", "name :"), ["brick.toml", "line 2"]),
    ],
)
def test_a_bad_part_file_is_refused_with_the_reason(tmp_path: Path, change: tuple[str, str], words: list[str]) -> None:
    assert change[0] in PART_FILE
    with pytest.raises(PartFileError) as caught:
        load_part(brick_file(tmp_path, PART_FILE.replace(*change, 1)))
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_an_unknown_part_is_refused_with_the_names_of_those_that_exist() -> None:
    with pytest.raises(PartFileError, match=r"unknown object 'antena': expected one of antenna, handle"):
        load_part("antena")
    with pytest.raises(PartFileError, match=r"nowhere\.toml does not exist"):
        load_part("nowhere.toml")


def test_a_part_is_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    make = parts.resting_poses
    monkeypatch.setattr(parts, "resting_poses", lambda mesh: made.append(1) or make(mesh))
    parts._build.cache_clear()
    for name in ("antenna", brick_file(tmp_path)):
        assert load_part(name) is load_part(name)
    assert len(made) == 2


def test_a_part_whose_file_or_mesh_has_changed_is_made_anew(tmp_path: Path) -> None:
    name = brick_file(tmp_path)
    first = load_part(name)
    text = Path(name).read_text()
    Path(name).write_text(text.replace("mass_kg = 0.2", "mass_kg = 0.4"))
    assert load_part(name).mass == 0.4
    trimesh.creation.box((0.04, 0.05, 0.02)).export(tmp_path / "brick.stl")
    assert np.ptp(load_part(name).part.mesh.vertices, axis=0) == pytest.approx((0.04, 0.05, 0.02))
    assert np.ptp(first.part.mesh.vertices, axis=0) == pytest.approx((0.1, 0.05, 0.02))


def test_nothing_of_a_part_can_be_changed_since_others_hold_it_too() -> None:
    model = load_part("antenna")
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.mass = 1.0  # type: ignore[misc]
    arrays = [model.center_of_mass, model.inertia, *(pose.rotation for pose in model.resting_poses)]
    assert len(arrays) > 3
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    for piece in model.pieces:
        with pytest.raises(ValueError, match="read-only"):
            piece.vertices[0] = 1.0
        with pytest.raises(ValueError, match="immutable"):
            piece.apply_scale(2.0)


def test_a_mesh_that_needs_other_files_is_refused(tmp_path: Path) -> None:
    name = brick_file(tmp_path)
    (tmp_path / "brick.gltf").write_text(
        '{"asset": {"version": "2.0"}, "buffers": [{"uri": "a.bin", "byteLength": 36}]}'
    )
    Path(name).write_text(Path(name).read_text().replace("brick.stl", "brick.gltf"))
    with pytest.raises(PartFileError, match=r"brick.gltf: expected one file with the whole mesh, .stl, .ply, .obj or"):
        load_part(name)


def test_a_cube_rests_on_each_of_its_six_sides() -> None:
    poses = resting_poses(trimesh.creation.box((0.1, 0.1, 0.1)))
    assert len(poses) == 6
    assert [pose.probability for pose in poses] == pytest.approx([1 / 6] * 6, abs=0.02)


def test_the_documented_part_of_your_own_loads_and_can_be_gripped_however_it_lies(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "cell.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    model = load_part(brick_file(tmp_path, text))
    assert len(model.resting_poses) == 6
    for pose in model.resting_poses:
        assert min((pose.rotation @ grasp.X_OT.rotation[:, 2])[2] for grasp in model.part.grasps) < -0.99
