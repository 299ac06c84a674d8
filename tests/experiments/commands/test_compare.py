"""What compare writes, and that the same seed writes it again."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from cell.layout import Layout
from experiments.cli import main
from experiments.results.store import SCHEMAS
from experiments.setup.experiment import ExperimentSpec, kept_cell, make_cycle, run_experiment
from experiments.setup.methods import named_methods
from experiments.setup.thresholds import load_thresholds
from maskval import Pose, mask_from_rle
from sim.networks.ground_truth import LatestTruth
from tests.experiments.command import command
from tests.experiments.comparisons import KEY, PARTS, compared, rows, spec, table_of

OBJECTS, NAMES, EXPERIMENTS = ("antenna", "handle"), ("maskval", "none", "ensemble-add"), 2


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of every object and method, in this process."""
    folder = tmp_path_factory.mktemp("compare")
    arguments = ["--objects", *OBJECTS, "--methods", *NAMES, "--experiments", EXPERIMENTS, "--parts", PARTS]
    with pytest.raises(SystemExit, match=r"^0$"):
        main(["compare", *map(str, arguments), "--jobs", "1", "--seed", "5", "--out", str(folder)])
    return folder


# --- what is written


def test_compare_writes_table_manifest_and_all_logs(whole: Path) -> None:
    wanted = {
        "run.json",
        "units",
        ".lock",
        "config.toml",
        "manifest.json",
        "table.json",
        "table.csv",
        "table.md",
        "table.tex",
        *(f"{name}.parquet" for name in SCHEMAS),
    }
    assert {path.name for path in whole.iterdir()} == wanted


def test_the_table_has_a_cell_per_object_and_method_in_the_order_asked_for(whole: Path) -> None:
    cells = table_of(whole)
    assert [(cell["object"], cell["method"]) for cell in cells] == [(o, m) for o in OBJECTS for m in NAMES]
    assert all((cell["experiments"], cell["failed"]) == (EXPERIMENTS, 0) for cell in cells)
    assert all(cell["parts"] == EXPERIMENTS * PARTS for cell in cells)


def test_every_cell_is_the_sum_of_its_rows(whole: Path) -> None:
    cells = table_of(whole)
    assert len(cells) == 6
    for cell in cells:
        own = rows(whole, "experiments", object=cell["object"], method=cell["method"])
        assert [cell[name] for name in ("tp", "fp", "fn", "void")] == [
            sum(row[name] for row in own) for name in ("tp", "fp", "fn", "void")
        ]


def test_the_manifest_has_the_seed_the_configuration_and_how_much_is_finished(whole: Path) -> None:
    manifest = json.loads((whole / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["common"]["seed"] == manifest["config"]["seed"] == 5
    assert manifest["config"]["parts"] == PARTS
    assert not {"out", "jobs", "shard"} & set(manifest["config"])
    assert manifest["finished"] == manifest["planned"] == len(OBJECTS) * len(NAMES) * EXPERIMENTS
    assert {"versions", "commit", "platform"} <= set(manifest)


def test_every_method_appears_in_one_comparison_and_what_is_not_derived_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ("--objects", "handle", "--methods", "all", "--experiments", 1, "--speed", "fast")
    told = compared(capsys, tmp_path, *arguments, "--u-grasp", "score=0.25")
    assert told.code == 0
    assert [cell["method"] for cell in table_of(tmp_path)] == list(named_methods(["all"]))
    used = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))["u_grasp"]["handle"]
    assert list(used) == [name for name in named_methods(["all"]) if name != "none"]
    derived = load_thresholds("derived")
    assert (used["maskval"], used["score"]) == (derived.of("handle", "maskval"), 0.25)
    assert "handle × temporal: u_t,g = 0.300: the thresholds derived have none; it is the method's own" in told.out
    assert "× score: u_t,g" not in told.out


def test_a_method_with_a_memory_forgets_between_experiments(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ("--objects", "handle", "--methods", "temporal", "--experiments", 2, "--speed", "fast")
    assert compared(capsys, tmp_path, *arguments).code == 0
    alone = run_experiment(spec("temporal", experiment=1, part="handle", estimator="noisy"))
    seen = [row["u"] for row in rows(tmp_path, "estimates", experiment=1)]
    assert len(seen) >= 3
    assert seen[0] == 1.0
    assert min(seen) < 0.3
    assert seen == [row["u"] for row in alone.tables["estimates"]]


def test_slots_outcomes_and_counts_agree(whole: Path) -> None:
    experiments = rows(whole, "experiments")
    assert len(experiments) == len(OBJECTS) * len(NAMES) * EXPERIMENTS
    for row in experiments:
        of = {name: row[name] for name in KEY}
        slots, attempts = rows(whole, "slots", **of), rows(whole, "attempts", **of)
        assert len(slots) == row["parts"] == row["tp"] + row["fp"] + row["timeouts"]
        assert row["tp"] == sum(attempt["outcome"] == "placed" for attempt in attempts)
        assert row["void"] == sum(attempt["outcome"] == "void" for attempt in attempts)
        assert row["timeouts"] == sum(slot["outcome"] is None for slot in slots)
        assert row["duration_s"] == max(slot["end_s"] for slot in slots)


def pose(numbers: Sequence[float]) -> Pose:
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])


