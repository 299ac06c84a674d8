"""What the simulated networks give for images that share no view: the same error models, other random numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection
from maskval import Pose
from sim.instance_ids import NO_INSTANCE
from sim.networks.estimators import NETWORKS, detect_part
from sim.networks.ground_truth import FrameTruth
from sim.networks.mask_noise import FALSE_ALARM_COUNT, MaskLatents, false_alarm
from sim.networks.noise_model import MaskNoise, PartNoise, PoseNoise
from sim.networks.pose_noise import PoseLatents, noisy_pose, pose_of_nothing
from sim.networks.random_streams import Streams

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class ImageEstimates:
    """N detections of one image and their poses.

    Attributes:
        detections: what the detector found.
        parts: the part that each of them shows, or `NO_INSTANCE`.
        poses: poses[e][i] is X_CO_est of detection i by network e.
    """

    detections: tuple[Detection, ...]
    parts: tuple[int, ...]
    poses: tuple[tuple[Pose, ...], ...]


def estimate_image(truth: FrameTruth, noise: PartNoise, streams: Streams) -> ImageEstimates:
    """Detections and poses of one image; an instance's errors depend on the streams and its number only.

    Args:
        truth: The image.
        noise: The part's error model.
        streams: The root of the image's random numbers; the experiment is the image's number.
    """
    latents = draw_latents(truth, streams)
    detections = detect(truth, latents, noise.mask)
    parts = tuple(truth.shown_by(detection.mask) for detection in detections)
    masks = {index: detection.mask for index, detection in enumerate(detections)}
    poses = estimate(truth, latents, masks, parts, noise.pose)
    return ImageEstimates(detections, parts, poses)


@dataclass(frozen=True, slots=True, eq=False)
class ImageLatents:
    """The random numbers of one image of P parts, whatever the error model's parameters.

    Images of a set share no view, so that the latents of `sim.networks.view_noise` are plain normal numbers here.

    Attributes:
        mask: of each part, for the detector.
        pose: of each part, for S1 and S2; difficulties are the detector's.
        false_alarm: (FALSE_ALARM_COUNT,).
        nothing: a direction in the space of quaternions for each network's pose of a false alarm, (NETWORKS, 4).
    """

    mask: tuple[MaskLatents, ...]
    pose: tuple[PoseLatents, ...]
    false_alarm: Array
    nothing: Array


def draw_latents(truth: FrameTruth, streams: Streams) -> ImageLatents:
    """The image's random numbers: one difficulty per part for mask, S1 and S2, the rest of their own."""
    masks, poses = [], []
    for part in range(len(truth.X_CO_true)):
        rng = streams.generator(part, "dataset errors")
        difficulty = float(rng.standard_normal())
        masks.append(MaskLatents.from_vector(difficulty, rng.standard_normal(MaskLatents.COUNT)))
        poses.append(PoseLatents.from_vector(difficulty, rng.standard_normal(PoseLatents.COUNT)))
    by_chance = streams.generator(0, "dataset false alarm").standard_normal(FALSE_ALARM_COUNT + 4 * NETWORKS)
    gate, nothing = np.split(by_chance, [FALSE_ALARM_COUNT])
    return ImageLatents(tuple(masks), tuple(poses), gate, nothing.reshape(NETWORKS, 4))


def detect(truth: FrameTruth, latents: ImageLatents, noise: MaskNoise) -> tuple[Detection, ...]:
    """What the detector finds in an image."""
    found = [detect_part(truth, part, one, noise) for part, one in enumerate(latents.mask)]
    found.append(false_alarm(truth.instance_ids.shape, latents.false_alarm, noise))
    return tuple(detection for detection in found if detection is not None)


def estimate(
    truth: FrameTruth,
    latents: ImageLatents,
    masks: Mapping[int, NDArray[np.bool_]],
    parts: Sequence[int],
    noise: PoseNoise,
) -> tuple[tuple[Pose, ...], ...]:
    """poses[e][i] is X_CO_est of detection i by network e.

    Args:
        truth: The image.
        latents: Its random numbers.
        masks: Of the detections that show no part, by index.
        parts: The part that each detection shows, or `NO_INSTANCE`.
        noise: The parameters.
    """
    center_O = truth.mesh.center

    def pose(network: int, index: int) -> Pose:
        part = parts[index]
        if part == NO_INSTANCE:
            return pose_of_nothing(masks[index], truth.camera, truth.mesh, latents.nothing[network])
        X_CO, visibility = truth.X_CO_true[part], float(truth.visibility[part])
        return noisy_pose(X_CO, center_O, visibility, latents.pose[part], noise, network=network)

    return tuple(tuple(pose(network, index) for index in range(len(parts))) for network in range(NETWORKS))
