from pathlib import Path

import numpy as np
import pytest
import trimesh

from sim.errors import PartFileError
from sim.part_making.frame import choose_frame
from sim.part_making.surface_file import MOST_FACES, read_surface
from tests.part_shapes import shape

BOX = trimesh.creation.box((90.0, 50.0, 20.0))
_CAN = trimesh.creation.cylinder(30.0, 50.0, sections=64)
WITHOUT_LID = trimesh.Trimesh(_CAN.vertices, _CAN.faces[_CAN.face_normals[:, 2] < 0.9], process=False)


def saved(folder: Path, mesh: trimesh.Trimesh, kind: str = "stl") -> Path:
    path = folder / f"mine.{kind}"
    content = mesh.export(file_type=kind)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


@pytest.mark.parametrize("kind", ["stl", "ply", "obj"])
def test_millimetres_are_found_by_the_size(tmp_path: Path, kind: str) -> None:
    surface = read_surface(saved(tmp_path, BOX, kind))
    assert surface.unit == "mm"
    assert surface.mesh.extents == pytest.approx((0.09, 0.05, 0.02))


def test_metres_are_found_by_the_size_and_are_those_of_glb(tmp_path: Path) -> None:
    metres = BOX.copy().apply_scale(1e-3)
    assert read_surface(saved(tmp_path, metres)).unit == "m"
    assert read_surface(saved(tmp_path, metres, "glb")).mesh.extents == pytest.approx((0.09, 0.05, 0.02))


def test_a_unit_in_doubt_is_asked_for_with_the_sizes(tmp_path: Path) -> None:
    path = saved(tmp_path, BOX.copy().apply_scale(0.1))  # 9 × 5 × 2: millimetres, centimetres or inches
    with pytest.raises(PartFileError, match=r"the unit is in doubt: 9 × 5 × 2 may be millimetres or metres.*--unit mm"):
        read_surface(path)
    assert read_surface(path, "cm").mesh.extents == pytest.approx((0.09, 0.05, 0.02))
    with pytest.raises(PartFileError, match=r"read in m the mesh is 9 m large, expected at most 0.5 m"):
        read_surface(path, "m")


def test_what_is_safe_is_repaired_and_said(tmp_path: Path) -> None:
    doubled = np.vstack([BOX.faces[1:], BOX.faces[5:6], [[0, 0, 1]]])[:, ::-1]  # a hole, a double, a line, inside out
    surface = read_surface(saved(tmp_path, trimesh.Trimesh(BOX.vertices, doubled, process=False), "ply"))
    assert surface.mesh.volume == pytest.approx(0.09 * 0.05 * 0.02)
    told = " ".join(surface.notes)
    assert "left out 2 triangles" in told
    assert "closed holes" in told
    assert "turned triangles" in told


def test_bodies_that_overlap_are_joined_and_specks_left_out(tmp_path: Path) -> None:
    post = trimesh.creation.box((20.0, 20.0, 60.0))  # of 24 cm³, of which 8 cm³ are inside of the box
    speck = trimesh.creation.box((1.0, 1.0, 1.0)).apply_translation((60, 0, 0))
    surface = read_surface(saved(tmp_path, trimesh.util.concatenate([BOX, post, speck])))
    assert surface.mesh.volume == pytest.approx((90 + 24 - 8) * 1e-6)
    assert "left out 1 loose bodies" in surface.notes[0]
    assert "joined 2 bodies" in surface.notes[1]


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (trimesh.util.concatenate([BOX, BOX.copy().apply_translation((0, 0, 50))]), "expected one body, got 2"),
        (WITHOUT_LID, "the mesh is open: 64 of"),
    ],
    ids=["two bodies", "open"],
)
def test_the_rest_is_refused_with_the_reason(tmp_path: Path, mesh: trimesh.Trimesh, words: str) -> None:
    with pytest.raises(PartFileError, match=words):
        read_surface(saved(tmp_path, mesh))


def test_a_fine_mesh_is_simplified_and_its_shape_kept(tmp_path: Path) -> None:
    fine = trimesh.creation.icosphere(subdivisions=6, radius=40.0)
    assert len(fine.faces) > MOST_FACES
    surface = read_surface(saved(tmp_path, fine))
    assert len(surface.mesh.faces) <= MOST_FACES
    assert surface.mesh.is_watertight
    assert surface.mesh.volume == pytest.approx(fine.volume * 1e-9, rel=0.005)
    assert "simplified from 81920 to" in surface.notes[0]


def test_a_mesh_too_fine_for_a_part_file_is_simplified(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.parts.mesh_files.MOST_FACES", 1000)  # 200,000 take three seconds
    surface = read_surface(saved(tmp_path, trimesh.creation.icosphere(subdivisions=3, radius=40.0)))
    assert len(surface.mesh.faces) == 1280


def test_more_faces_than_any_part_has_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.part_making.surface_file.MOST_INPUT_FACES", 1000)
    with pytest.raises(PartFileError, match=r"mine.stl: expected at most 1000 faces, got 1280"):
        read_surface(saved(tmp_path, trimesh.creation.icosphere(subdivisions=3, radius=40.0)))


@pytest.mark.study
def test_a_mesh_of_327_000_faces_becomes_a_surface_in_seconds(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=7, radius=40.0)
    surface = read_surface(saved(tmp_path, ball, "ply"))
    assert len(surface.mesh.faces) <= MOST_FACES
    assert surface.mesh.volume == pytest.approx(ball.volume * 1e-9, rel=0.005)


def test_the_frame_of_the_mesh_is_kept_unless_another_side_is_longer_or_the_origin_outside() -> None:
    assert choose_frame(BOX.copy().apply_scale(1e-3))[2] is None
    tall = trimesh.creation.box((0.02, 0.03, 0.09)).apply_translation((0.1, 0.0, 0.0))
    moved, X_MO, told = choose_frame(tall)
    assert moved.extents == pytest.approx((0.09, 0.02, 0.03))
    assert moved.bounds.mean(axis=0) == pytest.approx((0, 0, 0), abs=1e-9)
    assert X_MO.rotation[:, 0] == pytest.approx((0, 0, 1))
    assert X_MO.translation == pytest.approx((0.1, 0, 0))
    assert told is not None
    assert "at 100 0 0 mm, its x axis along the mesh's z" in told
    assert shape("gear").extents[0] == pytest.approx(shape("gear").extents[1], rel=0.1)
