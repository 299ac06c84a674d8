"""Lamps, sky, haze and the camera that overlooks the cell."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.scenery.solids import Point

OVERVIEW = "overview"
EYE, TARGET = (2.65, -2.05, 1.32), (0.36, -0.20, 0.03)  # m in W
# Position (where its shadows begin), direction, strength, and the bulb's radius at a distance of 1.
_LAMPS = (
    ((1.4, 0.6, 2.8), (-0.45, -0.22, -1.0), 0.50, 0.10),  # key, a large window; only its light throws shadows
    ((0.3, -0.6, 3.0), (0.05, 0.08, -1.0), 0.24, 0.0),  # the ceiling's panels
    ((0.6, -2.2, 1.9), (0.0, 0.8, -0.7), 0.20, 0.0),  # fill, from the camera's side
    ((-1.5, 1.0, 1.5), (0.8, -0.5, -0.6), 0.04, 0.0),  # from behind, for edges that shine
)


def add_lighting(spec: mujoco.MjSpec) -> None:
    """Adds them to a cell under construction."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.80, 0.82, 0.84],
        width=64,
        height=384,
    )
    visual = spec.visual
    visual.quality.shadowsize = 2048
    visual.quality.numquads = 24  # of the belt and the floor: lights are computed at vertices
    visual.map.shadowclip = 1.5
    visual.map.haze = 0.5
    visual.rgba.haze = [0.90, 0.91, 0.92, 1.0]
    headlight = visual.headlight
    headlight.ambient, headlight.diffuse, headlight.specular = [0.33] * 3, [0.05] * 3, [0.0] * 3
    world = spec.worldbody
    for pos, direction, strength, bulb in _LAMPS:
        lamp = world.add_light(pos=pos, dir=direction, castshadow=bulb > 0)
        lamp.ambient = [0.0] * 3
        lamp.type, lamp.bulbradius = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL, bulb
        lamp.diffuse, lamp.specular = [strength] * 3, [0.25 + 0.4 * strength] * 3
    world.add_camera(name=OVERVIEW, pos=EYE, quat=_looking(EYE, TARGET), fovy=37)


def _looking(eye: Point, target: Point) -> NDArray[np.float64]:
    """The quaternion, wxyz, of MuJoCo's camera: along −z, with y up."""
    z = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
    x = np.cross((0.0, 0.0, 1.0), z)
    x /= np.linalg.norm(x)
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, np.column_stack((x, np.cross(z, x), z)).ravel())
    return quaternion
