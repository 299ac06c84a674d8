"""Plays recorded estimates back, frame by frame: an experiment as it was, or what networks said elsewhere."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from cell.interfaces import Detection, Frame, Image
from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from maskval import Pose, bop, mask_from_rle, mdd

LOGS = ("frames.parquet", "estimates.parquet", "transitions.parquet")
MASKS, POSES = "masks.json", ("poses.csv", "poses_2.csv")  # of one network, or of two
_ELSEWHERE = 0.001  # m: the robot comes back to a view within micrometres; another view is centimetres away

Entry = tuple[Detection, tuple[Pose, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """What was recorded of one frame: where the camera was, if that is known, detections and a pose of each network."""

    X_BC: Pose | None
    entries: tuple[Entry, ...]


class Recording:
    """Implements `cell.interfaces.MaskEstimator`, with pose networks in `networks`: what was estimated at the time.

    Args:
        name: where it comes from, for messages.
        frames: by the index of the frame.
        inference_time: s that detector and networks took together.
        networks: how many pose networks there were.
    """

    images: frozenset[Image] = frozenset()

    def __init__(self, name: str, frames: dict[int, Recorded], inference_time: float, networks: int) -> None:
        self._name, self._frames, self.inference_time = name, frames, inference_time
        self.networks = tuple(_Network(self, number) for number in range(networks))

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        return [detection for detection, _ in self.of(frame)]

    def of(self, frame: Frame) -> tuple[Entry, ...]:
        """The detections recorded of a frame, each with its poses.

        Raises:
            LookupError: the frame was not recorded, or from elsewhere.
        """
        if frame.index not in self._frames:
            raise LookupError(f"{self._name} has no frame {frame.index}, only 0 to {max(self._frames)}")
        recorded = self._frames[frame.index]
        if recorded.X_BC is not None:
            shift = mdd(frame.X_BC, recorded.X_BC, np.vstack([np.zeros(3), np.eye(3)]))
            if shift > _ELSEWHERE:
                raise LookupError(
                    f"{self._name}: frame {frame.index} was recorded from another view than the present one; "
                    "expected the same seed, method, policy, thresholds and speed"
                )
        return recorded.entries


class _Network:
    """Implements `cell.interfaces.PoseEstimator`; its time is charged with the detector's."""

    images: frozenset[Image] = frozenset()
    inference_time = 0.0

    def __init__(self, recording: Recording, number: int) -> None:
        self._recording, self._number = recording, number

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[Pose]:
        """See `PoseEstimator`; the detections are the recorded ones, sorted by score as they were recorded."""
        return [poses[self._number] for _, poses in self._recording.of(frame)]


def load_recording(folder: Path, setup: EstimatorSetup, method: str) -> Recording:
    """The recording of one experiment: the logs of compare or run, else poses and masks in BOP's files.

    Raises:
        UsageError: the folder has neither, or nothing of this experiment.
        MaskvalError: a BOP file is malformed.
    """
    if all((folder / name).is_file() for name in LOGS):
        return _of_logs(folder, setup, method)
    if (folder / MASKS).is_file() and (folder / POSES[0]).is_file():
        return _of_bop(folder, setup)
    raise UsageError(
        f"{folder}: expected {', '.join(LOGS)}, as compare and run write them, or BOP's {MASKS} and {POSES[0]}"
    )


def _of_logs(folder: Path, setup: EstimatorSetup, method: str) -> Recording:
    key = {"object": setup.part.name, "method": method, "experiment": setup.experiment}
    name = f"{folder}, {setup.part.name} × {method}, experiment {setup.experiment}"
    frames, estimates, transitions = (_rows(folder / file, key) for file in LOGS)
    by_frame: dict[int, list[Entry]] = defaultdict(list)
    for row in estimates:
        mask = mask_from_rle(row["mask_rle"], setup.camera.height, setup.camera.width)
        poses = tuple(_pose(row[column]) for column in ("X_CO_est", "X_CO_est_2") if row[column] is not None)
        by_frame[row["frame"]].append((Detection(mask, row["score"]), poses))
    whole = [row for row in frames if row["detections"] is not None]
    decided = next((row["time_s"] for row in transitions if row["target"] == "decide"), None)
    if not whole or decided is None:
        raise UsageError(f"{name}: nothing recorded")
    recorded = {row["frame"]: Recorded(_pose(row["X_BC"]), tuple(by_frame[row["frame"]])) for row in whole}
    networks = max((len(poses) for entries in by_frame.values() for _, poses in entries), default=2)
    return Recording(name, recorded, round(decided - frames[0]["time_s"], 6), networks)  # whole µs, as it was set


def _of_bop(folder: Path, setup: EstimatorSetup) -> Recording:
    """Scene is the experiment, image the frame; detection i and pose i of an image belong together, in file order."""
    files = [folder / name for name in POSES if (folder / name).is_file()]
    name = f"{folder}, scene {setup.experiment}"
    detections = [one for one in bop.read_detections(folder / MASKS) if one.scene_id == setup.experiment]
    results = [[one for one in bop.read_results(file) if one.scene_id == setup.experiment] for file in files]
    if not detections:
        raise UsageError(f"{name}: nothing recorded")
    frames = {}
    for index in range(max(one.im_id for one in detections) + 1):
        found = [one for one in detections if one.im_id == index]
        poses = [[one.X_CO for one in of_network if one.im_id == index] for of_network in results]
        for file, of_network in zip(files, poses, strict=True):
            if len(of_network) != len(found):
                raise UsageError(
                    f"{file}: expected {len(found)} poses in scene {setup.experiment}, image {index}, "
                    f"one for each mask, got {len(of_network)}"
                )
        entries = [(Detection(one.mask, one.score), one_each) for one, *one_each in zip(found, *poses, strict=True)]
        frames[index] = Recorded(None, tuple((detection, tuple(each)) for detection, each in _by_score(entries)))
    times = [results[0][0].time_s, detections[0].time_s]
    if min(times) < 0.0:
        raise UsageError(f"{name}: expected the time of detector and pose network in the files, s, got {times}")
    return Recording(name, frames, sum(times), len(files))


def _by_score(entries: Sequence[tuple[Detection, list[Pose]]]) -> Iterator[tuple[Detection, list[Pose]]]:
    """Best score first, and equal ones in their order: as the controller sorts detections."""
    return iter(sorted(entries, key=lambda entry: -entry[0].score))


def _rows(file: Path, key: dict[str, object]) -> list[dict[str, Any]]:
    try:
        rows: list[dict[str, Any]] = pq.read_table(
            file, filters=[(name, "==", value) for name, value in key.items()]
        ).to_pylist()
    except (OSError, ValueError) as error:
        raise UsageError(f"{file}: expected a log of compare or run: {error}") from error
    return rows


def _pose(numbers: Sequence[float]) -> Pose:
    """X_AB of seven numbers: translation, then quaternion w, x, y, z."""
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])
