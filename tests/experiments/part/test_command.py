"""`graspcell part`: from an STL to a part that the cell can run, and the checks of part files."""

import contextlib
import io
import json
from pathlib import Path

import pytest

from experiments.cli import main
from experiments.part.noise import LENGTHS
from sim.model.parts import load_part
from sim.networks.noise_model import load_noise
from sim.parts.part_checks import warnings_of
from tests.experiments.command import Told, command
from tests.part_shapes import SHAPES, shape


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a clip that was made with one trial per grasp."""
    folder = tmp_path_factory.mktemp("parts")
    shape("clip").export(folder / "clip.stl")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        told = run(folder, "clip.stl", "--trials", 1, "--jobs", 1, "--out", "clip")
    assert told.code == 0, told.err
    (folder / "told.txt").write_text(told.out)
    return folder


def run(folder: Path, *arguments: object) -> Told:
    """The command, without pytest's capture, which module fixtures do not have."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.raises(SystemExit) as end:
        main(["part", *map(str, arguments)])
    assert isinstance(end.value.code, int)
    return Told(end.value.code, out.getvalue(), err.getvalue())


def test_the_part_loads_and_every_stable_pose_has_a_grasp(made: Path) -> None:
    model = load_part(str(made / "clip" / "clip.toml"))
    assert model.mass == pytest.approx(1200 * shape("clip").volume * 1e-9, rel=0.01)
    assert len(model.resting_poses) >= 4
    assert warnings_of(model.part, model.resting_poses, model.pieces) == []
    assert {path.name for path in (made / "clip").iterdir()} >= {
        "clip.toml",
        "clip.ply",
        "noise.toml",
        "preview.png",
        "manifest.json",
    }


def test_what_was_tried_stands_beside_each_grasp(made: Path) -> None:
    rows = [line for line in (made / "clip" / "clip.toml").read_text().splitlines() if 'name = "grasp-' in line]
    assert len(rows) == len(load_part(str(made / "clip" / "clip.toml")).part.grasps)
    assert all("held and placed in 1 of 1 trials in physics" in row for row in rows)


def test_it_says_what_it_did_and_what_to_type_next(made: Path) -> None:
    told = (made / "told.txt").read_text()
    for words in ("unit of clip.stl: mm", "80.0 × 28.0 × 18.0 mm", "times the mesh's volume", "every stable pose has"):
        assert words in told
    assert "slot: " in told
    assert "graspcell compare --objects clip/clip.toml --estimator oracle --methods none" in told
    assert "graspcell dataset --objects clip/clip.toml --methods maskval ensemble-add" in told


def test_the_error_model_is_scaled_by_the_diameter_and_says_that_it_is_assumed(made: Path) -> None:
    model = load_part(str(made / "clip" / "clip.toml"))
    mine, shipped = load_noise(model.noise), {name: load_noise(name) for name in ("antenna", "handle")}
    diameters = {name: load_part(name).part.mesh.diameter for name in shipped}
    assert len(LENGTHS) == 3
    for name in LENGTHS:
        one, other = (shipped[part].number(name) / diameters[part] for part in shipped)
        assert mine.number(name) == pytest.approx((one * other) ** 0.5 * model.part.mesh.diameter, rel=1e-3)
    text = (made / "clip" / "noise.toml").read_text()
    assert "an assumption, not a fit" in text
    assert "fitted," not in text


