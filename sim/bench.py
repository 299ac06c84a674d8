"""A cell ready for experiments, built once per process, and how the parts lie when an experiment begins."""

from dataclasses import dataclass
from functools import lru_cache

from cell.layout import Layout
from maskval import Pose
from sim.camera import Camera
from sim.conditions import Conditions
from sim.latents import Streams
from sim.parts import PartModel, load_part
from sim.placement import place_parts
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
    layout = Layout()
    world = World(layout, load_part(part), parts, conditions, maker_meshes)
    return Bench(world, Camera(world.model, layout.camera.height, layout.camera.width))


bench = lru_cache(maxsize=4)(build_bench)  # kept, since compiling and opening a renderer take a second


def starting_poses(model: PartModel, parts: int, layout: Layout, streams: Streams) -> list[Pose]:
    """X_WO of the parts: a function of seed, kind and number of the experiment, whatever the method."""
    return place_parts(model, parts, layout.belt, streams.generator(part=0, purpose="placement"))
