"""The camera at the robot's wrist: instance ids from geometry alone, pictures by OpenGL."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from maskval.rendering.z_buffer import ZBuffer
from sim.instance_ids import PIXEL_CENTER
from sim.model.renderer import Renderer
from sim.runtime.hiders import hiders_of
from sim.runtime.pictures import Pictures
from sim.runtime.world import World

NAME = "wrist"


class WristCamera:
    """Takes what the wrist camera of a world sees. OpenGL is opened for the first picture: `close` it."""

    def __init__(self, world: World) -> None:
        self._world, self._hiders = world, hiders_of(world.mj_model, world.parts)
        self._renderer: Renderer | None = None
        self._pictures: Pictures | None = None
        camera, visual = world.camera_true, world.mj_model.vis.map
        self._near = float(visual.znear * world.mj_model.stat.extent)
        # Normals, pointing inwards, of the planes through the camera's centre and the image's sides.
        sides = np.array(
            [
                (camera.fx, camera.skew, camera.cx),
                (-camera.fx, -camera.skew, camera.width - camera.cx),
                (0.0, camera.fy, camera.cy),
                (0.0, -camera.fy, camera.height - camera.cy),
            ]
        )
        self._sides = sides / np.linalg.norm(sides, axis=1)[:, None]

    def instance_ids(self, X_CO_true: Sequence[Pose]) -> NDArray[np.int8]:
        """Which part each pixel shows, (H, W); `NO_INSTANCE` where it shows none.

        Args:
            X_CO_true: the parts' true poses in the true camera.
        """
        image = ZBuffer(self._world.camera_true, pixel_center=PIXEL_CENTER, near=self._near)
        for part, X_CO in enumerate(X_CO_true):
            image.draw(self._world.part_model.part.mesh, X_CO, part)
        hiders, data, X_CW = self._hiders, self._world.data, self._world.X_WC().inverse()
        rotations = X_CW.rotation @ data.geom_xmat[hiders.geoms].reshape(-1, 3, 3)
        translations = data.geom_xpos[hiders.geoms] @ X_CW.rotation.T + X_CW.translation
        for array in (rotations, translations):
            array.setflags(write=False)
        centres = (rotations @ hiders.centres[..., None])[..., 0] + translations
        seen = (centres @ self._sides.T > -hiders.radii[:, None]).all(axis=1)
        seen &= centres[:, 2] > self._near - hiders.radii
        for i in np.flatnonzero(seen):
            edges, is_solid = hiders.surfaces[i]
            image.hide(edges, rotations[i], translations[i], is_solid=is_solid)
        return image.numbers

    def rgb(self) -> NDArray[np.uint8]:
        """The picture, (H, W, 3) uint8.

        Raises:
            GraphicsError: there is no off-screen OpenGL.
        """
        if self._pictures is None:
            camera = self._world.layout.camera
            self._pictures = Pictures(self._world, camera.height, camera.width)
        return self._pictures.rgb(NAME)

    def depth(self) -> NDArray[np.float32]:
        """z-depth, (H, W) m; 0 where the camera sees nothing.

        Raises:
            GraphicsError: there is no off-screen OpenGL.
        """
        if self._renderer is None:
            camera = self._world.layout.camera
            self._renderer = Renderer(self._world.mj_model, camera.height, camera.width)
        return self._renderer.depth(self._world.data, NAME)

    def close(self) -> None:
        """Gives the OpenGL contexts back, if there are any."""
        for held in (self._renderer, self._pictures):
            if held is not None:
                held.close()
        self._renderer = self._pictures = None
