import json
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from experiments.calibration.noise_file import rewrite
from experiments.dataset import config as dataset_config
from experiments.dataset.batch import BatchTask, Judged, run_batch
from experiments.dataset.coco import Matches
from experiments.dataset.metrics import ERRORS_M
from experiments.setup.methods import known_method, named_methods
from experiments.setup.thresholds import load_thresholds
from maskval import Ensemble
from sim.model.parts import load_part
from sim.networks.noise_model import noise_text
from tests.experiments.command import Told, command, overriding

DEFAULT = ["maskval", "ensemble-add", "oracle-mask", "oracle-mdd", "random"]
WRONG = [  # arguments, words that the one line of error must hold
    (["--images", "0"], ["--images of at least 1", "got 0"]),
    (["--images", "many"], ["--images", "many"]),
    (["--seed", "-1"], ["--seed of at least 0", "got -1"]),
    (["--jobs", "-1"], ["--jobs of at least 0", "got -1"]),
    (["--resamples", "0"], ["--resamples of at least 1", "got 0"]),
    (["--objects"], ["expected at least one value for --objects, got none"]),
    (["--objects", "cup"], ["unknown object 'cup'", "antenna, handle", ".toml"]),
    (["--objects", "handle", "handle"], ["expected different values for --objects, got handle handle"]),
    (["--methods"], ["expected at least one value for --methods, got none"]),
    (["--methods", "score", "score"], ["expected different values for --methods, got score score"]),
    (["--methods", "temporal"], ["temporal needs several views of one scene", "a single test image"]),
    (["--methods", "mask"], ["unknown method 'mask'", "maskval", "package.module:Class"]),
    (["--averaging", "median"], ["--averaging", "median", "images", "pooled"]),
    (["--annotated-visibility", "1.5"], ["--annotated-visibility in 0..1", "got 1.5"]),
    (["--image", "5"], ["--image", "valid options of dataset", "--images", "--figures"]),
]


def run(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object) -> Told:
    return command(capsys, "dataset", *overriding("--resamples", 5, "--out", out, *arguments))


@pytest.mark.parametrize(("arguments", "words"), WRONG, ids=[" ".join(arguments) for arguments, _ in WRONG])
def test_a_wrong_argument_ends_with_code_2_and_one_line(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: list[str]
) -> None:
    told = command(capsys, "dataset", *arguments)
    assert (told.code, told.out) == (2, "")
    assert told.err.startswith("graspcell: error: ")
    assert told.err.count("\n") == 1
    assert [word for word in words if word not in told.err] == []


