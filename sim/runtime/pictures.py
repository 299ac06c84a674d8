"""Pictures of a world as it stands; taking them changes nothing in it."""

from weakref import WeakKeyDictionary

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.model.renderer import Renderer
from sim.runtime.world import World
from sim.scenery.lighting import EYE, OVERVIEW
from sim.scenery.model import build_scenery

SAMPLES = 4  # per pixel, of a picture that many are taken of
SHADOWS = 2048  # px
FINE_SAMPLES = 48  # of a picture to look at for long
_NEAR = 0.42  # m: of the close-up's camera from the TCP
_DOWN_DEG = 22.0  # how far it looks down


_SCENERIES: WeakKeyDictionary[World, mujoco.MjModel] = WeakKeyDictionary()


def scenery_of(world: World) -> mujoco.MjModel:
    """The model to take pictures of a world of: its joints are the world's. One for all of them: it takes 45 MB.

    Raises:
        MeshesMissingError: the maker's meshes are asked for and not installed.
    """
    if world not in _SCENERIES:
        model, parts = world.part_model, world.parts
        _SCENERIES[world] = build_scenery(
            world.layout, [model] * parts, model.part.slot_size, world.conditions, use_meshes=world.use_meshes
        )
    return _SCENERIES[world]


class Pictures:
    """Takes pictures of a world; holds an OpenGL context, so make few and `close` them.

    Args:
        world: what they show.
        height: of a picture, px.
        width: of a picture, px.
        samples: pictures that each is the mean of; more make shadows softer and edges smoother.
        shadows: side of the map that shadows are looked up in, px; 0 for none, which halves the time.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
        MeshesMissingError: the maker's meshes are asked for and not installed.
    """

    def __init__(
        self,
        world: World,
        height: int,
        width: int,
        samples: int = SAMPLES,
        *,
        shadows: int = SHADOWS,
    ) -> None:
        self._world, self._samples = world, samples
        self._mj_model = scenery_of(world)
        self._mj_model.vis.quality.shadowsize = shadows  # read when the context is made
        self._data = mujoco.MjData(self._mj_model)
        self._renderer = Renderer(self._mj_model, height, width)
        self._renderer.rgb(self._data, OVERVIEW)  # the first frame's shadows may differ by a grey level

    def rgb(self, camera: str, positions: NDArray[np.floating] | None = None) -> NDArray[np.uint8]:
        """The picture of a camera, (H, W, 3) uint8: "overview" or "wrist".

        Args:
            camera: its name.
            positions: of the joints, as a `Film` has them; as they are now by default.
        """
        self._place(positions)
        return self._renderer.rgb(self._data, camera, self._samples)

    def close_up(self, positions: NDArray[np.floating] | None = None) -> NDArray[np.uint8]:
        """The gripper from beside its jaws, both of them in view, (H, W, 3) uint8; see `rgb`."""
        self._place(positions)
        flange, left, right = (self._data.body(name) for name in ("flange", "finger_left", "finger_right"))
        approach = flange.xmat.reshape(3, 3)[:, 2]
        tcp = flange.xpos + self._world.layout.gripper.tcp_from_flange * approach
        return self._renderer.rgb(self._data, _beside(tcp, approach, right.xpos - left.xpos), self._samples)

    def _place(self, positions: NDArray[np.floating] | None) -> None:
        self._data.qpos[:] = self._world.data.qpos if positions is None else positions
        mujoco.mj_kinematics(self._mj_model, self._data)
        mujoco.mj_camlight(self._mj_model, self._data)

    def close(self) -> None:
        """Gives the OpenGL context back."""
        self._renderer.close()


def _beside(tcp: NDArray[np.float64], approach: NDArray[np.float64], jaws: NDArray[np.float64]) -> mujoco.MjvCamera:
    """A camera that looks at the TCP across the line between the jaws, from the overview's side."""
    across = np.cross(approach, jaws)
    if across @ (EYE - tcp) < 0:
        across = -across
    camera = mujoco.MjvCamera()
    camera.lookat, camera.distance = tcp, _NEAR
    camera.azimuth, camera.elevation = np.degrees(np.arctan2(-across[1], -across[0])), -_DOWN_DEG
    return camera
