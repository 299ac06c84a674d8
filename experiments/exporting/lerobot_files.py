"""The files of a LeRobot dataset of version 3.0: Parquet tables, MP4 videos and JSON.

The layout is the one that lerobot 0.4.4 reads and writes: files of data and of videos with many episodes each, here one
per experiment, and a table of episodes that says where each of them lies.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from experiments.exporting.feature_stats import Stats, joined, stats_of, stats_of_pictures
from experiments.exporting.mp4 import CODEC, PIXELS
from experiments.results.provenance import write_json
from sim.model.robot import JOINTS

Numbers = dict[str, NDArray[Any]]

VERSION = "v3.0"
CAMERAS = {"wrist": "observation.images.wrist", "overview": "observation.images.overview"}
SIZE = 320, 240  # width and height of the videos, pixels
_CHUNK = 1000  # files per folder
_FILE = "chunk-{chunk_index:03d}/file-{file_index:03d}"
_DATA, _VIDEO = f"data/{_FILE}.parquet", f"videos/{{video_key}}/{_FILE}.mp4"
_AXES = [*JOINTS, "jaw_half_opening"]
_VECTOR = pa.list_(pa.float32(), len(_AXES))
_COLUMNS = {
    "observation.state": _VECTOR,
    "action": _VECTOR,
    "next.done": pa.bool_(),
    "next.success": pa.bool_(),
    "timestamp": pa.float32(),
    "frame_index": pa.int64(),
    "episode_index": pa.int64(),
    "index": pa.int64(),
    "task_index": pa.int64(),
}


def video_file(key: str, number: int) -> str:
    """Where the video of an experiment lies in the dataset."""
    return _VIDEO.format(video_key=key, **_place(number))


class LeRobotFiles:
    """A dataset that is being written, experiment by experiment: `begin`, `add_episode` ..., `end`; then `finish`.

    Attributes:
        folder: where it is.
        fps: frames per second.
        episodes: how many there are so far.
        frames: likewise.

    Args:
        folder: an empty one.
        fps: frames per second.
        videos: whether each experiment has videos.
    """

    def __init__(self, folder: Path, fps: int, *, videos: bool) -> None:
        self.folder, self.fps, self.episodes, self.frames = folder, fps, 0, 0
        self._cameras = CAMERAS if videos else {}
        self._tasks: dict[str, int] = {}
        self._rows: list[dict[str, Any]] = []  # of the table of episodes
        self._stats: list[dict[str, Stats]] = []
        self._number, self._first, self._tables = 0, 0, list[pa.Table]()

    def begin(self, number: int) -> None:
        """The episodes that follow are of this experiment."""
        self._number, self._first, self._tables = number, self.frames, []

    def add_episode(
        self,
        numbers: Numbers,
        pictures: Mapping[str, Sequence[NDArray[np.uint8]]],
        task: str,
        about: Mapping[str, Any],
    ) -> None:
        """Adds an episode.

        Args:
            numbers: its features by name, a value or vector for each of its frames.
            pictures: some of each camera's, for the statistics.
            task: what the robot is to do, in words.
            about: what else the table of episodes says.
        """
        length = len(numbers["action"])
        frames = np.arange(length)
        columns = {
            **numbers,
            "timestamp": frames / self.fps,
            "frame_index": frames,
            "episode_index": np.full(length, self.episodes),
            "index": self.frames + frames,
            "task_index": np.full(length, self._tasks.setdefault(task, len(self._tasks))),
        }
        arrays = [pa.array(columns[name].tolist(), type=kind) for name, kind in _COLUMNS.items()]
        self._tables.append(pa.table(arrays, names=list(_COLUMNS)))
        stats = {name: stats_of(column) for name, column in columns.items()}
        stats |= {CAMERAS[camera]: stats_of_pictures(some) for camera, some in pictures.items()}
        self._stats.append(stats)
        self._rows.append(self._row(length, task, about, stats))
        self.episodes, self.frames = self.episodes + 1, self.frames + length

    def end(self) -> None:
        """Writes the experiment's episodes; nothing if it has none."""
        if self._tables:
            path = self.folder / _DATA.format(**_place(self._number))
            path.parent.mkdir(parents=True, exist_ok=True)
            pq.write_table(pa.concat_tables(self._tables), path)

    def finish(self) -> None:
        """Writes what describes the dataset.

        Raises:
            UsageError: a file cannot be written.
        """
        meta = self.folder / "meta"
        (meta / "episodes" / "chunk-000").mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.Table.from_pylist(self._rows), meta / "episodes" / "chunk-000" / "file-000.parquet")
        pq.write_table(self._table_of_tasks(), meta / "tasks.parquet")
        names = self._stats[0]
        together = {name: joined([stats[name] for stats in self._stats]) for name in names}
        write_json(meta / "stats.json", {name: _as_lists(stats) for name, stats in together.items()})
        write_json(meta / "info.json", self._info())

    def _row(self, length: int, task: str, about: Mapping[str, Any], stats: Mapping[str, Stats]) -> dict[str, Any]:
        begin = self.frames - self._first  # of the experiment's files
        row = {
            "episode_index": self.episodes,
            "tasks": [task],
            "length": length,
            **{f"data/{name}": value for name, value in _place(self._number).items()},
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + length,
        }
        for key in self._cameras.values():
            row |= {f"videos/{key}/{name}": value for name, value in _place(self._number).items()}
            row[f"videos/{key}/from_timestamp"] = begin / self.fps
            row[f"videos/{key}/to_timestamp"] = (begin + length) / self.fps
        row |= {f"stats/{name}/{kind}": value for name, one in stats.items() for kind, value in _as_lists(one).items()}
        return row | {"meta/episodes/chunk_index": 0, "meta/episodes/file_index": 0} | dict(about)

    def _table_of_tasks(self) -> pa.Table:
        """The tasks with their numbers; the task is the index of pandas' table, which LeRobot reads it as."""
        index = {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object"}
        column = {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64"}
        columns = [{**one, "metadata": None} for one in (column, index)]
        pandas = {"index_columns": ["task"], "column_indexes": [], "columns": columns}
        table = pa.table({"task_index": list(self._tasks.values()), "task": list(self._tasks)})
        return table.replace_schema_metadata({"pandas": json.dumps(pandas)})

    def _info(self) -> dict[str, Any]:
        return {
            "codebase_version": VERSION,
            "robot_type": "ur10",
            "total_episodes": self.episodes,
            "total_frames": self.frames,
            "total_tasks": len(self._tasks),
            "chunks_size": _CHUNK,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": self.fps,
            "splits": {"train": f"0:{self.episodes}"},
            "data_path": _DATA,
            "video_path": _VIDEO if self._cameras else None,
            "features": {**self._videos(), **{name: _feature(kind) for name, kind in _COLUMNS.items()}},
        }

    def _videos(self) -> dict[str, Any]:
        width, height = SIZE
        info = {"height": height, "width": width, "codec": CODEC, "pix_fmt": PIXELS, "is_depth_map": False}
        info |= {"fps": self.fps, "channels": 3}
        video = {"dtype": "video", "shape": [height, width, 3], "names": ["height", "width", "channels"]}
        described = {**{f"video.{name}": value for name, value in info.items()}, "has_audio": False}
        return {key: {**video, "info": described} for key in self._cameras.values()}


def _place(number: int) -> dict[str, int]:
    return {"chunk_index": number // _CHUNK, "file_index": number % _CHUNK}


def _feature(kind: pa.DataType) -> dict[str, Any]:
    if pa.types.is_fixed_size_list(kind):
        return {"dtype": "float32", "shape": [kind.list_size], "names": _AXES}
    named = {pa.float32(): "float32", pa.int64(): "int64", pa.bool_(): "bool"}
    return {"dtype": named[kind], "shape": [1], "names": None}


def _as_lists(stats: Stats) -> dict[str, Any]:
    return {name: value.tolist() for name, value in stats.items()}
