"""Takes pictures: RGB by OpenGL, depth and instance ids by geometry."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Camera
from maskval.rendering.z_buffer import ZBuffer
from sim.images.opengl_context import OpenGLContext
from sim.images.photo_scene import NEAR, Light, SurfacedBody, Wall, build
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER

# Of a side of the map of shadows, for 1 sample per pixel and for more. At 4,096 it takes most of a picture's time.
_SHADOW_TEXELS, _FINE_SHADOW_TEXELS = 2048, 4096


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


class PhotoRenderer:
    """Takes pictures of one size; OpenGL is opened for the first one: `close` it.

    Nothing of a picture remains in the next one: its textures and meshes are loaded anew.

    Args:
        camera: intrinsics and image size.
        samples: per pixel and side, odd, so that a pixel's middle is the middle of a sample.
    """

    def __init__(self, camera: Camera, samples: int) -> None:
        if samples < 1 or samples % 2 == 0:
            raise ValueError(f"expected samples of 1, 3, 5, ..., got {samples}")
        self.camera, self.samples = camera, samples
        self._context: OpenGLContext | None = None

    def photograph(
        self, bodies: Sequence[SurfacedBody], walls: Sequence[Wall], lights: Sequence[Light], ambient: float
    ) -> Photograph:
        """A picture of bodies and walls under these lights.

        Args:
            bodies: the bodies.
            walls: the walls around them.
            lights: the lamps.
            ambient: the ambient light, in [0, 1].

        Raises:
            GraphicsError: there is no off-screen OpenGL.
        """
        seen = self._nearest(bodies, walls)
        depth, middle = seen.depth(), slice(self.samples // 2, None, self.samples)
        shadow_texels = _SHADOW_TEXELS if self.samples == 1 else _FINE_SHADOW_TEXELS
        rgb = self._drawn(build(bodies, walls, lights, ambient, self._fine, shadow_texels=shadow_texels))
        rgb[depth == 0.0] = 0
        return Photograph(
            rgb=self._mean(rgb),
            coverage=self._mean(depth > 0.0),
            depth=depth[middle, middle].copy(),
            instance_ids=seen.numbers[middle, middle].copy(),
        )

    def close(self) -> None:
        """Gives the OpenGL context back, if there is one."""
        if self._context is not None:
            self._context.close()
        self._context = None

    @property
    def _fine(self) -> Camera:
        """A camera with a pixel for each sample."""
        one, n = self.camera, self.samples
        return Camera(n * one.fx, n * one.fy, n * one.cx, n * one.cy, n * one.width, n * one.height, n * one.skew)

    def _nearest(self, bodies: Sequence[SurfacedBody], walls: Sequence[Wall]) -> ZBuffer:
        image = ZBuffer(self._fine, pixel_center=PIXEL_CENTER, near=NEAR)
        for body in bodies:
            image.draw(body.mesh, body.X_CO, body.number)
        for wall in walls:
            if wall.X_CP.translation @ wall.X_CP.rotation[:, 2] < 0:  # seen from before it
                image.draw(wall.mesh, wall.X_CP, NO_INSTANCE)
        return image

    def _drawn(self, model: mujoco.MjModel) -> NDArray[np.uint8]:
        if self._context is not None and not self._context.fits(model):
            self.close()
        if self._context is None:
            self._context = OpenGLContext(model)
        return self._context.draw(model)

    def _mean(self, samples: NDArray[Any]) -> NDArray[np.float32]:
        """The mean of each pixel's samples, (H, W, ...)."""
        floats = samples.astype(np.float32)
        if self.samples == 1:
            return floats
        size = (self.camera.width, self.camera.height)
        return cv2.resize(floats, size, interpolation=cv2.INTER_AREA).astype(np.float32, copy=False)
