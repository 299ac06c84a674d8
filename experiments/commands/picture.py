"""`graspcell picture`: what the cell looks like, from beside it or from the wrist."""

import cv2

from cell.records import Slot, Transition
from experiments.commands.config import Picture
from experiments.errors import UsageError
from experiments.setup.checks import writable_folder
from experiments.setup.experiment import ExperimentSpec, run_experiment
from sim.errors import MeshesMissingError
from sim.model.renderer import Camera
from sim.networks.ground_truth import TruthBooth
from sim.runtime.sim_cell import bench


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

    def tell(record: object, booth: TruthBooth) -> None:
        nonlocal placed
        if isinstance(record, Slot):
            placed += 1
        if isinstance(record, Transition) and record.target == config.state and placed >= config.after:
            _take(spec, config)
            raise _Taken

    try:
        run_experiment(spec, tell)
    except _Taken:
        print(f"picture in {config.out}")
        return 0
    except MeshesMissingError as error:
        raise UsageError(str(error)) from error
    raise UsageError(f"the experiment never came to the state {config.state!r} after {config.after} parts")


def _take(spec: ExperimentSpec, config: Picture) -> None:
    world = bench(*spec.cell).world
    width, height = config.size
    camera = Camera(world.model, height, width)
    try:
        camera.rgb(world.data, config.camera)  # the first frame's shadows may differ by a grey level
        image = camera.rgb(world.data, config.camera)
    finally:
        camera.close()
    cv2.imwrite(str(config.out), image[..., ::-1])
