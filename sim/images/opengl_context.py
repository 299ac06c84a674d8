"""An OpenGL context that serves one model after the other: to make one takes a quarter of a second."""

import mujoco
import numpy as np
from mujoco.rendering.classic import gl_context
from numpy.typing import NDArray

from sim.model.renderer import opened_opengl

_MAX_GEOMS = 200


class OpenGLContext:
    """Draws models of one picture size. Make few and `close` them.

    It has room for the textures, materials, meshes and planes of the model that it is made for.

    Args:
        model: whose `offwidth` and `offheight` are the picture's.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model, size = model, model.vis.global_
        self._rect = mujoco.MjrRect(0, 0, size.offwidth, size.offheight)
        with opened_opengl():
            self._gl = gl_context.GLContext(size.offwidth, size.offheight)
            self._gl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._option, self._view = mujoco.MjvOption(), mujoco.MjvCamera()
        self._view.type, self._view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0

    def fits(self, model: mujoco.MjModel) -> bool:
        """Whether there is room for what this model draws; both have one material for each texture, in order."""
        room = self._model
        return model.nmesh <= room.nmesh and model.ntex <= room.ntex and np.array_equal(_planes(model), _planes(room))

    def draw(self, model: mujoco.MjModel) -> NDArray[np.uint8]:
        """What the model's first camera sees, (H, W, 3).

        Args:
            model: one that fits.
        """
        self._gl.make_current()
        for index in range(model.ntex):
            mujoco.mjr_uploadTexture(model, self._context, index)
        for index in range(model.nmesh):
            mujoco.mjr_uploadMesh(model, self._context, index)
        data, scene = mujoco.MjData(model), mujoco.MjvScene(model, _MAX_GEOMS)
        mujoco.mj_forward(model, data)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._option, None, self._view, everything, scene)
        mujoco.mjr_render(self._rect, scene, self._context)
        rgb = np.empty((self._rect.height, self._rect.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(rgb, None, self._rect, self._context)
        return rgb[::-1]

    def close(self) -> None:
        """Gives the context back."""
        self._context.free()
        self._gl.free()


def _planes(model: mujoco.MjModel) -> NDArray[np.float64]:
    """Sizes of the planes, (N, 3) m: the context has their corners, which cannot be loaded anew."""
    sizes: NDArray[np.float64] = model.geom_size[model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE]
    return sizes
