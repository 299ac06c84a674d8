import dataclasses
from pathlib import Path

import numpy as np
import pytest
import trimesh

from sim.errors import PartFileError
from sim.model import parts
from sim.model.parts import load_part
from tests.sim.model.test_parts import brick_file


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
