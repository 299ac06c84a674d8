"""Renders pictures of still bodies with their own surfaces and lights. The world frame is the camera's frame C."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose
from sim.images.textures import Picture
from sim.instance_ids import NO_INSTANCE
from sim.model import renderer as rendering

# Odd, so that the middle of every pixel is the middle of a sample: RGB averages all of them, depth and instance ids
# take the middle one.
SAMPLES = 3
_NEAR, _FAR = 0.01, 20.0  # m
_SHADOW_SIZE = 4096  # texels of the shadows' map

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """How a body looks.

    Attributes:
        picture: (H, W, 3), wrapped around bodies and laid on walls; (6 H, H, 3) for a body: a square for each side.
        specular: share of the light in highlights, in [0, 1].
        shininess: how small the highlights are, in [0, 1].
    """

    picture: Picture
    specular: float
    shininess: float


@dataclass(frozen=True, slots=True, eq=False)
class SurfacedBody:
    """A visible body: its shape, X_CO, number (the part's, or `NO_INSTANCE`) and surface."""

    mesh: Mesh
    X_CO: Pose
    number: int
    surface: Surface


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """A rectangle seen from the side to which its z axis points.

    Attributes:
        X_CP: pose of its middle.
        half_size: along x and y, m.
        surface: its look; the picture is repeated every metre.
    """

    X_CP: Pose
    half_size: tuple[float, float]
    surface: Surface


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A lamp as far away as the sun, or a spot where `position_C` is given.

    Attributes:
        direction_C: where its light goes, (3,).
        color: (3,), 1 lights a white surface fully.
        position_C: where the spot is, (3,) m, or None.
        shadow: whether bodies throw shadows.
    """

    direction_C: Array
    color: Array
    position_C: Array | None
    shadow: bool


@dataclass(frozen=True, slots=True, eq=False)
class Photograph:
    """What the camera sees.

    Attributes:
        rgb: (H, W, 3) in [0, 255], the mean over each pixel; black where nothing is.
        coverage: share of each pixel that shows something, (H, W) in [0, 1].
        depth: z-depth at the middle of each pixel, (H, W) m; 0 where nothing is.
        instance_ids: the part there, (H, W); `NO_INSTANCE` where there is none.
    """

    rgb: NDArray[np.float32]
    coverage: NDArray[np.float32]
    depth: NDArray[np.float32]
    instance_ids: NDArray[np.int8]


def photograph(
    bodies: Sequence[SurfacedBody], walls: Sequence[Wall], lights: Sequence[Light], ambient: float, camera: Camera
) -> Photograph:
    """A picture of bodies and walls under these lights.

    Args:
        bodies: the bodies.
        walls: the walls around them.
        lights: the lamps.
        ambient: the ambient light, in [0, 1].
        camera: intrinsics and image size.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """
    model = _build(bodies, walls, lights, ambient, camera)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    middle = slice(SAMPLES // 2, None, SAMPLES)
    with closing(rendering.Renderer(model, SAMPLES * camera.height, SAMPLES * camera.width)) as renderer:
        depth = renderer.depth(data, "camera")
        numbers = renderer.instance_ids(data, "camera")[middle, middle]
        rgb = renderer.rgb(data, "camera")
    rgb[depth == 0.0] = 0
    return Photograph(
        rgb=_mean(rgb, camera),
        coverage=_mean(depth > 0.0, camera),
        depth=depth[middle, middle].copy(),
        instance_ids=numbers.copy(),
    )


def _mean(samples: NDArray[Any], camera: Camera) -> NDArray[np.float32]:
    """The mean of each pixel's samples, (H, W, ...)."""
    size = (camera.width, camera.height)
    return cv2.resize(samples.astype(np.float32), size, interpolation=cv2.INTER_AREA).astype(np.float32, copy=False)


def _build(
    bodies: Sequence[SurfacedBody], walls: Sequence[Wall], lights: Sequence[Light], ambient: float, camera: Camera
) -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.visual.quality.offsamples = 0  # without multisampling depths and instance ids are exact
    spec.visual.quality.shadowsize = _SHADOW_SIZE
    getattr(spec.visual, "global").offwidth = SAMPLES * camera.width
    getattr(spec.visual, "global").offheight = SAMPLES * camera.height
    spec.stat.extent, spec.stat.center = 1.0, (0.0, 0.0, 0.8)
    spec.visual.map.znear, spec.visual.map.zfar = _NEAR, _FAR
    spec.visual.map.shadowclip = 3.0
    headlight = spec.visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [ambient] * 3, [0.0] * 3, [0.0] * 3
    spec.worldbody.add_camera(name="camera", **rendering.pinhole(camera, Pose.identity()))
    for light in lights:
        _add_light(spec, light)
    shapes = {id(body.mesh): body.mesh for body in bodies}
    shape_of = {key: f"shape_{index}" for index, key in enumerate(shapes)}
    for key, mesh in shapes.items():
        shape = spec.add_mesh(name=shape_of[key], inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        shape.uservert, shape.userface = mesh.vertices.ravel(), mesh.faces.ravel()
    for index, body in enumerate(bodies):
        name = f"part_{body.number}" if body.number != NO_INSTANCE else f"clutter_{index}"
        _add_material(spec, name, body.surface, mujoco.mjtTexture.mjTEXTURE_CUBE)
        spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=shape_of[id(body.mesh)],
            material=name,
            pos=body.X_CO.translation,
            quat=body.X_CO.quaternion_wxyz,
        )
    for index, wall in enumerate(walls):
        name = f"wall_{index}"
        _add_material(spec, name, wall.surface, mujoco.mjtTexture.mjTEXTURE_2D)
        spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(*wall.half_size, 0.1),
            material=name,
            pos=wall.X_CP.translation,
            quat=wall.X_CP.quaternion_wxyz,
        )
    return spec.compile()


def _add_light(spec: mujoco.MjSpec, light: Light) -> None:
    lamp = spec.worldbody.add_light(dir=light.direction_C, castshadow=light.shadow)
    lamp.diffuse, lamp.specular, lamp.ambient = light.color, light.color, [0.0] * 3
    if light.position_C is None:
        lamp.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
        lamp.pos = -2.0 * light.direction_C + (0.0, 0.0, 0.8)
    else:
        lamp.type = mujoco.mjtLightType.mjLIGHT_SPOT
        lamp.pos, lamp.cutoff, lamp.exponent = light.position_C, 60.0, 2.0


def _add_material(spec: mujoco.MjSpec, name: str, surface: Surface, kind: mujoco.mjtTexture) -> None:
    height, width, _ = surface.picture.shape
    image = spec.add_texture(name=name, type=kind, width=width, height=height, nchannel=3)
    image.data = surface.picture.tobytes()
    material = spec.add_material(
        name=name, texuniform=True, reflectance=0.0, specular=surface.specular, shininess=surface.shininess
    )
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
