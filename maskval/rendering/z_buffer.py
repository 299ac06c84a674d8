"""Which of several bodies is the nearest at each pixel of an image."""

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.contour import ContourEdges
from maskval.geometry import Pose
from maskval.masks import Implementation
from maskval.mesh import Mesh
from maskval.rendering.depth import depth_kernel
from maskval.rendering.lens import Box, Floats, Layers, View, lens
from maskval.rendering.views import NEAR_M

NOTHING = -1  # the number of a pixel that shows no body


class ZBuffer:
    """An image into which bodies are drawn: the nearest is seen, of equally near ones the first.

    Solid bodies are seen from outside only, as OpenGL draws them: one around the camera hides nothing.

    Args:
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        near: Least z-depth of what is seen, metres, > 0.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """

    def __init__(
        self,
        camera: Camera,
        *,
        pixel_center: float = 0.0,
        near: float = NEAR_M,
        implementation: Implementation = "numba",
    ) -> None:
        size = (camera.height, camera.width)
        self._layers = Layers(np.zeros(size), np.full(size, NOTHING, dtype=np.int8), 0, 0)
        self._lens, self._near, self._kernel = lens(camera, pixel_center), near, depth_kernel(implementation)
        self._image: Box = (0, 0, camera.width, camera.height)
        self._drawn: Box = (camera.width, camera.height, 0, 0)  # around all bodies with a number

    @property
    def numbers(self) -> NDArray[np.int8]:
        """Number of the body at each pixel, (H, W); `NOTHING` where there is none."""
        return self._layers.numbers

    def draw(self, mesh: Mesh, X_CO: Pose, number: int) -> None:
        """Draws a body.

        Args:
            mesh: Its shape.
            X_CO: Its pose.
            number: Its number, -128 to 127.
        """
        view = View(X_CO.rotation, X_CO.translation, self._lens, self._near, mesh.is_solid)
        box = self._kernel.draw(mesh.edges, view, number, self._image, self._layers)
        left, top, right, bottom = self._drawn
        self._drawn = min(left, box[0]), min(top, box[1]), max(right, box[2]), max(bottom, box[3])

    def hide(self, edges: ContourEdges, rotation: Floats, translation: Floats, *, is_solid: bool) -> None:
        """Draws a body without a number, as far as it may hide what was drawn before.

        Args:
            edges: Its shape.
            rotation: R_CO, (3, 3), not writeable.
            translation: p_CO, (3,), metres, not writeable.
            is_solid: Whether the shape bounds a volume.
        """
        if self._drawn[0] < self._drawn[2] and self._drawn[1] < self._drawn[3]:
            view = View(rotation, translation, self._lens, self._near, is_solid)
            self._kernel.draw(edges, view, NOTHING, self._drawn, self._layers)

    def depth(self) -> NDArray[np.float32]:
        """The z-depth of what is seen, (H, W), metres; 0 where nothing is."""
        return self._kernel.invert(self._layers.inverse)
