"""MuJoCo's renderer: segmentation for the mask, its depth for the depth."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose


class Contender:
    """One mesh on a mocap body before a fixed camera."""

    PIXEL_CENTER = 0.5

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        spec = mujoco.MjSpec()
        spec.visual.quality.offsamples = 0
        spec.visual.global_.offwidth, spec.visual.global_.offheight = camera.width, camera.height
        spec.visual.map.znear = 0.01
        spec.add_mesh(
            name="part",
            uservert=mesh.vertices.ravel(),
            userface=mesh.faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        body = spec.worldbody.add_body(name="part", mocap=True)
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="part", contype=0, conaffinity=0)
        spec.worldbody.add_camera(
            name="camera",
            quat=[0, 1, 0, 0],
            focal_pixel=[camera.fx, camera.fy],
            principal_pixel=[camera.width / 2 - camera.cx, camera.height / 2 - camera.cy],
            sensor_size=[camera.width / camera.fx, camera.height / camera.fy],
            resolution=[camera.width, camera.height],
        )
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        self._renderer = mujoco.Renderer(self._model, camera.height, camera.width)
        self._far = self._model.vis.map.zfar * self._model.stat.extent

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        self._renderer.enable_segmentation_rendering()
        seen = self._render(X_CO)[..., 0] >= 0
        self._renderer.disable_segmentation_rendering()
        return seen

    def depth(self, X_CO: Pose) -> NDArray[np.float32]:
        self._renderer.enable_depth_rendering()
        depth = self._render(X_CO).copy()
        self._renderer.disable_depth_rendering()
        depth[depth >= 0.99 * self._far] = 0
        return depth

    def _render(self, X_CO: Pose) -> NDArray[np.float32]:
        self._data.mocap_pos[0], self._data.mocap_quat[0] = X_CO.translation, X_CO.quaternion_wxyz
        mujoco.mj_forward(self._model, self._data)
        self._renderer.update_scene(self._data, camera="camera")
        return self._renderer.render()
