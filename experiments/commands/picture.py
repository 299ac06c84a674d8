"""`graspcell picture`: a picture of the cell, from beside it or from the wrist."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.records import TimeSlot, Transition
from experiments.commands.picture_config import Picture
from experiments.errors import UsageError
from experiments.progress import saying
from experiments.results.files import replacing
from experiments.setup.checks import writable_folder
from experiments.setup.experiment import run_experiment
from sim.errors import MeshesMissingError
from sim.networks.ground_truth import LatestTruth
from sim.runtime.episode import build_cell
from sim.runtime.pictures import FINE_SAMPLES, Pictures
from sim.runtime.world import World


class _Taken(Exception):  # noqa: N818  # ends the experiment once the picture is taken
    def __init__(self, image: NDArray[np.uint8]) -> None:
        self.image = image


def picture(config: Picture) -> int:
    """Runs an experiment up to the wanted moment and writes the picture; returns the exit code.

    Raises:
        UsageError: an invalid argument.
    """
    spec = config.spec()
    writable_folder(config.out.parent)
    if config.out.is_dir():
        raise UsageError(f"cannot write {config.out}: expected the path of a picture, got a folder")
    placed = 0
    cell = build_cell(*spec.cell)
    pictures = _open(cell.world, config.size)

    def tell(record: object, latest_truth: LatestTruth) -> None:
        nonlocal placed
        if isinstance(record, TimeSlot):
            placed += 1
        if isinstance(record, Transition) and record.target == config.state and placed >= config.after:
            raise _Taken(pictures.rgb(config.camera))

    try:
        with saying(f"run up to {config.state} after {config.after} parts"):
            run_experiment(spec, tell, cell)
    except _Taken as taken:
        _write(config.out, taken.image)
        print(f"picture in {config.out}")
        return 0
    finally:
        pictures.close()
    raise UsageError(f"the experiment never reached the state {config.state!r} after {config.after} parts")


def _open(world: World, size: tuple[int, int]) -> Pictures:
    width, height = size
    try:
        return Pictures(world, height, width, FINE_SAMPLES)
    except MeshesMissingError as error:
        raise UsageError(str(error)) from error


def _write(path: Path, image: NDArray[np.uint8]) -> None:
    _, encoded = cv2.imencode(path.suffix, image[..., ::-1])
    with replacing(path) as file:
        file.write(encoded.tobytes())
