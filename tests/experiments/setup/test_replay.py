"""Recorded estimates, played back."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cell.interfaces import Frame
from cell.layout import Layout
from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from experiments.results.store import SCHEMAS
from experiments.setup.replay import LOGS, load_recording
from maskval import Pose, bop, mask_from_rle
from sim.model.parts import load_part
from tests.experiments.command import Told, command, overriding

METHOD, PARTS = "ensemble-add", 2  # two networks; the second part of this seed is looked at twice
SETUP = EstimatorSetup(load_part("handle").part, Layout().camera, 0.5, seed=5, experiment=0)
AHEAD = [0.0, 0.0, 0.5, 1.0, 0.0, 0.0, 0.0]
PIXELS = 480 * 640
Row = dict[str, Any]


def run(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object, method: str = METHOD) -> Told:
    cell = ("--object", "handle", "--method", method, "--parts", PARTS, "--seed", 5, "--speed", "fast")
    return command(capsys, "run", *overriding(*cell, "--out", out, *arguments))


def rows(folder: Path, table: str) -> list[Row]:
    read: list[Row] = pq.read_table(folder / f"{table}.parquet").to_pylist()
    return read


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A noisy experiment as compare writes it."""
    folder = tmp_path_factory.mktemp("recorded")
    arguments = ["--objects", "handle", "--methods", METHOD, "--experiments", "1", "--parts", str(PARTS), "--seed", "5"]
    from experiments.cli import main  # noqa: PLC0415

    with pytest.raises(SystemExit, match=r"^0$"):
        main(["compare", *arguments, "--speed", "fast", "--jobs", "1", "--out", str(folder)])
    return folder


def frames_of(folder: Path) -> list[Frame]:
    camera = Layout().camera
    return [Frame(row["frame"], row["time_s"], camera, pose(row["X_BC"])) for row in rows(folder, "frames")]


def pose(numbers: Sequence[float]) -> Pose:
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])


def write_bop(folder: Path, log: Path) -> None:
    """The estimates of a log as BOP's files, scene for experiment and image for frame, worst score first."""
    estimates = sorted(rows(log, "estimates"), key=lambda row: (row["frame"], row["score"]))
    camera = Layout().camera
    bop.write_detections(
        folder / "masks.json",
        [
            bop.DetectionResult(
                0, row["frame"], 1, row["score"], tuple(row["mask_rle"]), camera.height, camera.width, 0.25
            )
            for row in estimates
        ],
    )
    for file, column in (("poses.csv", "X_CO_est"), ("poses_2.csv", "X_CO_est_2")):
        results = [bop.PoseResult(0, row["frame"], 1, row["score"], pose(row[column]), 0.2) for row in estimates]
        bop.write_results(folder / file, results)


def test_a_replay_of_a_noisy_experiment_goes_as_the_experiment_went(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, recorded: Path
) -> None:
    assert run(capsys, tmp_path, "--estimator", "replay", "--recorded", recorded).code == 0
    assert len(rows(recorded, "decisions")) > PARTS
    for table in ("slots", "transitions"):
        assert rows(tmp_path, table) == rows(recorded, table)
    for table, columns in (
        ("attempts", ("decision", "frame", "detection", "grasp", "outcome", "contact_with", "start_s", "end_s")),
        ("decisions", ("frame", "action", "detection", "threshold")),
        ("estimates", ("frame", "detection", "score", "mask_rle", "true_part")),
    ):
        was, now = ([[row[name] for name in columns] for row in rows(of, table)] for of in (recorded, tmp_path))
        assert now == was
    (was,), (now,) = rows(recorded, "experiments"), rows(tmp_path, "experiments")
    assert (was.pop("estimator"), now.pop("estimator")) == ("noisy", "replay")
    assert was == now


@pytest.mark.parametrize("form", ["logs", "BOP"])
def test_every_frame_gives_the_masks_scores_and_poses_that_were_recorded(
    tmp_path: Path, recorded: Path, form: str
) -> None:
    if form == "BOP":
        write_bop(tmp_path, recorded)
    recording = load_recording(recorded if form == "logs" else tmp_path, SETUP, METHOD)
    assert len(recording.networks) == 2
    assert recording.inference_time == pytest.approx(0.25 + 2 * 0.2)  # docs/cell.md: a detector, two networks
    estimates = rows(recorded, "estimates")
    assert len(estimates) > PARTS
    seen = 0
    for frame in frames_of(recorded):
        detections = recording.detect(frame)
        own = [row for row in estimates if row["frame"] == frame.index]
        assert [detection.score for detection in detections] == [row["score"] for row in own]
        for network, column in zip(recording.networks, ("X_CO_est", "X_CO_est_2"), strict=True):
            for estimate, row in zip(network.estimate(frame, detections), own, strict=True):
                np.testing.assert_allclose(estimate.matrix, pose(row[column]).matrix, rtol=0, atol=1e-12)
        for detection, row in zip(detections, own, strict=True):
            np.testing.assert_array_equal(detection.mask, mask_from_rle(row["mask_rle"], 480, 640))
            seen += 1
    assert seen == len(estimates)


