"""Test images without pictures: what each pixel would show of several parts among clutter, from geometry alone.

Parts and clutter float at random poses in front of the camera, their middles inside the image: the nearer one hides the
farther one, and the image's border cuts off what lies beyond. Bodies may overlap; only what is seen
counts. An image is a function of the streams' seed, experiment (its number) and kind of part.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose
from maskval.rendering.z_buffer import ZBuffer
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.networks.ground_truth import FrameTruth
from sim.networks.random_streams import Streams
from sim.parts.stable_poses import RestingPose

Array = NDArray[np.float64]
Body = tuple[Mesh, Pose, int]  # its shape, X_CO and number


@dataclass(frozen=True, slots=True)
class Recipe:
    """What an image is made of; numbers and distances are drawn uniformly between both ends.

    Attributes:
        parts: how many parts, at most 127.
        clutter: how many other bodies.
        distance: z of a body's middle, m.
        resting: how the parts may lie, each as likely as it says; none for any rotation.
        elevation_deg: of the camera's axis over the floor that they would lie on.
    """

    parts: tuple[int, int] = (2, 6)
    clutter: tuple[int, int] = (0, 4)
    distance: tuple[float, float] = (0.4, 1.2)
    resting: tuple[RestingPose, ...] = ()
    elevation_deg: tuple[float, float] = (25.0, 90.0)


@dataclass(frozen=True, slots=True, eq=False)
class GeneratedImage:
    """An image: the truth about it, and its bodies (parts, then clutter) as `draw_nearest` takes them."""

    truth: FrameTruth
    bodies: tuple[Body, ...]


def make_image(mesh: Mesh, camera: Camera, recipe: Recipe, streams: Streams) -> GeneratedImage:
    """One image of parts of this shape.

    Args:
        mesh: The part.
        camera: Intrinsics and image size.
        recipe: What the image is made of.
        streams: The root of the image's random numbers; the experiment is the image's number.
    """
    bodies = scatter(mesh, camera, recipe, streams)
    return GeneratedImage(truth_of(bodies, _drawn(bodies, camera).numbers, mesh, camera, streams.experiment), bodies)


def scatter(mesh: Mesh, camera: Camera, recipe: Recipe, streams: Streams) -> tuple[Body, ...]:
    """An image's parts, numbered from 0, and then its clutter; the arguments are those of `make_image`."""
    rng = streams.generator(0, "dataset scene")
    parts = rng.integers(*recipe.parts, endpoint=True)
    clutter = rng.integers(*recipe.clutter, endpoint=True)
    poses = tuple(_turned_anywhere(mesh, camera, recipe, rng) for _ in range(parts))
    others = [clutter_shapes()[i] for i in rng.integers(len(clutter_shapes()), size=clutter)]
    return (
        *((mesh, X_CO, part) for part, X_CO in enumerate(poses)),
        *((other, _anywhere(other, camera, recipe, rng), NO_INSTANCE) for other in others),
    )


def truth_of(
    bodies: Sequence[Body], instance_ids: NDArray[np.int8], mesh: Mesh, camera: Camera, number: int
) -> FrameTruth:
    """The truth about an image of these bodies.

    Args:
        bodies: The parts in the order of their instance ids, and clutter.
        instance_ids: (H, W), the part that each pixel shows, `NO_INSTANCE` where it shows none.
        mesh: The parts' shape.
        camera: Intrinsics and image size.
        number: The image's.
    """
    poses = tuple(X_CO for _, X_CO, instance in bodies if instance != NO_INSTANCE)
    return FrameTruth(number, instance_ids, poses, camera, mesh)


def draw_nearest(bodies: Sequence[Body], camera: Camera) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Number and z-depth (m) of the nearest body at each pixel, (H, W); `NO_INSTANCE` and 0 where there is none.

    Args:
        bodies: Of equally near ones the first is seen.
        camera: Intrinsics and image size.
    """
    image = _drawn(bodies, camera)
    return image.numbers, image.depth()


def _drawn(bodies: Sequence[Body], camera: Camera) -> ZBuffer:
    image = ZBuffer(camera, pixel_center=PIXEL_CENTER)
    for mesh, X_CO, number in bodies:
        image.draw(mesh, X_CO, number)
    return image


@cache
def clutter_shapes() -> tuple[Mesh, ...]:
    """Clutter: boxes, rods, discs and balls of the parts' size and smaller."""
    boxes = [trimesh.creation.box(size) for size in ((0.14, 0.09, 0.05), (0.20, 0.03, 0.03), (0.06, 0.06, 0.06))]
    round_ones = [trimesh.creation.cylinder(r, height, sections=24) for r, height in ((0.015, 0.20), (0.05, 0.03))]
    balls = [trimesh.creation.icosphere(subdivisions=2, radius=radius) for radius in (0.025, 0.045)]
    return tuple(Mesh(shape.vertices, shape.faces) for shape in (*boxes, *round_ones, *balls))


def looking_down(azimuth: float, elevation: float, roll: float) -> Array:
    """R_WC of a camera that looks down: along W's x axis with its head up, then tilted, turned about z and rolled.

    Args:
        azimuth: of the turn about z, rad.
        elevation: of the axis over the floor, rad.
        roll: about the axis, rad.
    """
    ahead = np.array(((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, -1.0, 0.0)))
    turns = ((0.0, 0.0, azimuth), (0.0, elevation, 0.0))
    turned, tilted = (Pose.from_rotvec(turn).rotation for turn in turns)
    R_WC: Array = turned @ tilted @ ahead @ Pose.from_rotvec((0.0, 0.0, roll)).rotation
    return R_WC


def elevation(span_deg: tuple[float, float], rng: np.random.Generator) -> float:
    """The elevation, rad, of an axis that is uniform on the sphere between two of them."""
    return math.asin(rng.uniform(*np.sin(np.radians(span_deg))))


def _turned_anywhere(mesh: Mesh, camera: Camera, recipe: Recipe, rng: np.random.Generator) -> Pose:
    """A pose whose middle lies in the image: of uniform rotation, or as the part lies on a floor."""
    X_CO = _anywhere(mesh, camera, recipe, rng)
    if not recipe.resting:
        return X_CO
    lies = recipe.resting[rng.choice(len(recipe.resting), p=[pose.probability for pose in recipe.resting])]
    azimuth, roll = rng.uniform(-math.pi, math.pi, 2)
    R_CO = looking_down(azimuth, elevation(recipe.elevation_deg, rng), roll).T @ lies.rotation
    return Pose(R_CO, X_CO.apply(mesh.center) - R_CO @ mesh.center)


def _anywhere(mesh: Mesh, camera: Camera, recipe: Recipe, rng: np.random.Generator) -> Pose:
    """A pose of uniform rotation whose middle lies in the image."""
    z = rng.uniform(*recipe.distance)
    v, u = rng.uniform((0.0, 0.0), (camera.height, camera.width))
    y = (v - camera.cy) / camera.fy * z
    x = ((u - camera.cx) * z - camera.skew * y) / camera.fx
    quaternion = rng.normal(size=4)
    turn = Pose.from_quaternion_wxyz(quaternion / math.sqrt(float(quaternion @ quaternion)), (x, y, z))
    return turn @ Pose.from_translation(-mesh.center)
