"""A cell ready for experiments, built once per process, and how the parts lie when an experiment begins."""

from dataclasses import dataclass
from functools import lru_cache

from cell.layout import Belt, Layout
from maskval import Pose
from sim.camera import Camera
from sim.conditions import Conditions
from sim.latents import Streams
from sim.parts import load_part
from sim.placement import feed_parts, feeding_length, place_parts
from sim.world import World


@dataclass(frozen=True, slots=True)
class Bench:
    """A world with its camera, built once and reset for every experiment."""

    world: World
    camera: Camera


def build_bench(part: str, parts: int, conditions: Conditions, maker_meshes: bool, /) -> Bench:
    """A bench of one's own.

    Args:
        part: name or TOML file of the part.
        parts: how many of them.
        conditions: what disturbs the cell.
        maker_meshes: whether the arm is drawn with its maker's meshes.
    """
    layout = Layout(belt=belt_under(conditions, parts))
    world = World(layout, load_part(part), parts, conditions, maker_meshes)
    return Bench(world, Camera(world.model, layout.camera.height, layout.camera.width))


bench = lru_cache(maxsize=4)(build_bench)  # kept, since compiling and opening a renderer take a second


def belt_under(conditions: Conditions, parts: int) -> Belt:
    """The belt as it is; if it moves, with room upstream for all the parts that come along."""
    speed = conditions.belt_speed
    return Belt(speed=speed, upstream=feeding_length(speed, conditions.takt_s, parts)) if speed else Belt()


def starting_poses(world: World, streams: Streams) -> list[Pose]:
    """X_WO of the parts: a function of conditions, seed, kind and number of the experiment, whatever the method."""
    belt, rng = world.layout.belt, streams.generator(part=0, purpose="placement")
    if belt.speed:
        return feed_parts(world.part_model, world.parts, belt, rng, world.conditions.takt_s)
    return place_parts(world.part_model, world.parts, belt, rng)