def test_a_replay_that_leaves_the_recorded_way_fails_and_says_how_to_stay_on_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, recorded: Path
) -> None:
    # Another seed has other parts: the first recorded pose is void, and the search goes on, which it did not then.
    told = run(capsys, tmp_path, "--estimator", "replay", "--recorded", recorded, "--seed", 6)
    assert told.code == 3
    assert "was recorded from another view; expected the same seed, method, policy" in told.out


def test_a_frame_that_was_not_recorded_or_from_elsewhere_is_refused(recorded: Path) -> None:
    recording = load_recording(recorded, SETUP, METHOD)
    first, *_, last = frames_of(recorded)
    with pytest.raises(LookupError, match=rf"has no frame {last.index + 1}, only 0 to {last.index}"):
        recording.detect(replace(last, index=last.index + 1))
    elsewhere = replace(first, X_BC=Pose.from_translation((0.002, 0, 0)) @ first.X_BC)
    with pytest.raises(LookupError, match="frame 0 was recorded from another view"):
        recording.detect(elsewhere)
    assert recording.detect(replace(first, X_BC=Pose.from_translation((0.0005, 0, 0)) @ first.X_BC))


def test_a_folder_without_a_recording_is_refused_with_what_it_should_have(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"expected frames.parquet, .*, or BOP's masks.json and poses.csv"):
        load_recording(tmp_path, SETUP, METHOD)


@pytest.mark.parametrize(
    ("setup", "method"), [(SETUP, "maskval"), (replace(SETUP, experiment=7), METHOD), ("antenna", METHOD)]
)
def test_an_experiment_that_was_not_recorded_is_refused_by_name(recorded: Path, setup: Any, method: str) -> None:
    if setup == "antenna":
        setup = replace(SETUP, part=load_part("antenna").part)
    name = rf"{setup.part.name} × {method}, experiment {setup.experiment}: nothing recorded"
    with pytest.raises(UsageError, match=name):
        load_recording(recorded, setup, method)


def test_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    for name in SCHEMAS:
        (tmp_path / f"{name}.parquet").write_text("no Parquet")
    with pytest.raises(UsageError, match=r"frames.parquet: expected a log of compare or run: .*Parquet"):
        load_recording(tmp_path, SETUP, METHOD)


@pytest.mark.parametrize("files", [LOGS, ("masks.json", "poses.csv"), ("masks.json", "poses.csv", "poses_2.csv")])
def test_what_is_no_regular_file_is_refused_before_it_is_read(tmp_path: Path, files: Sequence[str]) -> None:
    for name, content in (("masks.json", "[]"), ("poses.csv", "scene_id,im_id,obj_id,score,R,t,time\n")):
        (tmp_path / name).write_text(content)
    if files == LOGS:
        write_rows(tmp_path, FRAME, ESTIMATE)
    (tmp_path / files[-1]).unlink(missing_ok=True)
    os.mkfifo(tmp_path / files[-1])
    with pytest.raises(UsageError, match=rf"{files[-1]}: expected a regular file, got a pipe"):
        load_recording(tmp_path, SETUP, METHOD)


KEY: Row = {"object": "handle", "method": "maskval", "experiment": 0, "frame": 3}
FRAME: Row = KEY | {"X_BC": AHEAD, "detections": 1, "inference_s": 0.5}
ESTIMATE: Row = KEY | {"mask_rle": [PIXELS], "score": 1.0, "X_CO_est": AHEAD, "X_CO_est_2": None}


def write_log(folder: Path, mask_rle: list[int], X_CO_est: list[float]) -> None:
    write_rows(folder, FRAME, ESTIMATE | {"mask_rle": mask_rle, "X_CO_est": X_CO_est})


def write_rows(folder: Path, frame: Row, estimate: Row) -> None:
    for name, row in (("frames", frame), ("estimates", estimate)):
        pq.write_table(pa.Table.from_pylist([row]), folder / f"{name}.parquet")


def without(row: Row, name: str) -> Row:
    return {key: value for key, value in row.items() if key != name}


