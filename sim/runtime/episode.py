"""What a controller meets: a bench reset for one experiment, with its station, referee and perception."""

from dataclasses import dataclass

from cell.interfaces import MaskEstimator, PoseEstimator
from cell.perception import Perception
from maskval import UncertaintyMethod
from sim.instance_ids import PIXEL_CENTER
from sim.networks.estimators import Kind, make_estimators
from sim.networks.ground_truth import TruthBooth
from sim.networks.noise_model import PartNoise, load_noise
from sim.networks.random_streams import Streams
from sim.runtime.referee import SimReferee
from sim.runtime.sim_cell import Bench, starting_poses
from sim.runtime.station import SimStation

Estimators = tuple[MaskEstimator, tuple[PoseEstimator, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """The robot, who judges it, and what it sees with."""

    station: SimStation
    referee: SimReferee
    perception: Perception


def set_stage(
    here: Bench,
    streams: Streams,
    booth: TruthBooth,
    estimators: Kind | Estimators,
    method: UncertaintyMethod,
    *,
    noise: PartNoise | None = None,
) -> Stage:
    """Lays the parts on the belt, lets them settle, and sets the clock to 0.

    Args:
        here: the bench; what stood on it before is over.
        streams: the root of the experiment's random numbers.
        booth: is told the truth about every frame.
        estimators: "noisy" or "oracle", or a detector and pose networks of one's own.
        method: says how uncertain poses are.
        noise: error model of the simulated networks; the part's own by default.

    Raises:
        SimError: the parts have no room, or do not come to rest.
    """
    world, model = here.world, here.world.part_model
    world.reset(starting_poses(world, streams))
    station = SimStation(world, here.camera, booth)
    if isinstance(estimators, str):
        estimators = make_estimators(estimators, booth, model.part, noise or load_noise(model.noise), streams)
    detector, networks = estimators
    perception = Perception(model.part, detector, networks, method, PIXEL_CENTER)
    return Stage(station, SimReferee(world, station), perception)
