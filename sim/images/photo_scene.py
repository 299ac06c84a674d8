"""What a picture shows: bodies, walls and lamps, as a model of MuJoCo's whose world frame is the camera's, C."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose
from sim.images.textures import Picture
from sim.model.renderer import pinhole

NEAR, _FAR = 0.01, 20.0  # m
_SHADOWED = 1.0  # m around the middle of a lamp far away, in which bodies throw shadows

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

    @property
    def mesh(self) -> Mesh:
        """Its shape in P: two triangles."""
        return _rectangle(*self.half_size)


@lru_cache(maxsize=16)
def _rectangle(x: float, y: float) -> Mesh:
    corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
    return Mesh(corners, np.array([(0, 1, 2), (0, 2, 3)]))


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A spot, or a lamp as far away as the sun.

    Attributes:
        direction_C: where its light goes, (3,).
        color: (3,), 1 lights a white surface fully.
        position_C: where the spot is, (3,) m; of a lamp far away, where its shadows begin, in the middle of them.
        spot: whether it is a spot.
        shadow: whether bodies throw shadows.
    """

    direction_C: Array
    color: Array
    position_C: Array
    spot: bool
    shadow: bool


def build(
    bodies: Sequence[SurfacedBody],
    walls: Sequence[Wall],
    lights: Sequence[Light],
    ambient: float,
    camera: Camera,
    *,
    shadow_texels: int,
) -> mujoco.MjModel:
    """The model of still bodies, walls and lamps, and of a camera named `camera`.

    Its textures are those of the walls, then those of the bodies; there is a material for each.

    Args:
        bodies: the bodies.
        walls: the walls around them.
        lights: the lamps.
        ambient: the ambient light, in [0, 1].
        camera: intrinsics and size of the picture that is rendered.
        shadow_texels: of a side of the map of shadows.
    """
    spec = mujoco.MjSpec()
    spec.visual.quality.shadowsize = shadow_texels
    _set_visual(spec, ambient, camera)
    spec.worldbody.add_camera(name="camera", **pinhole(camera, Pose.identity()))
    for light in lights:
        _add_light(spec, light)
    papers = {id(wall.surface): wall.surface for wall in walls}
    for key, surface in papers.items():
        _add_material(spec, f"wall_{key}", surface, mujoco.mjtTexture.mjTEXTURE_2D)
    for wall in walls:
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(*wall.half_size, 0.1),
            material=f"wall_{id(wall.surface)}",
            pos=wall.X_CP.translation,
            quat=wall.X_CP.quaternion_wxyz,
        )
    for key, mesh in {id(body.mesh): body.mesh for body in bodies}.items():
        shape = spec.add_mesh(name=f"shape_{key}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        shape.uservert, shape.userface = mesh.vertices.ravel(), mesh.faces.ravel()
    for index, body in enumerate(bodies):
        _add_material(spec, f"body_{index}", body.surface, mujoco.mjtTexture.mjTEXTURE_CUBE)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"shape_{id(body.mesh)}",
            material=f"body_{index}",
            pos=body.X_CO.translation,
            quat=body.X_CO.quaternion_wxyz,
            contype=0,  # nothing touches anything: no convex hulls are made
            conaffinity=0,
        )
    return spec.compile()


def _set_visual(spec: mujoco.MjSpec, ambient: float, camera: Camera) -> None:
    visual = spec.visual
    visual.quality.offsamples = 0  # the samples are the picture's own
    getattr(visual, "global").offwidth, getattr(visual, "global").offheight = camera.width, camera.height
    spec.stat.extent = 1.0
    visual.map.znear, visual.map.zfar, visual.map.shadowclip = NEAR, _FAR, _SHADOWED
    headlight = visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [ambient] * 3, [0.0] * 3, [0.0] * 3


def _add_light(spec: mujoco.MjSpec, light: Light) -> None:
    lamp = spec.worldbody.add_light(pos=light.position_C, dir=light.direction_C, castshadow=light.shadow)
    lamp.diffuse, lamp.specular, lamp.ambient = light.color, light.color, [0.0] * 3
    lamp.type = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    if light.spot:
        lamp.type, lamp.cutoff, lamp.exponent = mujoco.mjtLightType.mjLIGHT_SPOT, 60.0, 2.0


def _add_material(spec: mujoco.MjSpec, name: str, surface: Surface, kind: mujoco.mjtTexture) -> None:
    height, width, _ = surface.picture.shape
    image = spec.add_texture(name=name, type=kind, width=width, height=height, nchannel=3)
    image.data = surface.picture.tobytes()
    material = spec.add_material(
        name=name, texuniform=True, reflectance=0.0, specular=surface.specular, shininess=surface.shininess
    )
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = name
