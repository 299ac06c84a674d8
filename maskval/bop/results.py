"""Pose estimates as BOP's results CSV: `scene_id,im_id,obj_id,score,R,t,time`."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maskval.bop.fields import M_PER_MM, is_whole, numbers_of, warn_of_scores
from maskval.bop.poses import PoseReader
from maskval.errors import InvalidFileError
from maskval.geometry import Pose, as_pose
from maskval.inputs.files import MOST_RESULTS, read_input_text

FIELDS = ("scene_id", "im_id", "obj_id", "score", "R", "t", "time")
# What BOP writes for a time that was not measured.
UNKNOWN_TIME = -1.0


@dataclass(frozen=True, slots=True)
class PoseResult:
    """A pose estimate.

    Args:
        scene_id: Scene.
        im_id: Image in the scene.
        obj_id: Object.
        score: Confidence of the estimate; high is good.
        X_CO: Pose of the object in the camera frame, or its homogeneous matrix, (4, 4).
        time_s: Time that the method took for all of the image, seconds, or -1.
    """

    scene_id: int
    im_id: int
    obj_id: int
    score: float
    X_CO: Pose
    time_s: float = UNKNOWN_TIME

    def __post_init__(self) -> None:
        object.__setattr__(self, "X_CO", as_pose(self.X_CO))


def read_results(path: Path) -> list[PoseResult]:
    """The estimates of a results file, translations turned from millimetres to metres.

    Args:
        path: The CSV file, with or without its header.

    Raises:
        InvalidFileError: If a line is malformed or stands there twice; the message says file, line and column.
    """
    first_lines: dict[str, int] = {}
    results = []
    with PoseReader(path) as poses:
        for number, line in enumerate(read_input_text(path, MOST_RESULTS).splitlines(), start=1):
            if not line.strip() or (number == 1 and line.replace(" ", "") == ",".join(FIELDS)):
                continue
            results.append(_result(line, f"{path}:{number}", poses))
            if (first := first_lines.setdefault(line, number)) != number:
                raise InvalidFileError(f"{path}:{number}:1: expected each pose once, but this is that of line {first}")
    warn_of_scores(path, [result.score for result in results])
    return results


def write_results(path: Path, results: Iterable[PoseResult]) -> None:
    """Writes estimates as bop_toolkit reads them, translations in millimetres.

    Args:
        path: The CSV file.
        results: The estimates.
    """
    lines = [",".join(FIELDS)]
    for result in results:
        rotation = " ".join(repr(float(value)) for value in result.X_CO.rotation.ravel())
        translation = " ".join(repr(float(value / M_PER_MM)) for value in result.X_CO.translation)
        ids = f"{result.scene_id},{result.im_id},{result.obj_id}"
        lines.append(f"{ids},{float(result.score)!r},{rotation},{translation},{float(result.time_s)!r}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _result(line: str, place: str, poses: PoseReader) -> PoseResult:
    fields = line.split(",")
    if len(fields) != len(FIELDS):
        raise InvalidFileError(
            f"{place}:1: expected the {len(FIELDS)} fields {','.join(FIELDS)}, but found {len(fields)}"
        )
    # The column of each field, counted from 1 as editors do.
    columns = np.cumsum([1] + [len(field) + 1 for field in fields])
    places = [f"{place}:{column}" for column in columns]
    ids = [_integer(fields[k], places[k], FIELDS[k]) for k in range(3)]
    (score,), rotation, translation_mm, (time_s,) = (
        _numbers(fields[k], count, places[k], FIELDS[k]) for k, count in ((3, 1), (4, 9), (5, 3), (6, 1))
    )
    if time_s < 0 and time_s != UNKNOWN_TIME:
        raise InvalidFileError(f"{places[6]}: expected time as seconds >= 0, or -1, but found {fields[6].strip()!r}")
    X_CO = poses.pose(rotation, translation_mm, places[4])
    return PoseResult(ids[0], ids[1], ids[2], float(score), X_CO, float(time_s))


def _integer(text: str, place: str, name: str) -> int:
    if not is_whole(text.strip()):
        raise InvalidFileError(f"{place}: expected {name} as a whole number, but found {text.strip()!r}")
    return int(text)


def _numbers(text: str, count: int, place: str, name: str) -> NDArray[np.float64]:
    numbers = numbers_of(text)
    if numbers is None or len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise InvalidFileError(f"{place}: expected {name} as {count} finite numbers, but found {text.strip()!r}")
    return np.array(numbers)