SPOILT: list[tuple[Row, Row, str]] = [
    (without(FRAME, name), ESTIMATE, f"frames.parquet: expected a log of compare or run: .*{name}") for name in FRAME
]
SPOILT += [
    (FRAME, without(ESTIMATE, name), f"estimates.parquet: expected a log of compare or run: .*{name}")
    for name in ESTIMATE
]
SPOILT += [
    (FRAME | {name: None}, ESTIMATE, f"frames.parquet: expected {name} in every row, got null")
    for name in ("X_BC", "inference_s")
]
SPOILT += [
    (FRAME, ESTIMATE | {name: None}, f"estimates.parquet: expected {name} in every row, got null in frame 3")
    for name in ("mask_rle", "score", "X_CO_est")
]
SPOILT += [
    (FRAME | {"X_BC": [None] * 7}, ESTIMATE, "X_BC of a frame"),
    (FRAME | {"X_BC": [0.0] * 6}, ESTIMATE, "frames.parquet: expected a log"),
    (FRAME | {"X_BC": [0.0] * 7}, ESTIMATE, "X_BC of a frame: quaternion_wxyz must have norm 1"),
    (FRAME | {"inference_s": "soon"}, ESTIMATE, "frames.parquet: expected a log"),
    (FRAME, ESTIMATE | {"X_CO_est": [None] * 7}, "frame 3"),
    (FRAME, ESTIMATE | {"X_CO_est": "here"}, "estimates.parquet: expected a log"),
    (FRAME, ESTIMATE | {"mask_rle": [None]}, "frame 3"),
    (FRAME, ESTIMATE | {"mask_rle": [2**62] * 3 + [2**62 + PIXELS]}, "estimates.parquet: expected a log"),
    (FRAME | {"detections": None}, ESTIMATE, "nothing recorded"),
]


@pytest.mark.parametrize(("frame", "estimate", "words"), SPOILT, ids=[f"{at}" for at in range(len(SPOILT))])
def test_a_log_without_a_column_or_a_value_is_refused_in_a_line(
    tmp_path: Path, frame: Row, estimate: Row, words: str
) -> None:
    write_rows(tmp_path, frame, estimate)
    with pytest.raises(UsageError, match=words) as refused:
        load_recording(tmp_path, SETUP, "maskval")
    assert "\n" not in str(refused.value)


def test_a_recorded_mask_fills_the_image(tmp_path: Path) -> None:
    write_log(tmp_path, [PIXELS], AHEAD)
    assert len(load_recording(tmp_path, SETUP, "maskval").networks) == 1


@pytest.mark.parametrize(
    ("mask_rle", "X_CO_est", "words"),
    [
        ([PIXELS - 1], AHEAD, f"counts must add up to 480 x 640 = {PIXELS}, but to {PIXELS - 1}"),
        ([PIXELS], [0.0, 0.0, 0.5, 2.0, 0.0, 0.0, 0.0], "quaternion_wxyz must have norm 1"),
    ],
)
def test_a_spoilt_mask_or_pose_is_refused_with_its_experiment_and_frame(
    tmp_path: Path, mask_rle: list[int], X_CO_est: list[float], words: str
) -> None:
    write_log(tmp_path, mask_rle, X_CO_est)
    with pytest.raises(UsageError, match=f"handle × maskval, experiment 0: frame 3: {words}"):
        load_recording(tmp_path, SETUP, "maskval")


def test_bop_files_need_not_name_what_shows_nothing_but_those_that_do_not_fit_together_are_refused(
    tmp_path: Path, recorded: Path
) -> None:
    write_bop(tmp_path, recorded)
    last = frames_of(recorded)[-1]
    assert load_recording(tmp_path, SETUP, METHOD).detect(replace(last, index=1000)) == []
    with pytest.raises(UsageError, match=r"scene 3: nothing recorded"):
        load_recording(tmp_path, replace(SETUP, experiment=3), METHOD)
    results = bop.read_results(tmp_path / "poses_2.csv")
    bop.write_results(tmp_path / "poses_2.csv", results[1:])
    with pytest.raises(UsageError, match=r"poses_2.csv: expected \d poses in scene 0, image 0, one for each mask, got"):
        load_recording(tmp_path, SETUP, METHOD)
    (tmp_path / "poses_2.csv").unlink()
    bop.write_results(tmp_path / "poses.csv", [replace(result, time_s=-1.0) for result in results])
    with pytest.raises(UsageError, match="expected the time of detector and pose networks in the files"):
        load_recording(tmp_path, SETUP, METHOD)
    (tmp_path / "poses.csv").write_text("0,0,1,much,1,2,3\n")
    with pytest.raises(UsageError, match=r"poses.csv:1"):
        load_recording(tmp_path, SETUP, METHOD)


@pytest.mark.parametrize("job", ["compare", "run"])
@pytest.mark.parametrize("out", ["recorded", "link", "elsewhere/../recorded", "home"])
def test_a_replay_into_its_own_recording_is_refused_before_anything_is_written(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, job: str, out: str
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("recorded", "home", "elsewhere"):
        Path(folder).mkdir()
    for name in ("frames.parquet", "estimates.parquet"):
        Path("home", name).write_text("precious")
        Path("recorded", name).symlink_to(Path("..", "home", name))
    Path("link").symlink_to("recorded")
    told = command(capsys, job, "--estimator", "replay", "--recorded", "recorded", "--out", out)
    assert (told.code, told.out) == (2, "")
    assert f"--out {out} would replace the recording in recorded: expected another folder" in told.err
    assert {path.name for path in Path("home").iterdir()} == {"frames.parquet", "estimates.parquet"}
    assert {path.name for path in Path("recorded").iterdir()} == {"frames.parquet", "estimates.parquet"}
    assert {path.read_text() for path in Path("home").iterdir()} == {"precious"}
