"""`graspcell picture`: a picture of the cell, from beside it or from the wrist."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.records import TimeSlot, Transition
from experiments.commands.picture_config import Picture
from experiments.errors import UsageError
from experiments.results.files import replacing
from experiments.setup.checks import writable_folder
from experiments.setup.experiment import ExperimentSpec, run_experiment
from sim.errors import MeshesMissingError
from sim.model.renderer import Renderer
from sim.networks.ground_truth import LatestTruth
from sim.runtime.episode import SimCell, build_cell


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
    cell = _build(spec)

    def tell(record: object, latest_truth: LatestTruth) -> None:
        nonlocal placed
        if isinstance(record, TimeSlot):
            placed += 1
        if isinstance(record, Transition) and record.target == config.state and placed >= config.after:
            raise _Taken(_take(cell, config))

    try:
        run_experiment(spec, tell, cell)
    except _Taken as taken:
        _write(config.out, taken.image)
        print(f"picture in {config.out}")
        return 0
    raise UsageError(f"the experiment never reached the state {config.state!r} after {config.after} parts")


def _build(spec: ExperimentSpec) -> SimCell:
    try:
        return build_cell(*spec.cell)
    except MeshesMissingError as error:
        raise UsageError(str(error)) from error


def _take(cell: SimCell, config: Picture) -> NDArray[np.uint8]:
    world = cell.world
    width, height = config.size
    renderer = Renderer(world.mj_model, height, width)
    try:
        renderer.rgb(world.data, config.camera)  # the first frame's shadows may differ by a grey level
        return renderer.rgb(world.data, config.camera)
    finally:
        renderer.close()


def _write(path: Path, image: NDArray[np.uint8]) -> None:
    _, encoded = cv2.imencode(path.suffix, image[..., ::-1])
    with replacing(path) as file:
        file.write(encoded.tobytes())
