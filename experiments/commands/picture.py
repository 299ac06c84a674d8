"""`graspcell picture`: what the cell looks like, from beside it or from the wrist."""

import cv2

from cell.records import TimeSlot, Transition
from experiments.commands.config import Picture
from experiments.errors import UsageError
from experiments.setup.checks import writable_folder
from experiments.setup.experiment import ExperimentSpec, run_experiment
from sim.errors import MeshesMissingError
from sim.model.renderer import Renderer
from sim.networks.ground_truth import LatestTruth
from sim.runtime.episode import SimCell, build_cell


class _Taken(Exception):  # noqa: N818  # ends the experiment once the picture is taken
    pass


def picture(config: Picture) -> int:
    """Runs an experiment up to the wanted moment and writes the picture; returns the exit code.

    Raises:
        UsageError: an argument that cannot be.
    """
    spec = config.spec()
    writable_folder(config.out.parent)
    placed = 0
    cell = _build(spec)

    def tell(record: object, latest_truth: LatestTruth) -> None:
        nonlocal placed
        if isinstance(record, TimeSlot):
            placed += 1
        if isinstance(record, Transition) and record.target == config.state and placed >= config.after:
            _take(cell, config)
            raise _Taken

    try:
        run_experiment(spec, tell, cell)
    except _Taken:
        print(f"picture in {config.out}")
        return 0
    raise UsageError(f"the experiment never came to the state {config.state!r} after {config.after} parts")


def _build(spec: ExperimentSpec) -> SimCell:
    try:
        return build_cell(*spec.cell)
    except MeshesMissingError as error:
        raise UsageError(str(error)) from error


def _take(cell: SimCell, config: Picture) -> None:
    world = cell.world
    width, height = config.size
    renderer = Renderer(world.mj_model, height, width)
    try:
        renderer.rgb(world.data, config.camera)  # the first frame's shadows may differ by a grey level
        image = renderer.rgb(world.data, config.camera)
    finally:
        renderer.close()
    cv2.imwrite(str(config.out), image[..., ::-1])
