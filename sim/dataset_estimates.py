"""What the simulated networks give for a test image: the cell's error models, with new random numbers at every view."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection
from maskval import Camera, Mesh, Pose
from sim.dataset import NOTHING, ImageTruth
from sim.latents import Streams
from sim.mask_noise import FALSE_ALARM_COUNT, MaskLatents, false_alarm, noisy_detection
from sim.noise import PartNoise
from sim.pose_noise import PoseLatents, noisy_pose, pose_of_nothing

NETWORKS = 2  # S1 and S2

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ImageEstimates:
    """N detections of one image and their poses.

    Attributes:
        detections: what the detector found.
        parts: the part that each of them shows, or `NOTHING`.
        poses: poses[e][i] is X_CO_est of detection i by network e.
    """

    detections: tuple[Detection, ...]
    parts: tuple[int, ...]
    poses: tuple[tuple[Pose, ...], ...]


def estimate_image(truth: ImageTruth, mesh: Mesh, camera: Camera, noise: PartNoise, streams: Streams) -> ImageEstimates:
    """Detections and poses of one image; an instance's errors hang on the streams and its number alone.

    Images of a set share no view, so that the latents of `sim.latents` are plain normal numbers here.

    Args:
        truth: The image.
        mesh: The part.
        camera: Intrinsics and image size.
        noise: The part's error model.
        streams: The root of the image's random numbers; the experiment is the image's number.
    """
    latents = [_Latents(streams, part) for part in range(len(truth.X_CO_true))]
    found = [_detect(truth, part, one, noise) for part, one in enumerate(latents)]
    by_chance = streams.generator(0, "dataset false alarm").standard_normal(FALSE_ALARM_COUNT + 4 * NETWORKS)
    found.append(false_alarm(truth.part_numbers.shape, by_chance[:FALSE_ALARM_COUNT], noise.mask))
    detections = tuple(detection for detection in found if detection is not None)
    parts = tuple(truth.shown_by(detection.mask) for detection in detections)
    center_O = mesh.bounds.mean(axis=0)

    def pose(network: int, detection: Detection, part: int) -> Pose:
        if part == NOTHING:
            turn = by_chance[FALSE_ALARM_COUNT:].reshape(NETWORKS, 4)[network]
            return pose_of_nothing(detection.mask, camera, mesh, turn)
        X_CO, visibility = truth.X_CO_true[part], float(truth.visibility[part])
        return noisy_pose(X_CO, center_O, visibility, latents[part].pose, noise.pose, network=network)

    return ImageEstimates(
        detections,
        parts,
        tuple(
            tuple(pose(network, *pair) for pair in zip(detections, parts, strict=True)) for network in range(NETWORKS)
        ),
    )


class _Latents:
    """The random numbers of one instance in one image: one difficulty for mask, S1 and S2, the rest of their own."""

    def __init__(self, streams: Streams, part: int) -> None:
        rng = streams.generator(part, "dataset errors")
        difficulty = float(rng.standard_normal())
        self.mask = MaskLatents.from_vector(difficulty, rng.standard_normal(MaskLatents.COUNT))
        self.pose = PoseLatents.from_vector(difficulty, rng.standard_normal(PoseLatents.COUNT))


def _detect(truth: ImageTruth, part: int, latents: _Latents, noise: PartNoise) -> Detection | None:
    visible = truth.mask(part)
    neighbors = (truth.part_numbers != NOTHING) & ~visible
    return noisy_detection(visible, neighbors, float(truth.visibility[part]), latents.mask, noise.mask)
