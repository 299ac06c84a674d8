"""The learned networks as the cell's estimators: masks and poses from RGB alone."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame, Image, PoseEstimate
from cell.part import Part
from maskval import Camera
from sim.learned.coordinates import CROP_SIZE, Maps, ObjectCoordinates, estimate_of
from sim.learned.crops import CropView, Square, cut
from sim.learned.grouping import Instance, instances
from sim.learned.weights import DETECTOR, STYLES, Network, TrainedNetworks

DETECTOR_SIZE = (240, 320)  # height and width of what the detector is given
LEAST_SCORE = 0.3
_RGB = frozenset({Image.RGB})


def learned_estimators(
    networks: TrainedNetworks, part: Part
) -> tuple["LearnedMasks", tuple["LearnedPoses", "LearnedPoses"]]:
    """The detector and the pose networks of both styles.

    Raises:
        NetworkError: they are of another part, cannot be read, or onnxruntime is missing.
    """
    first, second = (LearnedPoses(networks, style, part) for style in STYLES)
    return LearnedMasks(networks), (first, second)


class LearnedMasks:
    """Implements `cell.interfaces.MaskEstimator` by a network that has learned to see one kind of part.

    Args:
        networks: of the part.
        inference_time: what one frame costs, s of the cell's clock; measured by default.
    """

    def __init__(self, networks: TrainedNetworks, inference_time: float | None = None) -> None:
        self._network = networks.network(DETECTOR)
        self.inference_time = networks.manifest.detector_s if inference_time is None else inference_time
        self.images = _RGB

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        assert frame.rgb is not None  # `images` asks for it
        return [Detection(found.mask, found.score) for found in find(self._network, frame.rgb)]


class LearnedPoses:
    """Implements `cell.interfaces.PoseEstimator`: object coordinates of a crop, then PnP with a head's depth.

    Args:
        networks: of the part.
        style: which of its pose networks.
        part: the part.
        inference_time: what one frame costs, s of the cell's clock; measured by default.
    """

    def __init__(self, networks: TrainedNetworks, style: str, part: Part, inference_time: float | None = None) -> None:
        manifest = networks.manifest
        manifest.check_mesh(part.mesh, networks.folder)
        self._network, self._coordinates = networks.network(style), ObjectCoordinates.of(part.mesh, part.symmetries)
        self._weight = manifest.correspondence_weight[style]
        self.inference_time = manifest.pose_s if inference_time is None else inference_time
        self.images = _RGB

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[PoseEstimate]:
        """See `PoseEstimator`; every pose comes with its correspondences."""
        if not detections:
            return []
        assert frame.rgb is not None  # `images` asks for it
        masks = [detection.mask for detection in detections]
        looks = look(self._network, frame.rgb, frame.camera, masks)
        return [estimate_of(maps, view, self._coordinates, self._weight) for view, maps in looks]


def find(detector: Network, rgb: NDArray[np.uint8]) -> list[Instance]:
    """The instances that a detector finds in a picture, (H, W, 3)."""
    height, width = rgb.shape[:2]
    small = np.asarray(cv2.resize(rgb, DETECTOR_SIZE[::-1], interpolation=cv2.INTER_AREA), dtype=np.uint8)
    (maps,) = detector(_as_input(small[None]))
    found = instances(maps[0, 0], maps[0, 1], maps[0, 2:4], (height, width))
    return [one for one in found if one.score >= LEAST_SCORE]


def look(
    network: Network, rgb: NDArray[np.uint8], camera: Camera, masks: Sequence[NDArray[np.bool_]]
) -> list[tuple[CropView, Maps]]:
    """The crop around each of the masks, at least one, and what a pose network says of it.

    Args:
        network: the pose network.
        rgb: the picture, (H, W, 3).
        camera: its intrinsics.
        masks: (H, W) each.
    """
    views = [CropView(Square.around(mask), camera, CROP_SIZE) for mask in masks]
    crops = np.stack([cut(rgb, view.square, CROP_SIZE) for view in views])
    outputs = network(_as_input(crops))
    return [(view, Maps(*(output[i] for output in outputs))) for i, view in enumerate(views)]


def _as_input(images: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Images as networks take them, (N, 3, H, W) in [0, 1], from (N, H, W, 3)."""
    return np.ascontiguousarray(images.transpose(0, 3, 1, 2), dtype=np.float32) / np.float32(255.0)
