"""The simulated networks: exact ones, noisy ones, and one with an error of a wanted size.

They read the truth of the newest frame from the latest_truth, not its images. What they return is a function of seed,
experiment, part and view only (and of the frame's index, where a share of the errors is renewed): no call changes the
next one's result.
"""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame, Image, MaskEstimator, PoseEstimator
from cell.part import Part
from maskval import Mesh, Pose, mdd
from sim.instance_ids import NO_INSTANCE
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.mask_noise import FALSE_ALARM_COUNT, MaskLatents, false_alarm, noisy_detection
from sim.networks.noise_model import MaskNoise, PartNoise
from sim.networks.picture_noise import PictureLatents
from sim.networks.pose_noise import PoseLatents, displace, noisy_pose, pose_of_nothing
from sim.networks.random_streams import Streams

Kind = Literal["oracle", "noisy"]
NETWORKS = 2  # S1 and S2

_NO_IMAGES: frozenset[Image] = frozenset()


def make_estimators(
    kind: Kind, latest_truth: LatestTruth, part: Part, noise: PartNoise, streams: Streams
) -> tuple[MaskEstimator, tuple[PoseEstimator, PoseEstimator]]:
    """The detector and the pose networks S1 and S2.

    Args:
        kind: "oracle" for exact ones (of `noise` they take the timing only), "noisy" for realistic ones.
        latest_truth: Where the truth of the newest frame is.
        part: The kind of part that is looked for.
        noise: Its error model.
        streams: The root of the experiment's random numbers.

    Raises:
        ValueError: another kind.
    """
    if kind == "oracle":
        exact = OraclePoses(latest_truth, part, noise)
        return OracleMasks(latest_truth, noise), (exact, exact)
    if kind == "noisy":
        first, second = (NoisyPoses(latest_truth, part, noise, streams, network) for network in range(NETWORKS))
        return NoisyMasks(latest_truth, part, noise, streams), (first, second)
    raise ValueError(f"unknown estimator {kind!r}: expected oracle or noisy")


def detect_part(truth: FrameTruth, part: int, latents: MaskLatents, noise: MaskNoise) -> Detection | None:
    """What the detector gives for one part; None when it misses it.

    Args:
        truth: The frame.
        part: The part's number.
        latents: The random numbers of this view of it.
        noise: The detector's error model.
    """
    visible = truth.mask(part)
    neighbors = truth.instance_ids != NO_INSTANCE
    neighbors ^= visible
    return noisy_detection(visible, neighbors, float(truth.visibility[part]), latents, noise)


class OracleMasks:
    """Implements `cell.interfaces.MaskEstimator`: every visible part, its exact visible mask, score 1."""

    def __init__(self, latest_truth: LatestTruth, noise: PartNoise) -> None:
        self._latest_truth = latest_truth
        self.inference_time = noise.timing.detector_s
        self.images = _NO_IMAGES

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        truth = self._latest_truth.of(frame)
        return [Detection(truth.mask(part), 1.0) for part in truth.visible_parts()]


class OraclePoses:
    """Implements `cell.interfaces.PoseEstimator`: the true pose of the part that a detection shows."""

    def __init__(self, latest_truth: LatestTruth, part: Part, noise: PartNoise) -> None:
        self._latest_truth, self._center_O = latest_truth, part.mesh.center
        self.inference_time = noise.timing.pose_s
        self.images = _NO_IMAGES

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[Pose]:
        """See `PoseEstimator`.

        Raises:
            LookupError: a detection shows no part; exact masks never do that.
        """
        truth = self._latest_truth.of(frame)
        parts = [_shown(truth, detections, index) for index in range(len(detections))]
        return [truth.X_CO_seen(part, self._center_O, frame.camera) for part in parts]


class NoisyMasks:
    """Implements `cell.interfaces.MaskEstimator` with the errors of `sim.networks.mask_noise`."""

    def __init__(self, latest_truth: LatestTruth, part: Part, noise: PartNoise, streams: Streams) -> None:
        self._latest_truth, self._center_O, self._noise = latest_truth, part.mesh.center, noise.mask
        self._latents = PictureLatents(streams, noise.view)
        self.inference_time = noise.timing.detector_s
        self.images = _NO_IMAGES

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        truth = self._latest_truth.of(frame)
        found = [self._instance(truth, part, frame) for part in truth.visible_parts()]
        if self._noise.false_alarms_per_image > 0.0:
            latents = self._latents.of_camera("false alarm", FALSE_ALARM_COUNT, frame.X_BC, frame=frame.index)
            found.append(false_alarm(truth.instance_ids.shape, latents, self._noise))
        return [detection for detection in found if detection is not None]

    def _instance(self, truth: FrameTruth, part: int, frame: Frame) -> Detection | None:
        X_CO = truth.X_CO_true[part]
        difficulty = _difficulty(self._latents, part, X_CO, self._center_O, frame)
        vector = self._latents.of_part("mask", MaskLatents.COUNT, part, X_CO, self._center_O, frame=frame.index)
        return detect_part(truth, part, MaskLatents.from_vector(difficulty, vector), self._noise)