def test_the_check_finds_nothing_or_each_fault_in_a_line(
    made: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    good = made / "clip" / "clip.toml"
    told = command(capsys, "part", "--check", good)
    assert (told.code, told.err) == (0, "")
    assert told.out.startswith(f"{good}: clip, 0.00739 kg")
    bad = good.with_name("bad.toml")
    bad.write_text(good.read_text().replace("mass_kg = ", "mass_kg = 150 #", 1))
    told = command(capsys, "part", "--check", good, bad)
    assert told.code == 3
    assert f"error: {bad}: mass_kg: expected a number in 0.001..8, got 150" in told.out
    few = good.with_name("few.toml")
    few.write_text(good.read_text().split("[[grasps]]")[0] + "[[grasps]]" + good.read_text().split("[[grasps]]")[1])
    told = command(capsys, "part", "--check", few)
    assert told.code == 0
    assert "no grasp from above" in told.out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "expected a mesh file, or --check with part files, and not both"),
        (("none.stl",), "none.stl does not exist"),
        (("clip.stl", "--unit", "km"), "unknown unit 'km': expected one of mm, cm, m, inch"),
        (("clip.stl", "--unit", "m"), "read in m the mesh is 80 m large"),
        (("clip.stl", "--mass", "150"), "expected --mass in 0.001..8, got 150"),
        (("clip.stl", "--density", "nan"), "expected --density in 10..25000, got nan"),
        (("clip.stl", "--friction", "0"), "expected --friction in 0.05..2, got 0"),
        (("clip.stl", "--trials", "-1"), "expected --trials of at least 0"),
        (("clip.stl", "--name", "antenna"), "expected another --name than those of the shipped parts"),
        (("clip.stl", "--name", "../x"), "expected --name of 1 to 60 letters"),
        (("clip.stl", "--density", "100"), "weighs 0.00062 kg, expected 0.001 to 8: --mass KG"),
        ((".",), "mesh file .: expected a regular file, got a folder"),
        (("cut.stl",), "mesh file cut.stl has no triangles: is it whole, and of the kind that its name says?"),
        (("page.stl",), "mesh file page.stl has no triangles: is it whole"),
        (("flat.obj",), "flat.obj: the mesh is open: 3 of 3 edges do not have two faces"),
        (("index.obj",), "mesh file index.obj: expected one file with the whole mesh"),
        (("part.step",), "its name ends in '.step'"),
        (("clip.stl", "--density", "steel"), "--density: expected a number such as 0.12, got 'steel'"),
        (("clip.stl", "--unit", "MM"), "unknown unit 'MM': expected one of mm, cm, m, inch"),
        (("clip.stl", "--jobs", "1.5"), "--jobs: expected a whole number such as 12, got '1.5'"),
        (("clip.stl", "--out", "/dev/null/x"), "cannot write to /dev/null/x: "),
        (("told.txt",), "expected one file with the whole mesh, .stl, .ply, .obj or .glb"),
    ],
)
def test_what_cannot_be_done_is_said_in_one_line(
    made: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    words: str,
) -> None:
    monkeypatch.chdir(made)
    Path("cut.stl").write_bytes(Path("clip.stl").read_bytes()[:-30])
    Path("page.stl").write_text("<!DOCTYPE html>")
    corners = "v 0 0 0\nv 100 0 0\nv 0 100 0\n"
    Path("flat.obj").write_text(f"{corners}f 1 2 3\n")
    Path("index.obj").write_text(f"{corners}f 1 2 9\n")
    Path("part.step").write_text("ISO-10303-21;")
    told = command(capsys, "part", *arguments)
    assert told.code == 2
    assert told.err.count("\n") == 1
    assert words in told.err


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("clip.stl", b"solid", "expected the .toml file of a part; `graspcell part MESH` makes one from a mesh"),
        ("a.toml", b"", "a.toml: the key 'name' is missing"),
        ("a.toml", b"\xef\xbb\xbfname = 1", "a.toml: no TOML: "),
        ("a.toml", 'name = "a"'.encode("utf-16"), "part file a.toml cannot be read: expected UTF-8 text"),
        ("a.toml", None, "part file a.toml does not exist"),
    ],
)
def test_the_check_of_what_is_no_part_file_says_so_in_a_line(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    content: bytes | None,
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path(name).write_bytes(content)
    told = command(capsys, "part", "--check", name)
    assert (told.code, told.out.count("\n"), told.err) == (3, 1, "")
    assert words in told.out


@pytest.mark.study
@pytest.mark.parametrize("name", SHAPES)
def test_with_exact_estimates_the_cell_places_a_part_that_was_made_from_a_mesh(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str
) -> None:
    shape(name).export(tmp_path / f"{name}.stl")
    assert command(capsys, "part", tmp_path / f"{name}.stl", "--out", tmp_path / name).code == 0
    part = tmp_path / name / f"{name}.toml"
    arguments = ("--estimator", "oracle", "--methods", "none", "--experiments", 5, "--out", tmp_path / "oracle")
    assert command(capsys, "compare", "--objects", part, *arguments).code == 0
    (cell,) = json.loads((tmp_path / "oracle" / "table.json").read_text(encoding="utf-8"))["cells"]
    assert cell["tp"] + cell["fp"] + cell["fn"] >= 40
    assert min(cell["ap"], cell["ar"]) >= 0.95
