"""Networks that say the truth: what crops, grouping and PnP make of it is their own error."""

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose, silhouette
from maskval.rendering.depth import depth_image
from sim.learned.coordinates import CROP_SIZE, MAP_SIZE, Maps, ObjectCoordinates
from sim.learned.crops import CropView

CAMERA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
SKEWED = Camera(610.0, 595.0, 310.0, 245.0, 640, 480, skew=3.0)
SURE, UNSURE = 8.0, -8.0  # logits


def mask_of(mesh: Mesh, X_CO: Pose, camera: Camera) -> NDArray[np.bool_]:
    return silhouette(mesh, X_CO, camera, pixel_center=0.5).mask


def maps_of(mesh: Mesh, X_CO: Pose, view: CropView, *, log_scale: float = -4.0) -> Maps:
    """What a perfect network says of a crop."""
    small, coordinates = CropView(view.square, view.image_camera, MAP_SIZE), ObjectCoordinates.of(mesh)
    X_VO = small.X_VC @ X_CO
    depth = depth_image(mesh, X_VO, small.camera, pixel_center=0.5)
    normalised = coordinates.normalised(X_VO.inverse().apply(small.points(depth)))
    center_V = (view.X_VC @ X_CO).apply(coordinates.center_O)
    u, v = view.camera.project(center_V) / (CROP_SIZE / 2) - 1.0
    log_depth = np.log(center_V[2] / coordinates.depth_unit(view.camera))
    return Maps(
        coordinates=normalised.transpose(2, 0, 1).astype(np.float32),
        log_scale=np.full(depth.shape, log_scale, dtype=np.float32),
        visible=np.where(depth > 0, SURE, UNSURE).astype(np.float32),
        head=np.array((u, v, log_depth, -3.0), dtype=np.float32),
    )