class NoisyPoses:
    """Implements `cell.interfaces.PoseEstimator` with the errors of `pose_noise`: S1 (network 0) or S2 (1)."""

    def __init__(self, latest_truth: LatestTruth, part: Part, noise: PartNoise, streams: Streams, network: int) -> None:
        if network not in range(NETWORKS):
            raise ValueError(f"network must be 0 (S1) or 1 (S2), got {network}")
        self._latest_truth, self._mesh, self._noise, self._network = latest_truth, part.mesh, noise.pose, network
        self._center_O = part.mesh.center
        self._latents = PictureLatents(streams, noise.view)
        self.inference_time = noise.timing.pose_s
        self.images = _NO_IMAGES

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[Pose]:
        """See `PoseEstimator`; a detection that shows no part gets a pose that fits its place and size."""
        truth = self._latest_truth.of(frame)
        return [self._pose(truth, frame, detection) for detection in detections]

    def _pose(self, truth: FrameTruth, frame: Frame, detection: Detection) -> Pose:
        part = truth.part_of(detection)
        if part is None:
            latents = self._latents.of_camera(f"pose of nothing {self._network}", 4, frame.X_BC, frame=frame.index)
            return pose_of_nothing(detection.mask, frame.camera, self._mesh, latents)
        X_CO = truth.X_CO_true[part]
        difficulty = _difficulty(self._latents, part, X_CO, self._center_O, frame)
        vector = self._latents.of_part("pose", PoseLatents.COUNT, part, X_CO, self._center_O, frame=frame.index)
        visibility = float(truth.visibility[part])
        latents_of_view = PoseLatents.from_vector(difficulty, vector)
        X_CO_seen = truth.X_CO_seen(part, self._center_O, frame.camera)
        return noisy_pose(X_CO_seen, self._center_O, visibility, latents_of_view, self._noise, network=self._network)


class ErrorPoses:
    """Implements `cell.interfaces.PoseEstimator`: the true pose with an error of a wanted size.

    For the study of success against error. Every part and frame has another error; the direction of the shift and
    the axis of the turn are uniform, and so is the share that the shift has of both.

    Args:
        latest_truth: Where the truth of the newest frame is.
        part: The kind of part.
        noise: Its error model, for the timing only.
        streams: The root of the experiment's random numbers.
        wanted_mdd: Maximum distance error over the part's vertices, m, in [0, 0.1].
    """

    def __init__(
        self, latest_truth: LatestTruth, part: Part, noise: PartNoise, streams: Streams, wanted_mdd: float
    ) -> None:
        if not 0.0 <= wanted_mdd <= 0.1:
            raise ValueError(f"wanted_mdd must be in [0, 0.1] m, got {wanted_mdd}")
        self._latest_truth, self._mesh, self._streams, self._wanted = latest_truth, part.mesh, streams, wanted_mdd
        self.inference_time = noise.timing.pose_s
        self.images = _NO_IMAGES

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[Pose]:
        """See `PoseEstimator`.

        Raises:
            LookupError: a detection shows no part.
        """
        truth = self._latest_truth.of(frame)
        parts = [_shown(truth, detections, index) for index in range(len(detections))]
        return [self._pose(truth.X_CO_true[part], part, frame.index) for part in parts]

    def _pose(self, X_CO_true: Pose, part: int, frame: int) -> Pose:
        rng = self._streams.generator(part, "wanted error", frame)
        return pose_with_mdd(X_CO_true, self._mesh, self._wanted, rng)


def pose_with_mdd(X_CO_true: Pose, mesh: Mesh, wanted_mdd: float, rng: np.random.Generator) -> Pose:
    """A pose that is wrong by exactly (1 nm) the wanted maximum distance error over the mesh's vertices.

    Args:
        X_CO_true: The true pose.
        mesh: The part.
        wanted_mdd: m, ≥ 0.
        rng: Gives direction, axis and share.
    """
    if wanted_mdd == 0.0:
        return X_CO_true
    shift, axis = (vector / np.linalg.norm(vector) for vector in rng.normal(size=(2, 3)))
    share = rng.uniform()
    center_O = mesh.center
    # The whole error of size 1 m: the shift's share of it, and the turn that moves the farthest vertex by the rest.
    radius = float(np.linalg.norm(mesh.vertices - center_O, axis=1).max())
    error = np.concatenate((share * shift, (1.0 - share) / radius * axis))
    low, high = 0.0, wanted_mdd
    while mdd(displace(X_CO_true, center_O, high * error), X_CO_true, mesh.vertices) < wanted_mdd:
        low, high = high, 2.0 * high
    while high - low > 1e-10:
        size = (low + high) / 2.0
        short = mdd(displace(X_CO_true, center_O, size * error), X_CO_true, mesh.vertices) < wanted_mdd
        low, high = (size, high) if short else (low, size)
    return displace(X_CO_true, center_O, high * error)


def _difficulty(latents: PictureLatents, part: int, X_CO: Pose, center_O: NDArray[np.float64], frame: Frame) -> float:
    """D of a view: one number for mask, S1 and S2, so it comes from here for all of them."""
    return float(latents.of_part("difficulty", 1, part, X_CO, center_O, frame=frame.index)[0])


def _shown(truth: FrameTruth, detections: Sequence[Detection], index: int) -> int:
    part = truth.part_of(detections[index])
    if part is None:
        raise LookupError(f"detection {index} of frame {truth.frame} shows no part, so there is no true pose for it")
    return part
