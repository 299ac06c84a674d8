"""Parts and clutter dropped onto a floor: physics decides how they lie."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from maskval import Mesh, Pose
from sim.errors import DivergenceError
from sim.images.generated import clutter_shapes
from sim.model.bodies import FURNITURE_FRICTION, PART_SOLREF, add_part, add_part_assets, set_physics
from sim.model.parts import PartModel

TIME_STEP = 0.002  # s
AT_REST = 0.005  # m/s: no point of a body 0.1 m from its middle moves faster
_LONGEST_FALL = 4.0  # s, then another heap is tried
_LOOK = 0.1  # s between checks whether everything is at rest
_TRIES = 20
_CLUTTER_DENSITY = 500.0  # kg/m³, wood's
_ROLLING = (0.6, 0.01, 0.004)  # friction of clutter, m where it has a unit: what is round stops rolling

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Heap:
    """What lies on the floor, z = 0 in W.

    Attributes:
        X_WO: pose of every part.
        clutter: shape and X_WO of everything else.
    """

    X_WO: tuple[Pose, ...]
    clutter: tuple[tuple[Mesh, Pose], ...]


def drop(model: PartModel, parts: int, clutter: int, radius: float, rng: np.random.Generator) -> Heap:
    """A heap at rest.

    Args:
        model: the kind of part.
        parts: how many.
        clutter: how many other bodies, of random convex shapes.
        radius: of the circle that the bodies' middles fall into, m.
        rng: what the heap is drawn from.

    Raises:
        DivergenceError: no heap came to rest.
    """
    for _ in range(_TRIES):
        shapes = [random_shape(rng) for _ in range(clutter)]
        engine = build(model, parts, shapes)
        poses = settle(engine, _above([model.part.mesh] * parts + shapes, radius, rng))
        if poses is not None:
            return Heap(tuple(poses[:parts]), tuple(zip(shapes, poses[parts:], strict=True)))
    raise DivergenceError(
        f"none of {_TRIES} heaps of {parts} × {model.part.name} and {clutter} other bodies came to rest"
    )


def random_shape(rng: np.random.Generator) -> Mesh:
    """A convex body of the parts' size: a box, rod, disc or ball stretched at random, or the hull of random points."""
    stretch = rng.uniform(0.6, 1.5, 3)
    if rng.uniform() < 0.6:
        shape = clutter_shapes()[rng.integers(len(clutter_shapes()))]
        return Mesh(shape.vertices * stretch, shape.faces)
    directions = rng.normal(size=(rng.integers(6, 16), 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hull = trimesh.convex.convex_hull(0.05 * stretch * directions)
    return Mesh(hull.vertices, hull.faces)


def build(model: PartModel, parts: int, shapes: Sequence[Mesh]) -> mujoco.MjModel:
    """The physics of free parts, then free bodies of these convex shapes, over a floor."""
    spec = mujoco.MjSpec()
    set_physics(spec, TIME_STEP)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5.0, 5.0, 0.1], friction=FURNITURE_FRICTION, name="floor"
    )
    add_part_assets(spec, model)
    for index in range(parts):
        add_part(spec, index, model)
    for index, mesh in enumerate(shapes):
        shape = spec.add_mesh(name=f"clutter_{index}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        shape.uservert, shape.userface = mesh.vertices.ravel(), mesh.faces.ravel()
        body = spec.worldbody.add_body(name=f"clutter_{index}", pos=(1.0, 2.0 + index, 1.0))
        body.add_freejoint()
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"clutter_{index}",
            density=_CLUTTER_DENSITY,
            condim=6,
            friction=_ROLLING,
            solref=PART_SOLREF,
        )
    return spec.compile()


def settle(model: mujoco.MjModel, X_WO: Sequence[Pose]) -> list[Pose] | None:
    """X_WO of all bodies at rest, after they fell from these poses; None if they are not at rest after some seconds."""
    data = mujoco.MjData(model)
    for index, X in enumerate(X_WO):
        data.qpos[7 * index : 7 * index + 7] = (*X.translation, *X.quaternion_wxyz)
    for _ in range(round(_LONGEST_FALL / _LOOK)):
        mujoco.mj_step(model, data, round(_LOOK / TIME_STEP))
        if not np.isfinite(data.qvel).all():
            return None
        speeds = data.qvel.reshape(-1, 2, 3)
        fastest = np.linalg.norm(speeds[:, 0], axis=1) + 0.1 * np.linalg.norm(speeds[:, 1], axis=1)
        if fastest.max() < AT_REST:
            return [
                Pose.from_quaternion_wxyz(q[3:] / np.linalg.norm(q[3:]), q[:3]) for q in data.qpos.reshape(-1, 7).copy()
            ]
    return None


def _above(shapes: Sequence[Mesh], radius: float, rng: np.random.Generator) -> list[Pose]:
    """A pose for each body, of uniform rotation: as low as its bounding ball fits above the earlier ones."""
    balls = np.empty((len(shapes), 4))  # x, y, z, radius
    poses: list[tuple[int, Pose]] = []
    for index in rng.permutation(len(shapes)):
        mesh = shapes[index]
        middle = mesh.center
        size = float(np.linalg.norm(mesh.vertices - middle, axis=1).max())
        distance, angle = radius * math.sqrt(rng.uniform()), rng.uniform(0, 2 * math.pi)
        x, y = distance * math.cos(angle), distance * math.sin(angle)
        before = balls[: len(poses)]
        reach = (before[:, 3] + size) ** 2 - (before[:, 0] - x) ** 2 - (before[:, 1] - y) ** 2
        under = reach > 0
        z = max((size, *(before[under, 2] + np.sqrt(reach[under]))))
        balls[len(poses)] = x, y, z, size
        quaternion = rng.normal(size=4)
        turn = Pose.from_quaternion_wxyz(quaternion / np.linalg.norm(quaternion), (x, y, z))
        poses.append((int(index), turn @ Pose.from_translation(-middle)))
    return [pose for _, pose in sorted(poses, key=lambda entry: entry[0])]
