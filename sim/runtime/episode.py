"""An episode: the cell reset for one experiment, with the robot's station, the referee and the perception."""

from dataclasses import dataclass, replace

from cell.interfaces import MaskEstimator, PoseEstimator
from cell.layout import Belt, Layout
from cell.perception import Perception
from maskval import Pose, UncertaintyMethod
from sim.instance_ids import PIXEL_CENTER
from sim.model.clutter import CLEARANCES, distractors_of, place_distractors
from sim.model.conditions import Conditions
from sim.model.parts import load_part
from sim.model.placement import feed_parts, feeding_length, place_parts
from sim.networks.estimators import Kind, make_estimators
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import PartNoise, load_noise
from sim.networks.random_streams import Streams
from sim.polygons import convex_outline
from sim.runtime.compile_kernels import compile_for_networks
from sim.runtime.referee import SimReferee
from sim.runtime.start_check import check_start
from sim.runtime.station import SimStation
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera

Estimators = tuple[MaskEstimator, tuple[PoseEstimator, ...]]


@dataclass(frozen=True, slots=True)
class SimCell:
    """The physics of the cell with its wrist camera, built once and reset for every experiment."""

    world: World
    camera: WristCamera


def build_cell(part: str, parts: int, conditions: Conditions, maker_meshes: bool, /) -> SimCell:
    """Compiles the cell, which takes a second.

    Args:
        part: name or TOML file of the part.
        parts: how many of them.
        conditions: what disturbs the cell.
        maker_meshes: whether the arm is drawn with its maker's meshes.
    """
    layout, model = Layout(belt=belt_under(conditions, parts)), load_part(part)
    world = World(layout, model, parts, conditions, maker_meshes)
    compile_for_networks(model, layout.camera)
    return SimCell(world, WristCamera(world))


def belt_under(conditions: Conditions, parts: int) -> Belt:
    """The belt as it is; if it moves, with room upstream for all the parts that come along."""
    belt = Belt(speed=conditions.belt_speed)
    if not belt.speed:
        return belt
    return replace(belt, upstream=feeding_length(conditions.belt_true(belt).speed, conditions.takt_s, parts))


def starting_poses(world: World, streams: Streams) -> list[Pose]:
    """X_WO of the parts, then of the distractors: whatever the method, the same for conditions, streams and kind."""
    belt, rng = world.belt_true, streams.generator(part=0, purpose="placement")
    if belt.speed:
        return feed_parts(world.part_model, world.parts, belt, rng, world.conditions.takt_s)
    model, clutter = world.part_model, world.conditions.clutter
    leaning = clutter == "touching"
    parts = place_parts(model, world.parts, belt, rng, CLEARANCES[clutter], leaning=leaning)
    outlines = [convex_outline(pose.apply(model.part.mesh.vertices)) for pose in parts]
    things = streams.generator(part=0, purpose="distractors")
    return parts + place_distractors(distractors_of(clutter), outlines, belt, things)


@dataclass(frozen=True, slots=True, eq=False)
class Episode:
    """What a controller meets: the robot, its referee, and what it sees with."""

    station: SimStation
    referee: SimReferee
    perception: Perception


def begin_episode(
    cell: SimCell,
    streams: Streams,
    latest_truth: LatestTruth,
    estimators: Kind | Estimators,
    method: UncertaintyMethod,
    *,
    noise: PartNoise | None = None,
) -> Episode:
    """Lays the parts on the belt, lets them settle, and sets the clock to 0.

    Args:
        cell: the cell; the episode before is over.
        streams: the root of the experiment's random numbers.
        latest_truth: is told the truth about every frame.
        estimators: "noisy" or "oracle", or a detector and pose networks of one's own.
        method: says how uncertain poses are.
        noise: error model of the simulated networks; the part's own by default.

    Raises:
        SimError: the parts have no room, or do not come to rest on the belt.
    """
    world, model = cell.world, cell.world.part_model
    world.reset(starting_poses(world, streams))
    check_start(world)
    station = SimStation(world, cell.camera, latest_truth)
    if isinstance(estimators, str):
        estimators = make_estimators(estimators, latest_truth, model.part, noise or load_noise(model.noise), streams)
    detector, networks = estimators
    perception = Perception(model.part, detector, networks, method, PIXEL_CENTER)
    return Episode(station, SimReferee(world, station), perception)
