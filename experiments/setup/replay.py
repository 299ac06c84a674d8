"""Plays recorded estimates back, frame by frame: those of an earlier experiment, or of networks run elsewhere."""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from cell.interfaces import Detection, Frame, Image
from cell.perception import by_score
from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from experiments.results.store import SCHEMAS
from maskval import InvalidFileError, MaskvalError, Pose, bop, mask_from_rle, mdd
from maskval.inputs.files import MOST_RESULTS, check_input

LOGS = ("frames.parquet", "estimates.parquet")
MASKS, POSES = "masks.json", ("poses.csv", "poses_2.csv")  # of one network, or of two
_COLUMNS = {  # of a log: what every row has, and what may be null
    "frames": (("frame", "X_BC", "inference_s"), ("detections",)),
    "estimates": (("frame", "mask_rle", "score", "X_CO_est"), ("X_CO_est_2",)),
}
_ELSEWHERE = 0.001  # m: the robot comes back to a view within micrometres; another view is centimetres away

Row = TypeVar("Row", bop.DetectionResult, bop.PoseResult)
Entry = tuple[Detection, tuple[Pose, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Recorded:
    """What was recorded of one frame: where the camera was, if that is known, detections and a pose of each network."""

    X_BC: Pose | None
    entries: tuple[Entry, ...]


class Recording:
    """Implements `cell.interfaces.MaskEstimator`, with pose networks in `networks`: the recorded estimates.

    Args:
        name: where it comes from, for messages.
        frames: by the index of the frame.
        inference_time: s that detector and networks took together.
        networks: how many pose networks there were.
        unseen: the estimates for a frame that is not recorded; None if every frame must be.
    """

    images: frozenset[Image] = frozenset()

    def __init__(
        self,
        name: str,
        frames: dict[int, Recorded],
        inference_time: float,
        networks: int,
        unseen: Recorded | None = None,
    ) -> None:
        self._name, self._frames, self._unseen, self.inference_time = name, frames, unseen, inference_time
        self.networks = tuple(_Network(self, number) for number in range(networks))

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        return [detection for detection, _ in self.of(frame)]

    def of(self, frame: Frame) -> tuple[Entry, ...]:
        """The detections recorded of a frame, each with its poses.

        Raises:
            LookupError: the frame was not recorded, or from another view.
        """
        recorded = self._frames.get(frame.index, self._unseen)
        if recorded is None:
            raise LookupError(f"{self._name} has no frame {frame.index}, only 0 to {max(self._frames)}")
        if recorded.X_BC is not None:
            shift = mdd(frame.X_BC, recorded.X_BC, np.vstack([np.zeros(3), np.eye(3)]))
            if shift > _ELSEWHERE:
                raise LookupError(
                    f"{self._name}: frame {frame.index} was recorded from another view; "
                    "expected the same seed, method, policy, thresholds and speed"
                )
        return recorded.entries


class _Network:
    """Implements `cell.interfaces.PoseEstimator`; the detector's time includes its own."""

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
        UsageError: the folder has neither, nothing of this experiment, or a file that is malformed or no regular one.
    """
    try:
        if all((folder / name).exists() for name in LOGS):
            return _of_logs(folder, setup, method)
        if (folder / MASKS).exists() and (folder / POSES[0]).exists():
            return _of_bop(folder, setup)
    except InvalidFileError as error:
        raise UsageError(str(error)) from error
    raise UsageError(
        f"{folder}: expected {', '.join(LOGS)}, as compare and run write them, or BOP's {MASKS} and {POSES[0]}"
    )


def _of_logs(folder: Path, setup: EstimatorSetup, method: str) -> Recording:
    key = {"object": setup.part.name, "method": method, "experiment": setup.experiment}
    name = f"{folder}, {setup.part.name} × {method}, experiment {setup.experiment}"
    frames, estimates = (_rows(folder / file, key) for file in LOGS)
    whole = [row for row in frames if row["detections"] is not None]
    if not whole:
        raise UsageError(f"{name}: nothing recorded")
    by_frame: dict[int, list[Entry]] = defaultdict(list)
    for row in estimates:
        try:
            mask = mask_from_rle(row["mask_rle"], setup.camera.height, setup.camera.width)
            poses = tuple(_pose(row[column]) for column in ("X_CO_est", "X_CO_est_2") if row[column] is not None)
            by_frame[row["frame"]].append((Detection(mask, row["score"]), poses))
        except (MaskvalError, TypeError) as error:
            raise UsageError(f"{name}: frame {row['frame']}: {error}") from error
    try:
        recorded = {row["frame"]: Recorded(_pose(row["X_BC"]), tuple(by_frame[row["frame"]])) for row in whole}
    except (MaskvalError, TypeError) as error:
        raise UsageError(f"{name}: X_BC of a frame: {error}") from error
    counts = {len(poses) for entries in by_frame.values() for _, poses in entries} or {2}
    if len(counts) > 1:
        raise UsageError(f"{name}: expected X_CO_est_2 of every estimate or of none")
    return Recording(name, recorded, whole[0]["inference_s"], counts.pop())


def _of_bop(folder: Path, setup: EstimatorSetup) -> Recording:
    """Scene is the experiment, image the frame; detection i and pose i of an image belong together, in file order."""
    files = [folder / file for file in POSES if (folder / file).exists()]
    name = f"{folder}, scene {setup.experiment}"
    found = _by_image(bop.read_detections(folder / MASKS), setup.experiment)
    networks = [_by_image(bop.read_results(file), setup.experiment) for file in files]
    if not found:
        raise UsageError(f"{name}: nothing recorded")
    frames = {}
    for image in sorted(found.keys() | set[int]().union(*networks)):
        masks, poses = found[image], [network[image] for network in networks]
        for file, of_network in zip(files, poses, strict=True):
            if len(of_network) != len(masks):
                raise UsageError(
                    f"{file}: expected {len(masks)} poses in scene {setup.experiment}, image {image}, "
                    f"one for each mask, got {len(of_network)}"
                )
        entries = [
            (Detection(mask.mask, mask.score), tuple(result.X_CO for result in results))
            for mask, *results in zip(masks, *poses, strict=True)
        ]
        frames[image] = Recorded(None, tuple(sorted(entries, key=lambda entry: by_score(entry[0]))))
    first = min(found)
    times = [found[first][0].time_s, *(network[first][0].time_s for network in networks)]
    if min(times) < 0.0:
        raise UsageError(f"{name}: expected the time of detector and pose networks in the files, s, got {times}")
    return Recording(name, frames, sum(times), len(files), unseen=Recorded(None, ()))


def _by_image(rows: Iterable[Row], scene: int) -> dict[int, list[Row]]:
    """The rows of one scene by image, in the order of the file; BOP's files leave out images without rows."""
    images: dict[int, list[Row]] = defaultdict(list)
    for row in rows:
        if row.scene_id == scene:
            images[row.im_id].append(row)
    return images


def _rows(file: Path, key: dict[str, object]) -> list[dict[str, Any]]:
    try:
        table = pq.read_table(
            check_input(file, MOST_RESULTS), filters=[(name, "==", value) for name, value in key.items()]
        )
        schema, (needed, optional) = SCHEMAS[file.stem], _COLUMNS[file.stem]
        columns = [schema.field(name) for name in (*needed, *optional)]
        rows: list[dict[str, Any]] = table.select([*needed, *optional]).cast(pa.schema(columns)).to_pylist()
    except InvalidFileError:
        raise
    except (OSError, ValueError, KeyError, NotImplementedError) as error:  # Arrow's, of a column missing or of a type
        reason = next(iter(str(error).splitlines()), "")
        raise UsageError(f"{file}: expected a log of compare or run: {reason}") from error
    for row in rows:
        for name in () if row.get("detections", 0) is None else needed:
            if row[name] is None:
                raise UsageError(f"{file}: expected {name} in every row, got null in frame {row['frame']}")
    return rows


def _pose(numbers: Sequence[float]) -> Pose:
    """X_AB of seven numbers: translation, then quaternion w, x, y, z."""
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])
