"""Open3D's RaycastingScene (Embree), with rays through the pixels of the object's box only."""

import numpy as np
import open3d as o3d
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose


class Contender:
    """Rays in the object's frame, so that the scene is built once."""

    PIXEL_CENTER = 0.5

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        self._scene = o3d.t.geometry.RaycastingScene()
        self._scene.add_triangles(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
        self._vertices = mesh.vertices
        self._camera = camera
        v, u = np.indices((camera.height, camera.width), dtype=np.float32) + self.PIXEL_CENTER
        rays = np.stack(((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)), axis=-1)
        self._rays_C = rays.astype(np.float32)

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        return self.depth(X_CO) > 0

    def depth(self, X_CO: Pose) -> NDArray[np.float32]:
        image = np.zeros((self._camera.height, self._camera.width), dtype=np.float32)
        points = self._camera.project(X_CO.apply(self._vertices))
        size = (self._camera.width, self._camera.height)
        left, top = np.clip(np.floor(points.min(axis=0)).astype(int), 0, size)
        right, bottom = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, size)
        if left >= right or top >= bottom:
            return image
        X_OC = X_CO.inverse()
        rays = np.empty((bottom - top, right - left, 6), dtype=np.float32)
        rays[..., :3] = X_OC.translation
        # A direction of z = 1 in the camera's frame: the distance along it is the depth.
        rays[..., 3:] = self._rays_C[top:bottom, left:right] @ X_OC.rotation.T.astype(np.float32)
        hits = self._scene.cast_rays(o3d.core.Tensor.from_numpy(rays))["t_hit"].numpy()
        hits[~np.isfinite(hits)] = 0
        image[top:bottom, left:right] = hits
        return image
