"""pyrender on OSMesa, whose framebuffer has one sample a pixel; used as its own examples do, faces culled."""

from typing import Any

import numpy as np
import pyrender
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose


class Contender:
    """`OffscreenRenderer` with the flag DEPTH_ONLY."""

    PIXEL_CENTER = 0.5

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        primitive = pyrender.Primitive(positions=mesh.vertices, indices=mesh.faces)
        self._scene = pyrender.Scene()
        self._object = self._scene.add(pyrender.Mesh([primitive]))
        intrinsics = pyrender.IntrinsicsCamera(camera.fx, camera.fy, camera.cx, camera.cy, znear=0.01, zfar=10.0)
        self._scene.add(intrinsics, pose=np.diag((1.0, -1.0, -1.0, 1.0)))
        self._renderer = pyrender.OffscreenRenderer(camera.width, camera.height)

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        return self.depth(X_CO) > 0

    def depth(self, X_CO: Pose) -> NDArray[Any]:
        self._scene.set_pose(self._object, X_CO.matrix)
        return self._renderer.render(self._scene, pyrender.RenderFlags.DEPTH_ONLY)
