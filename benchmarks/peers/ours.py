"""This library, compiled."""

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose, depth_image, silhouette, silhouette_iou
from maskval.masks import Implementation

IMPLEMENTATION: Implementation = "numba"


class Contender:
    """The kernel of `maskval`."""

    PIXEL_CENTER = 0.5
    implementation = IMPLEMENTATION

    def __init__(self, mesh: Mesh, camera: Camera) -> None:
        self._mesh = mesh
        self._camera = camera

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        return silhouette(
            self._mesh, X_CO, self._camera, pixel_center=self.PIXEL_CENTER, implementation=self.implementation
        ).mask

    def depth(self, X_CO: Pose) -> NDArray[np.float32]:
        return depth_image(
            self._mesh, X_CO, self._camera, pixel_center=self.PIXEL_CENTER, implementation=self.implementation
        )

    def iou_and_visibility(
        self, poses: list[Pose], masks: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        return silhouette_iou(
            self._mesh,
            poses,
            masks,
            self._camera,
            pixel_center=self.PIXEL_CENTER,
            canvas="3x3",
            implementation=self.implementation,
        )