def test_every_attempt_can_be_traced_to_decision_estimate_mask_and_frame(whole: Path) -> None:
    attempts = rows(whole, "attempts")
    assert len(attempts) >= len(OBJECTS) * len(NAMES) * EXPERIMENTS
    camera = Layout().camera
    for attempt in attempts:
        of = {name: attempt[name] for name in KEY}
        (decision,) = rows(whole, "decisions", **of, decision=attempt["decision"])
        (frame,) = rows(whole, "frames", **of, frame=decision["frame"])
        (estimate,) = rows(whole, "estimates", **of, frame=decision["frame"], detection=decision["detection"])
        (_,) = rows(whole, "slots", **of, slot=attempt["slot"])
        assert (decision["action"], decision["slot"]) == ("grasp", attempt["slot"])
        assert (attempt["frame"], attempt["detection"]) == (decision["frame"], decision["detection"])
        assert attempt["u"] == decision["u"] == estimate["u"]
        assert attempt["threshold"] == decision["threshold"]
        assert attempt["threshold"] is None or attempt["u"] <= attempt["threshold"]
        assert frame["time_s"] <= attempt["start_s"] <= attempt["end_s"]
        X_BO_est = pose(frame["X_BC"]) @ pose(estimate["X_CO_est"])
        logged = pose(attempt["X_BO_est"])
        np.testing.assert_allclose(X_BO_est.translation, logged.translation, rtol=0, atol=1e-12)
        np.testing.assert_allclose(X_BO_est.rotation, logged.rotation, rtol=0, atol=1e-12)
        mask = mask_from_rle(estimate["mask_rle"], camera.height, camera.width)
        assert mask.any()


def test_every_detection_of_every_frame_has_its_estimate(whole: Path) -> None:
    frames = rows(whole, "frames")
    assert len(frames) >= len(OBJECTS) * len(NAMES) * EXPERIMENTS
    estimates = [tuple(row[name] for name in (*KEY, "frame", "detection")) for row in rows(whole, "estimates")]
    wanted = [(*(row[name] for name in KEY), row["frame"], i) for row in frames for i in range(row["detections"])]
    assert sorted(estimates) == sorted(wanted)


def test_only_the_ensemble_pays_for_a_second_network(whole: Path) -> None:
    estimates = rows(whole, "estimates")
    assert {row["method"] for row in estimates if row["X_CO_est_2"] is not None} == {"ensemble-add"}
    assert {row["method"] for row in estimates if row["X_CO_est_2"] is None} == {"maskval", "none"}


# --- the same seed, the same rows


def test_the_same_command_again_writes_equal_bytes(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ("--objects", "antenna", "--methods", "maskval", "--experiments", 2)
    folders = tmp_path / "one", tmp_path / "other"
    for folder in folders:
        kept_cell.cache_clear()
        assert compared(capsys, folder, *arguments).code == 0
    names = ["table.json", *(f"{name}.parquet" for name in SCHEMAS)]
    one, other = ({name: (folder / name).read_bytes() for name in names} for folder in folders)
    assert one == other


def test_more_workers_and_another_order_of_objects_and_methods_change_no_row(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, whole: Path
) -> None:
    arguments = ("--objects", *OBJECTS[::-1], "--methods", *NAMES[::-1], "--experiments", EXPERIMENTS)
    assert compared(capsys, tmp_path, *arguments, jobs=2).code == 0
    assert [rows(tmp_path, name) for name in SCHEMAS] == [rows(whole, name) for name in SCHEMAS]
    assert table_of(tmp_path) == table_of(whole)[::-1]


def test_an_experiment_run_alone_has_the_rows_that_it_has_among_others(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, whole: Path
) -> None:
    kept_cell.cache_clear()
    of: dict[str, object] = {"object": "handle", "method": "ensemble-add", "experiment": 1}
    arguments = [text for name, value in of.items() for text in (f"--{name}", value)]
    told = command(capsys, "run", *arguments, "--parts", PARTS, "--seed", 5, "--out", tmp_path)
    assert told.code == 0
    assert rows(whole, "frames", **of)
    assert [rows(tmp_path, name) for name in SCHEMAS] == [rows(whole, name, **of) for name in SCHEMAS]


def beginning(spec: ExperimentSpec) -> list[float]:
    """Where all parts lie when the experiment begins, and where the arm is."""
    cell = kept_cell(*spec.cell)
    make_cycle(spec, cell, LatestTruth(), lambda _: None)
    qpos: list[float] = cell.world.data.qpos.tolist()
    assert len(qpos) == 6 + 2 + 7 * PARTS
    return qpos


def test_every_method_begins_with_the_same_parts_in_the_same_poses() -> None:
    kept_cell.cache_clear()
    first = beginning(spec("none", experiment=1))
    run_experiment(spec("none", experiment=0))  # what happened before leaves no trace
    assert [beginning(spec(method, experiment=1)) for method in NAMES] == 3 * [first]
    assert beginning(spec(estimator="noisy", speed="moderate", experiment=1)) == first


def test_another_experiment_or_seed_begins_with_other_poses() -> None:
    first = beginning(spec())
    assert beginning(spec(experiment=1)) != first
    assert beginning(spec(seed=6)) != first
