"""From experiments to a video: several in one split picture, in step by the cell's clock."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.errors import UsageError
from experiments.observing.drawing import DARK, Image
from experiments.observing.take import Take
from experiments.progress import counted
from experiments.setup.experiment import ExperimentResult
from experiments.video.mp4 import load_av, mp4
from experiments.video.shots import Shot
from experiments.video.tile import Tile

_HEIGHTS = {1: 480, 2: 384}  # px of an overview, by the number of experiments; `_LEAST` for more
_LEAST = 360
_LAST = 1.0  # s of the video that its last picture stays


@dataclass(frozen=True, slots=True)
class VideoSettings:
    """How a video is made.

    Attributes:
        attempt: the one to show, by its number in the log; None for the whole experiment.
        speed_up: s of the cell's clock per s of the video.
        frames_per_second: of the video.
        samples: per pixel.
        height: of an overview, px; by default less, the more experiments there are.
    """

    attempt: int | None = None
    speed_up: float = 1.0
    frames_per_second: int = 12
    samples: int = 1
    height: int | None = None


def make_video(shots: Sequence[Shot], path: Path, settings: VideoSettings) -> list[ExperimentResult]:
    """Runs the experiments again and writes a video of them; returns what they came to.

    Each experiment begins with the video. With `settings.attempt`, each begins with the look that led to its attempt.

    Args:
        shots: what to show, one tile each.
        path: the MP4 file.
        settings: how.

    Raises:
        UsageError: PyAV is missing, the file cannot be written, or an experiment has no such attempt.
        SimError: the cell cannot be set up, or there is no off-screen OpenGL.
    """
    load_av()  # before an experiment has been run in vain
    takes = [shot.take() for shot in counted(shots, "experiment", "run again")]
    spans = [span(taken, settings.attempt) for taken in takes]
    columns = 1 if len(shots) <= 2 else math.ceil(math.sqrt(len(shots)))
    rows = math.ceil(len(shots) / columns)
    height = settings.height or _HEIGHTS.get(len(shots), _LEAST)
    tiles = [Tile(taken, height, settings.samples) for taken in takes]
    try:
        _write(tiles, spans, (rows, columns), path, settings)
    finally:
        for tile in tiles:
            tile.close()
    return [taken.result for taken in takes if taken.result is not None]


def span(taken: Take, attempt: int | None) -> tuple[float, float]:
    """Begin and end of what is to be shown, s.

    Raises:
        UsageError: there was no attempt of this number.
    """
    try:
        return taken.span(attempt)
    except LookupError as error:
        spec = taken.spec
        raise UsageError(
            f"expected --attempt {error} for {spec.part} × {spec.method}, experiment {spec.experiment}, got {attempt}"
        ) from None


def _write(
    tiles: Sequence[Tile],
    spans: Sequence[tuple[float, float]],
    grid: tuple[int, int],
    path: Path,
    settings: VideoSettings,
) -> None:
    """Draws all tiles at each time and writes the pictures; a tile that is over stays as it was at its end."""
    interval = settings.speed_up / settings.frames_per_second
    count = 1 + math.ceil(max(end - begin for begin, end in spans) / interval - 1e-6)
    high, wide, _ = tiles[0].shape
    size = grid[0] * high, grid[1] * wide
    still = round(_LAST * settings.frames_per_second)
    with mp4(path, size, settings.frames_per_second) as video:
        for number in counted(range(count), "frame", "draw"):
            times = [min(begin + number * interval, end) for begin, end in spans]
            picture = _joined([tile.draw(time) for tile, time in zip(tiles, times, strict=True)], grid)
            video.write(picture)
        for _ in range(still):
            video.write(picture)


def _joined(pictures: Sequence[Image], grid: tuple[int, int]) -> Image:
    """The pictures in rows and columns; places that are left stay dark."""
    rows, columns = grid
    high, wide, _ = pictures[0].shape
    joined = np.full((rows * high, columns * wide, 3), DARK, dtype=np.uint8)
    for number, picture in enumerate(pictures):
        row, column = divmod(number, columns)
        joined[row * high : (row + 1) * high, column * wide : (column + 1) * wide] = picture
    return joined
