"""A run as a LeRobot dataset. That lerobot's own loader reads it was tried by hand: it needs torch."""

import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from experiments import load
from experiments.cli import main
from experiments.exporting.lerobot_files import CAMERAS, SIZE, LeRobotFiles

FPS = 50
Row = dict[str, Any]


@pytest.fixture(scope="module")
def folder(small_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("exported") / "lerobot"
    with pytest.raises(SystemExit) as end:
        main(["export", str(small_run), "--lerobot", str(out), "--methods", "none", "--fps", str(FPS)])
    assert end.value.code == 0
    return out


def slots(run: Path) -> list[Row]:
    rows: list[Row] = load(run).slots.to_pylist()
    return [row for row in rows if row["method"] == "none"]


def episodes(folder: Path) -> list[Row]:
    rows: list[Row] = pq.read_table(folder / "meta" / "episodes").to_pylist()
    return rows


def frames(folder: Path) -> list[Row]:
    files = sorted(folder.glob("data/*/*.parquet"))
    return [row for file in files for row in pq.read_table(file).to_pylist()]


def test_each_time_slot_is_an_episode_that_says_which_and_what_it_came_to(small_run: Path, folder: Path) -> None:
    names = ("object", "method", "policy", "experiment", "slot", "outcome")
    found = [tuple(row[name] for name in names) for row in episodes(folder)]
    assert found == [tuple(row[name] for name in names) for row in slots(small_run)]
    assert len(found) == 4


def test_an_episode_is_as_long_as_its_slot_and_lies_where_its_row_says(small_run: Path, folder: Path) -> None:
    first = 0
    for episode, slot in zip(episodes(folder), slots(small_run), strict=True):
        assert episode["length"] == pytest.approx((slot["end_s"] - slot["start_s"]) * FPS, abs=1)
        assert (episode["dataset_from_index"], episode["dataset_to_index"]) == (first, first + episode["length"])
        assert (episode["data/chunk_index"], episode["data/file_index"]) == (0, slot["experiment"])
        file = pq.read_table(folder / "data" / "chunk-000" / f"file-{slot['experiment']:03d}.parquet")
        own = [row for row in file.to_pylist() if row["episode_index"] == episode["episode_index"]]
        assert [row["index"] for row in own] == list(range(first, first + episode["length"]))
        assert [row["frame_index"] for row in own] == list(range(episode["length"]))
        assert [row["timestamp"] for row in own] == pytest.approx(np.arange(episode["length"]) / FPS, abs=1e-5)
        assert [row["next.done"] for row in own] == [False] * (episode["length"] - 1) + [True]
        assert any(row["next.success"] for row in own) == (slot["outcome"] == "placed")
        first += episode["length"]


def test_the_joints_follow_their_setpoints_and_the_jaws_close_and_open(folder: Path) -> None:
    rows = frames(folder)
    state = np.array([row["observation.state"] for row in rows])
    action = np.array([row["action"] for row in rows])
    same = np.array([row["episode_index"] for row in rows])
    inside = same[1:] == same[:-1]
    error = np.abs(state[1:] - action[:-1])[inside, :6]  # what is told by the next frame, and what is measured then
    assert len(error) > 1000
    assert np.quantile(error, 0.9) < np.radians(0.5)
    assert np.ptp(state[:, :6], axis=0).min() > 0.1
    assert state[:, 6].min() < 0.5 * state[:, 6].max()
    assert set(np.unique(np.sign(np.diff(action[:, 6])))) == {-1.0, 0.0, 1.0}


def test_the_statistics_are_those_of_all_frames(folder: Path) -> None:
    stats = json.loads((folder / "meta" / "stats.json").read_text(encoding="utf-8"))
    rows = frames(folder)
    assert set(stats) == set(rows[0])
    for name in ("observation.state", "action", "timestamp", "next.success"):
        values = np.array([row[name] for row in rows], dtype=np.float64).reshape(len(rows), -1)
        for kind, of in (("min", np.min), ("max", np.max), ("mean", np.mean), ("std", np.std)):
            assert stats[name][kind] == pytest.approx(of(values, axis=0), rel=1e-5, abs=1e-6)
        assert stats[name]["count"] == [len(rows)]
        assert len(stats[name]["q50"]) == values.shape[1]


def test_info_counts_and_describes_what_there_is(folder: Path) -> None:
    info = json.loads((folder / "meta" / "info.json").read_text(encoding="utf-8"))
    rows = frames(folder)
    assert (info["codebase_version"], info["fps"], info["video_path"]) == ("v3.0", FPS, None)
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (4, len(rows), 1)
    assert info["splits"] == {"train": "0:4"}
    assert list(info["features"]) == list(rows[0])
    assert info["features"]["action"]["shape"] == [7]
    assert len(info["features"]["action"]["names"]) == 7


def test_pandas_reads_the_tasks_as_the_index_of_their_table(folder: Path) -> None:
    tasks = pd.read_parquet(folder / "meta" / "tasks.parquet")
    assert list(tasks.index) == ["pick one handle from the belt and place it in the container"]
    assert tasks["task_index"].tolist() == [0]


def test_videos_have_a_picture_for_each_frame(small_run: Path, tmp_path: Path) -> None:
    one = ["--methods", "none", "--experiments", "1", "--fps", "1", "--rgb"]
    with pytest.raises(SystemExit) as end:
        main(["export", str(small_run), "--lerobot", str(tmp_path / "out"), *one])
    assert end.value.code == 0
    for key in CAMERAS.values():
        with av.open(str(tmp_path / "out" / "videos" / key / "chunk-000" / "file-000.mp4")) as container:
            pictures = [frame.to_ndarray(format="rgb24").astype(float) for frame in container.decode(video=0)]
        assert len(pictures) == len(frames(tmp_path / "out")) > 5
        assert pictures[0].shape == (SIZE[1], SIZE[0], 3)
        assert np.abs(pictures[3] - pictures[0]).mean() > 0.5  # the arm has moved
    rows = episodes(tmp_path / "out")
    assert rows[0]["videos/observation.images.wrist/to_timestamp"] == rows[0]["length"]


def test_videos_of_an_episode_lie_where_its_row_says(tmp_path: Path) -> None:
    files = LeRobotFiles(tmp_path, 10, videos=True)
    picture = np.full((2, 2, 3), 51, dtype=np.uint8)
    for number, lengths in ((0, (3, 2)), (1, (4,))):
        files.begin(number)
        for length in lengths:
            vectors = np.zeros((length, 7))
            marks = np.zeros(length, dtype=np.bool_)
            numbers = {"observation.state": vectors, "action": vectors, "next.done": marks, "next.success": marks}
            files.add_episode(numbers, {camera: [picture] for camera in CAMERAS}, "a task", {})
        files.end()
    files.finish()
    key = "videos/observation.images.wrist"
    names = ("file_index", "from_timestamp", "to_timestamp")
    found = [tuple(row[f"{key}/{name}"] for name in names) for row in episodes(tmp_path)]
    assert found == [(0, 0.0, 0.3), (0, 0.3, 0.5), (1, 0.0, 0.4)]
    stats = json.loads((tmp_path / "meta" / "stats.json").read_text(encoding="utf-8"))["observation.images.wrist"]
    assert np.shape(stats["mean"]) == (3, 1, 1)
    assert np.ravel(stats["mean"]) == pytest.approx(51 / 255)
    assert stats["count"] == [3]