def test_a_folder_that_cannot_be_written_to_is_refused_before_any_work(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("in the way")
    told = run(capsys, tmp_path / "file")
    assert told.code == 2
    assert told.err.count("\n") == 1
    assert "cannot write to" in told.err


@pytest.mark.parametrize("part", ["antenna", "handle"])
def test_an_image_does_not_depend_on_the_batch_that_it_is_made_in(part: str) -> None:
    whole, matches = run_batch(BatchTask(part, 4, range(8), 0.1))
    runs = [run_batch(BatchTask(part, 4, batch, 0.1)) for batch in (range(1), range(1, 6), range(6, 8))]
    joined, joined_matches = Judged.join([one for one, _ in runs]), Matches.join([one for _, one in runs])
    assert len(whole.mdd_m) >= 16
    assert list(whole.u) == DEFAULT
    for method, u in whole.u.items():
        assert np.array_equal(u, joined.u[method]), method
    for name in (entry.name for entry in fields(Judged) if entry.name != "u"):
        assert np.array_equal(getattr(whole, name), getattr(joined, name)), name
    for name in (entry.name for entry in fields(Matches)):
        assert np.array_equal(getattr(matches, name), getattr(joined_matches, name)), name


def test_the_results_do_not_depend_on_the_number_of_workers(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dataset_config, "_BATCH", 4)
    for jobs in (1, 2):
        told = run(capsys, tmp_path / str(jobs), "--images", 10, "--jobs", jobs, "--objects", "antenna")
        assert told.code == 0
    for name in ("dataset.json", "thresholds.toml"):
        assert (tmp_path / "1" / name).read_text() == (tmp_path / "2" / name).read_text()


def test_dataset_json_holds_the_contract_and_the_tables_name_the_paper(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    told = run(capsys, tmp_path, "--images", 12, "--jobs", 1, "--alternatives", "--figures")
    assert told.code == 0
    written = json.loads((tmp_path / "dataset.json").read_text())
    assert [row["object"] for row in written["objects"]] == ["antenna", "handle"]
    for row in written["objects"]:
        assert row["images"] == 12
        assert set(row["mask"]) == {f"{name}{end}" for name in ("ap_50_95", "ap_50", "ar_100") for end in ("", "_ci")}
        assert list(row["methods"]) == DEFAULT
        for figures in row["methods"].values():
            assert set(figures) == {f"{name}{end}" for name in ("spearman", "auc_ar", "u_tg") for end in ("", "_ci")}
            assert 0 <= figures["auc_ar"] <= 1
        assert row["methods"]["oracle-mdd"]["spearman"] == pytest.approx(1.0)
        assert row["curves"]["e_t_m"] == ERRORS_M.tolist()
        assert row["curves"]["oracle-mdd"]["ar"] == pytest.approx(row["curves"]["ar_star"])
        assert row["median_mdd_m"] == pytest.approx(np.median(row["curves"]["mdd_m_percentiles"]), rel=0.2)
    assert [
        word for word in ("94.7", "87.3", "0.580", "66.0", "median MDD", "first violation") if word not in told.out
    ] == []
    assert {path.name for path in tmp_path.iterdir()} == {
        "dataset.json",
        "thresholds.toml",
        "config.toml",
        "manifest.json",
        "curves.png",
        "errors.png",
    }
    manifest = json.loads((tmp_path / "manifest.json").read_text())
    assert (manifest["config"]["images"], manifest["recipe"]["distance"]) == (12, [0.4, 1.2])


def test_compare_takes_the_derived_thresholds_of_every_method(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run(capsys, tmp_path, "--images", 20, "--jobs", 1, "--methods", "all").code == 0
    source = tmp_path / "thresholds.toml"
    assert "graspcell dataset --methods all --images 20\n" in source.read_text()
    thresholds = load_thresholds(str(source))
    every = [name for name in named_methods(["all"]) if name not in ("none", "temporal")]
    fallen_back = 0
    for row in json.loads((tmp_path / "dataset.json").read_text())["objects"]:
        assert list(row["methods"]) == every
        for name, figures in row["methods"].items():
            if figures["u_tg"] is None:
                assert thresholds.of(row["object"], name) == row["least_error_u"][name]
                assert thresholds.caveat(row["object"], name) is not None
                fallen_back += 1
            else:
                assert thresholds.of(row["object"], name) == figures["u_tg"]
                assert thresholds.caveat(row["object"], name) is None
        method = known_method("ensemble-add", load_part(row["object"]).part, thresholds)
        assert method.uncertainty == Ensemble("add", row["ensemble_add_minimum_m"])
    assert fallen_back > 0  # the detector's score says little about the pose
    assert thresholds.refine == load_thresholds("paper").refine


OWN = """
import numpy as np

class Half:
    def __call__(self, estimates):
        return np.full(len(estimates), 0.5)

class Wrong:
    def __call__(self, estimates):
        return np.full(len(estimates), 1.5)
"""


def test_a_method_of_ones_own_is_evaluated_by_its_name(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "half_way.py").write_text(OWN)
    monkeypatch.syspath_prepend(str(tmp_path))
    arguments = ("--objects", "handle", "--images", 5, "--jobs", 1)
    assert run(capsys, tmp_path / "out", *arguments, "--methods", "half_way:Half", "maskval").code == 0
    thresholds = load_thresholds(str(tmp_path / "out" / "thresholds.toml"))
    assert set(thresholds.grasp["handle"]) | set(thresholds.least_error.get("handle", {})) == {
        "half_way:Half",
        "maskval",
    }
    assert thresholds.of("handle", "half_way:Half") == 0.5
    told = run(capsys, tmp_path / "out", *arguments, "--methods", "half_way:Wrong")
    assert told.code == 2
    assert "half_way:Wrong: expected" in told.err
    assert "uncertainties in [0, 1], got [1.5" in told.err


def test_what_is_undefined_is_null(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    blind = {"mask.miss_probability": (1.0, "assumed"), "mask.false_alarms_per_image": (0.0, "assumed")}
    (tmp_path / "blind.toml").write_text(rewrite(noise_text("antenna"), blind))
    part = Path("sim/assets/parts/antenna.toml").read_text()
    mine = part.replace('noise = "antenna"', f'noise = "{tmp_path}/blind.toml"').replace('"antenna"', '"mine"', 1)
    (tmp_path / "part.toml").write_text(mine)
    told = run(capsys, tmp_path / "out", "--images", 2, "--jobs", 1, "--objects", tmp_path / "part.toml")
    assert told.code == 0
    row = json.loads((tmp_path / "out" / "dataset.json").read_text())["objects"][0]
    assert (row["poses"], row["mask"]["ap_50"], row["methods"]["maskval"]["auc_ar"]) == (0, 0.0, 0.0)
    for undefined in (row["median_mdd_m"], row["ensemble_add_minimum_m"], row["methods"]["maskval"]["u_tg"]):
        assert undefined is None
    assert row["methods"]["maskval"]["spearman_ci"] is None
    assert load_thresholds(str(tmp_path / "out" / "thresholds.toml")).grasp == {"mine": {}}


def test_it_needs_no_physics() -> None:
    code = "import sys, experiments.cli, experiments.dataset.command; sys.exit('mujoco' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0


def test_one_resample_gives_figures_and_thresholds_but_no_interval(capsys, tmp_path) -> None:
    told = command(
        capsys,
        *("dataset", "--objects", "handle", "--methods", "maskval", "--images", 8),
        *("--resamples", 1, "--jobs", 1, "--out", tmp_path),
    )
    assert told.code == 0
    (found,) = json.loads((tmp_path / "dataset.json").read_text(encoding="utf-8"))["objects"]
    rows = (found, found["mask"], found["methods"]["maskval"])
    assert [value for row in rows for name, value in row.items() if name.endswith("_ci")] == 7 * [None]
    assert f"median MDD {1e3 * found['median_mdd_m']:.2f} mm;" in told.out
    assert "maskval" in (tmp_path / "thresholds.toml").read_text(encoding="utf-8")
