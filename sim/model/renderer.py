"""Pictures by MuJoCo's renderer: RGB, z-depth and instance ids from a camera of the model. All else needs no OpenGL."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import mujoco
import numpy as np
from mujoco.rendering.classic import gl_context
from numpy.typing import NDArray

import maskval
from maskval import Pose
from sim.errors import GraphicsError
from sim.instance_ids import NO_INSTANCE

GL_PACKAGES = "libegl1 libgl1 libosmesa6"
_PLATFORM = "MUJOCO_GL"
# Points at multiples of these fill a disk and a square evenly.
_GOLDEN_ANGLE = np.pi * (3.0 - np.sqrt(5.0))
_PLASTIC = 0.7548776662466927


def pinhole(camera: maskval.Camera, X_BC: Pose) -> dict[str, Any]:
    """The fields of a model's camera with these intrinsics, at X_BC in its body B.

    MuJoCo's camera looks along −z with y up: half a turn about x from OpenCV's.
    """
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, (X_BC.rotation @ np.diag([1.0, -1.0, -1.0])).flatten())
    return {
        "pos": X_BC.translation,
        "quat": quaternion,
        "resolution": [camera.width, camera.height],
        "focal_pixel": [camera.fx, camera.fy],
        "principal_pixel": [camera.width / 2 - camera.cx, camera.height / 2 - camera.cy],
        "sensor_size": [camera.width * 1e-5, camera.height * 1e-5],
    }


class Renderer:
    """An off-screen renderer of one model; holds an OpenGL context, so make few and `close` them."""

    def __init__(self, mj_model: mujoco.MjModel, height: int, width: int) -> None:
        check_not_forked()
        with opened_opengl():
            self._renderer: Any = mujoco.Renderer(mj_model, height, width)
        names = (mujoco.mj_id2name(mj_model, mujoco.mjtObj.mjOBJ_GEOM, geom) or "" for geom in range(mj_model.ngeom))
        numbers = [int(name.removeprefix("part_")) if name.startswith("part_") else NO_INSTANCE for name in names]
        self._part_of_geom = np.array([*numbers, NO_INSTANCE], dtype=np.int8)  # the last for -1, the background
        self._zfar = float(mj_model.vis.map.zfar * mj_model.stat.extent)

    def rgb(self, data: mujoco.MjData, camera: str | mujoco.MjvCamera, samples: int = 1) -> NDArray[np.uint8]:
        """The picture, (H, W, 3) uint8.

        Args:
            data: the state.
            camera: its name, or one that the model does not have.
            samples: how many pictures it is the mean of; each is seen from another point of the pixel, by light from
                another point of the lamps: edges are smooth, and shadows soft.
        """
        check_not_forked()
        self._renderer.disable_depth_rendering()
        self._renderer.disable_segmentation_rendering()
        if samples == 1:
            return self._render(data, camera).copy()
        total = np.zeros((self._renderer.height, self._renderer.width, 3), dtype=np.uint16)
        for number in range(samples):
            self._renderer.update_scene(data, camera)
            _shift(self._renderer.scene, self._renderer.height, number, samples)
            total += self._renderer.render()
        mean: NDArray[np.uint8] = ((total + samples // 2) // samples).astype(np.uint8)
        return mean

    def depth(self, data: mujoco.MjData, camera: str) -> NDArray[np.float32]:
        """z-depth, (H, W) m; 0 where the camera sees nothing."""
        check_not_forked()
        self._renderer.disable_segmentation_rendering()
        self._renderer.enable_depth_rendering()
        depth = self._render(data, camera).copy()
        self._renderer.disable_depth_rendering()
        depth[depth >= 0.99 * self._zfar] = 0.0
        return depth

    def instance_ids(self, data: mujoco.MjData, camera: str) -> NDArray[np.int8]:
        """Which part each pixel shows, (H, W); `NO_INSTANCE` where it shows none."""
        check_not_forked()
        self._renderer.enable_segmentation_rendering()
        seen = self._render(data, camera)
        self._renderer.disable_segmentation_rendering()
        is_geom = seen[..., 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
        return self._part_of_geom[np.where(is_geom, seen[..., 0], -1)]

    def close(self) -> None:
        """Gives the OpenGL context back; that of a process that forked this one stays its own."""
        if os.getpid() in _opened_in:
            self._renderer.close()

    def _render(self, data: mujoco.MjData, camera: str | mujoco.MjvCamera) -> NDArray[Any]:
        self._renderer.update_scene(data, camera)
        image: NDArray[Any] = self._renderer.render()
        return image


_opened_in: set[int] = set()  # the process that has opened OpenGL, and with it those that it forks


def check_not_forked() -> None:
    """Notes that this process uses OpenGL.

    Raises:
        GraphicsError: OpenGL was opened by the process that forked this one, where it would wait without end.
    """
    here = os.getpid()
    if _opened_in and here not in _opened_in:
        raise GraphicsError(
            f"process {here} was forked by one that had opened OpenGL, which does not survive that: expected processes "
            'that are spawned, as by multiprocessing.get_context("spawn"), or gymnasium.make_vec(..., '
            'vectorization_mode="async", vector_kwargs={"context": "spawn"})'
        )
    _opened_in.add(here)


def _shift(scene: mujoco.MjvScene, height: int, number: int, samples: int) -> None:
    """Moves the camera by less than a pixel, and the lamps within their bulbs, for one picture of many.

    The light of a lamp far away comes from a disk; its bulb's radius is that of the disk at a distance of 1.
    """
    share = (number + 0.5) / samples
    for camera in scene.camera:
        pixel = (camera.frustum_top - camera.frustum_bottom) / height
        camera.frustum_center += pixel * (share - 0.5)
        off = pixel * ((share * _PLASTIC * samples) % 1.0 - 0.5)
        camera.frustum_bottom += off
        camera.frustum_top += off
    for index, lamp in enumerate(scene.lights[: scene.nlight]):
        if lamp.headlight:
            continue
        direction = np.array(lamp.dir, dtype=np.float64)
        x = np.cross(direction, (0.0, 1.0, 0.0))
        x /= np.linalg.norm(x)
        angle, radius = _GOLDEN_ANGLE * (number + 1.7 * index), lamp.bulbradius * np.sqrt(share)
        turned = direction + radius * (np.cos(angle) * x + np.sin(angle) * np.cross(direction, x))
        lamp.dir = turned / np.linalg.norm(turned)


@contextmanager
def opened_opengl() -> Iterator[None]:
    """Opens off-screen OpenGL in its block.

    Raises:
        GraphicsError: there is none.
    """
    try:
        _choose_platform()
        yield
    except Exception as error:  # the bindings raise whatever their platform's loader raises
        chosen = os.environ.get(_PLATFORM)
        raise GraphicsError(
            f"no off-screen OpenGL, which pictures need ({type(error).__name__}: {error}"
            f"{f'; {_PLATFORM} is {chosen}' if chosen else ''}); expected EGL or OSMesa: "
            f"apt-get install {GL_PACKAGES}, then set {_PLATFORM} to egl or osmesa"
        ) from error


def _choose_platform() -> None:
    """Has MuJoCo render by EGL unless the environment says by what; its own choice on Linux needs a display.

    It is made for the first picture: MuJoCo loads the library of a platform that the environment names when it is
    imported, and can itself not be imported where that is missing.
    """
    if not os.environ.get(_PLATFORM) and sys.platform == "linux":
        gl_context.GLContext = import_module("mujoco.egl").GLContext
