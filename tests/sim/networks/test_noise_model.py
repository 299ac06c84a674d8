from dataclasses import replace
from importlib.resources import files

import pytest

from sim.errors import NoiseFileError
from sim.networks.noise_model import bounds, load_noise, noise_names, read_noise

ANTENNA = (files("sim") / "assets" / "noise" / "antenna.toml").read_text(encoding="utf-8")


def test_the_package_brings_a_model_for_each_of_its_parts() -> None:
    assert noise_names() == ["antenna", "handle"]


def test_a_file_is_read_by_its_path(tmp_path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(ANTENNA.replace("depth_ratio = 2.5", "depth_ratio = 3"), encoding="utf-8")
    assert load_noise(str(path)).pose == replace(load_noise("antenna").pose, depth_ratio=3)


@pytest.mark.parametrize("name", ["antenna", "handle"])
def test_every_parameter_says_unit_meaning_and_source(name) -> None:
    text = (files("sim") / "assets" / "noise" / f"{name}.toml").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if " = " in line.split("#")[0]]
    assert len(lines) == 42  # 4 of the view, 21 of the poses, 15 of the masks, 2 of the time
    for line in lines:
        unit, meaning, source = line.split("# ")[1].split("; ", 1)[0], line.split("; ")[1:-1], line.split("; ")[-1]
        assert unit in {"1", "deg", "mm", "px", "s", "cells"}
        assert meaning
        assert source.split(" ")[0].rstrip(",") in {"fitted", "assumed"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("depth_ratio = 2.5", "", r"missing key of \[pose\] 'depth_ratio'"),
        ("depth_ratio = 2.5", "ratio = 2.5", r"unknown key of \[pose\] 'ratio': expected .*depth_ratio, "),
        ("depth_ratio = 2.5", "depth_ratio = '2'", r"pose.depth_ratio: expected a number in \[0, 100\], got '2'"),
        ("depth_ratio = 2.5", "depth_ratio = true", r"pose.depth_ratio: expected a number .* got True"),
        ("depth_ratio = 2.5", "depth_ratio = -1", r"pose.depth_ratio: expected a number in \[0, 100\], got -1"),
        ("depth_ratio = 2.5", "depth_ratio = nan", r"pose.depth_ratio: expected a number .* got nan"),
        ("depth_ratio = 2.5", "depth_ratio = [2.5]", r"pose.depth_ratio: expected a number .* got \(2.5,\)"),
        ("flip_share = 0.08", "flip_share = 1.1", r"pose.flip_share: expected a number in \[0, 1\], got 1.1"),
        ("[0.0, 0.0, 1.0]", "[0, 0, 2]", r"pose.flip_axis: expected three numbers of norm 1, got \(0, 0, 2\)"),
        ("[0.0, 0.0, 1.0]", "[0, 1]", r"pose.flip_axis: expected three numbers of norm 1, got \(0, 1\)"),
        ("[0.0, 0.0, 1.0]", "1.0", r"pose.flip_axis: expected three numbers of norm 1, got 1.0"),
        ("_min = 0.15", "_min = 0.5", r"mask.drop_share_min: expected at most drop_share_max = 0.45, got 0.5"),
        ("bias_cells = 0.0", "bias_cells = inf", r"mask.bias_cells: expected a number in \[-14, 14\], got inf"),
        ("pose_s = 0.20", "pose_s = -0.1", r"timing.pose_s: expected a number in \[0, 60\], got -0.1"),
        ("[timing]", "[time]", r"unknown section 'time': expected mask, pose, timing, view"),
        ("[view]", "more = 1\n[view]", r"unknown section 'more'"),
        ("[view]", "[view", r"no TOML: "),
    ],
)
def test_an_unfit_file_is_refused_in_one_line_that_says_why(old, new, words) -> None:
    assert old in ANTENNA
    with pytest.raises(NoiseFileError, match=f"^mine: {words}") as error:
        read_noise(ANTENNA.replace(old, new, 1), "mine")
    assert "\n" not in str(error.value)


def test_a_number_in_place_of_a_section_is_refused() -> None:
    head, tail = ANTENNA.split("[timing]")
    assert "detector_s" in tail
    with pytest.raises(NoiseFileError, match="mine: timing: expected a section, got 1"):
        read_noise("timing = 1\n" + head, "mine")


def test_unknown_models_and_missing_files_are_refused_with_what_is_there(tmp_path) -> None:
    with pytest.raises(NoiseFileError, match="unknown noise 'bolt': expected one of antenna, handle"):
        load_noise("bolt")
    with pytest.raises(NoiseFileError, match=r"noise file .*bolt.toml does not exist"):
        load_noise(str(tmp_path / "bolt.toml"))
    (tmp_path / "picture.toml").write_bytes(b"\xff\xd8\xff")
    with pytest.raises(NoiseFileError, match=r"picture.toml cannot be read: "):
        load_noise(str(tmp_path / "picture.toml"))


def test_a_record_made_in_code_is_checked_like_a_file() -> None:
    with pytest.raises(NoiseFileError, match=r"box_share: expected a number in \[0, 0.5\], got 0.6"):
        replace(load_noise("antenna").mask, box_share=0.6)


def test_a_changed_model_differs_in_the_named_parameters_only() -> None:
    antenna = load_noise("antenna")
    changed = antenna.changed({"pose.lateral_mm": 0.7, "mask.field_cells": 0.2, "pose.depth_ratio": 3.0})
    assert (changed.number("pose.lateral_mm"), changed.number("mask.field_cells")) == (0.7, 0.2)
    assert changed.pose == replace(antenna.pose, lateral_mm=0.7, depth_ratio=3.0)
    assert changed.mask == replace(antenna.mask, field_cells=0.2)
    assert (changed.view, changed.timing) == (antenna.view, antenna.timing)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"pose.laterl_mm": 1.0}, "unknown noise parameter 'pose.laterl_mm': expected one of .*pose.lateral_mm"),
        ({"lateral_mm": 1.0}, "unknown noise parameter 'lateral_mm'"),
        ({"pose.flip_axis": 1.0}, "unknown noise parameter 'pose.flip_axis'"),
        ({"pose.lateral_mm": -1.0}, r"changed noise: lateral_mm: expected a number in \[0, 1000\], got -1.0"),
    ],
)
def test_a_change_that_cannot_be_is_refused(values, words) -> None:
    with pytest.raises(NoiseFileError, match=words):
        load_noise("antenna").changed(values)


def test_bounds_are_those_that_the_file_is_checked_against() -> None:
    assert bounds("pose.second_core_correlation") == (-1.0, 1.0)
    assert bounds("mask.miss_probability") == (0.0, 1.0)
