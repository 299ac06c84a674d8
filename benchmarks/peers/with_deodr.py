"""DEODR's rasteriser in C++, without anti-aliasing (sigma = 0)."""

import numpy as np
from deodr.differentiable_renderer import Scene2DBase, renderScene
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose


class Contender:
    """`renderScene` on one channel: 1, or the depth."""

    PIXEL_CENTER = 0.0

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        vertices, faces = len(mesh.vertices), len(mesh.faces)
        self._camera = camera
        self._vertices_O = mesh.vertices
        self._image = np.empty((camera.height, camera.width, 1))
        self._z_buffer = np.empty((camera.height, camera.width))
        self._scene = Scene2DBase(
            faces=mesh.faces.astype(np.uint32),
            faces_uv=mesh.faces.astype(np.uint32),
            ij=np.zeros((vertices, 2)),
            depths=np.ones(vertices),
            textured=np.zeros(faces, dtype=bool),
            uv=np.zeros((vertices, 2)),
            shade=np.zeros(vertices),
            colors=np.ones((vertices, 1)),
            shaded=np.zeros(faces, dtype=bool),
            edgeflags=np.zeros((faces, 3), dtype=bool),
            height=camera.height,
            width=camera.width,
            nb_colors=1,
            texture=np.zeros((0, 0)),
            background_color=np.zeros(1),
            clockwise=False,
            backface_culling=True,
        )
        self._ones = np.ones((vertices, 1))

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        points_C = X_CO.apply(self._vertices_O)
        return self._render(points_C, self._ones) > 0

    def depth(self, X_CO: Pose) -> NDArray[np.float64]:
        points_C = X_CO.apply(self._vertices_O)
        return self._render(points_C, points_C[:, 2:].copy()).copy()

    def _render(self, points_C: NDArray[np.float64], colours: NDArray[np.float64]) -> NDArray[np.float64]:
        self._scene.ij = self._camera.project(points_C)
        self._scene.depths = points_C[:, 2].copy()
        self._scene.colors = colours
        renderScene(self._scene, 0.0, self._image, self._z_buffer, check_valid=False)
        return self._image[..., 0]
