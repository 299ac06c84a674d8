"""A cell ready for experiments, built once per process, and how the parts lie when an experiment begins."""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cell.layout import Belt, Layout
from maskval import Camera as Intrinsics
from maskval import Mesh, Pose, silhouette, silhouette_iou
from sim.model.clutter import CLEARANCES, distractors_of, place_distractors
from sim.model.conditions import Conditions
from sim.model.parts import load_part
from sim.model.placement import convex_outline, feed_parts, feeding_length, place_parts
from sim.model.renderer import Camera
from sim.networks.random_streams import Streams
from sim.runtime.world import World


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
    layout, model = Layout(belt=belt_under(conditions, parts)), load_part(part)
    world = World(layout, model, parts, conditions, maker_meshes)
    _compile_kernels(model.part.mesh, layout.camera)
    return Bench(world, Camera(world.model, layout.camera.height, layout.camera.width))


def _compile_kernels(mesh: Mesh, camera: Intrinsics) -> None:
    """Has Numba compile what every picture needs, so that no network's time limit falls into it."""
    ahead = Pose(rotation=np.eye(3), translation=np.array([0.0, 0.0, 0.5]))
    silhouette_iou(mesh, [ahead], np.ones((1, camera.height, camera.width), dtype=np.bool_), camera)
    silhouette(mesh, ahead, camera)


bench = lru_cache(maxsize=4)(build_bench)  # kept, since compiling and opening a renderer take a second


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
