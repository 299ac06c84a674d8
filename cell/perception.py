"""From a picture to an observation: detect, estimate, quantify, and reject invalid estimates."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cell.errors import EstimatorError, UncertaintyError
from cell.guards import TIME_LIMIT, guarded_call
from cell.interfaces import Detection, Frame, Image, MaskEstimator, Observation, PoseEstimate, PoseEstimator, Station
from cell.part import Part
from cell.rounding import DIGITS, rounded
from maskval import Correspondences, Estimates, InvalidEstimatesError, Pose, UncertaintyMethod, needs_of
from maskval.inputs.spelling import is_finite, shown

MOST_INFERENCE = 60.0  # s of the cell's clock per picture, three time slots; beyond, only waiting is simulated
T = TypeVar("T")
_NUMBERS = "fiu"  # kinds of NumPy's: neither bool, complex, text nor objects


@dataclass(frozen=True, slots=True, eq=False)
class Perception:
    """A detector, as many pose estimators as the method needs, and the method.

    Attributes:
        part: the kind of part that is looked for.
        detector: finds instances.
        pose_estimators: the first one's poses are acted upon.
        method: says how uncertain they are.
        pixel_center: where the camera samples pixel i, i + pixel_center.
        time_limit: s of the wall clock that each of them has per frame.
    """

    part: Part
    detector: MaskEstimator
    pose_estimators: tuple[PoseEstimator, ...]
    method: UncertaintyMethod
    pixel_center: float
    time_limit: float = TIME_LIMIT

    @property
    def images(self) -> frozenset[Image]:
        """The images that the networks in use and the method read.

        Raises:
            EstimatorError: a network or the method says of itself what cannot be.
        """
        networks = self._networks()
        needs = needs_of(self.method)
        judged = {image for image, needed in ((Image.RGB, needs.rgb), (Image.DEPTH, needs.depth)) if needed}
        return frozenset(judged).union(*(network.images for network in networks))

    @property
    def inference_time(self) -> float:
        """What a picture costs, s of the cell's clock: the inference of all networks in use.

        Raises:
            EstimatorError: a network or the method says of itself what cannot be.
        """
        return sum(network.inference_time for network in self._networks())

    def take_frame(self, station: Station) -> Frame:
        """A picture with what the networks in use read; the inference of all of them is charged to the clock.

        Raises:
            EstimatorError: a network or the method says of itself what cannot be.
        """
        frame = station.take_frame(self.images)
        station.wait(self.inference_time, frozenset())
        return frame

    def observe(self, frame: Frame, refining: bool, time_left: float) -> Observation:
        """What is concluded from a picture.

        Args:
            frame: the picture.
            refining: see `Observation`.
            time_left: s, see `Observation`.

        Raises:
            EstimatorError: an estimator or the method raised, took too long, or returned what it should not.
        """
        detections = self._detect(frame)
        estimates = [self._estimate(estimator, frame, detections) for estimator in self._used()]
        poses = tuple(tuple(estimate.X_CO_est for estimate in each) for each in estimates)
        points = _correspondences(estimates[0])
        u = self.uncertainties(frame, detections, poses, points)
        return Observation(frame, detections, poses, u, refining, time_left, self.inference_time, points)

    def _networks(self) -> tuple[MaskEstimator | PoseEstimator, ...]:
        networks: tuple[MaskEstimator | PoseEstimator, ...] = (self.detector, *self._used())
        for network in networks:
            _check_network(network)
        return networks

    def _used(self) -> tuple[PoseEstimator, ...]:
        name, available = type(self.method).__name__, len(self.pose_estimators)
        try:
            needed = needs_of(self.method).estimators
        except InvalidEstimatesError as error:
            raise UncertaintyError(str(error)) from error
        if needed > available:
            raise UncertaintyError(
                f"{name}: expected to need at most {available} estimators, as there are, got {needed}"
            )
        return self.pose_estimators[:needed]

    def uncertainties(
        self,
        frame: Frame,
        detections: Sequence[Detection],
        poses: tuple[tuple[Pose, ...], ...],
        correspondences: tuple[Correspondences, ...] | None = None,
    ) -> NDArray[np.float64]:
        """The method's u of each detection, (N,) in [0, 1], to `DIGITS` decimals, read-only.

        Raises:
            UncertaintyError: the method raised, took too long, or returned something else.
        """
        height, width = frame.camera.height, frame.camera.width
        estimates = Estimates(
            camera=frame.camera,
            mesh=self.part.mesh,
            masks=np.array([detection.mask for detection in detections]).reshape(-1, height, width).astype(bool),
            poses=poses,
            scores=np.array([detection.score for detection in detections]),
            pixel_center=self.pixel_center,
            depth=frame.depth,
            X_BC=frame.X_BC,
            correspondences=correspondences,
            rgb=frame.rgb,
        )
        told = self._guarded(self.method, frame, lambda: np.asarray(self.method(estimates)))
        if told.dtype.kind not in _NUMBERS or told.shape != (len(detections),) or not np.all((told >= 0) & (told <= 1)):
            expected = f"expected {len(detections)} uncertainties in [0, 1]"
            raise _error(self.method, frame, f"{expected}, got {told.dtype} {shown(told.tolist())}")
        u = rounded(told.astype(np.float64))
        u.setflags(write=False)
        return u

    def _detect(self, frame: Frame) -> tuple[Detection, ...]:
        detector, size = self.detector, (frame.camera.height, frame.camera.width)
        detections = self._guarded(detector, frame, lambda: tuple(detector.detect(frame)))
        for index, detection in enumerate(detections):
            wrong = _wrong_detection(detection, index, size)
            if wrong is not None:
                raise _error(detector, frame, wrong)
        return tuple(sorted(detections, key=by_score))

    def _estimate(
        self, estimator: PoseEstimator, frame: Frame, detections: Sequence[Detection]
    ) -> tuple[PoseEstimate, ...]:
        poses = self._guarded(estimator, frame, lambda: tuple(estimator.estimate(frame, detections)))
        if len(poses) != len(detections):
            raise _error(estimator, frame, f"expected {len(detections)} poses, one per detection, got {len(poses)}")
        for index, pose in enumerate(poses):
            if not isinstance(pose, Pose | PoseEstimate):
                kind = type(pose).__name__
                raise _error(estimator, frame, f"expected pose {index} to be a maskval.Pose, got {kind}")
        return tuple(PoseEstimate(pose) if isinstance(pose, Pose) else pose for pose in poses)

    def _guarded(self, who: object, frame: Frame, call: Callable[[], T]) -> T:
        return guarded_call(call, self.time_limit, lambda what: _error(who, frame, what))


def _correspondences(estimates: Sequence[PoseEstimate]) -> tuple[Correspondences, ...] | None:
    """Those of all estimates; None where one has none."""
    points = [estimate.correspondences for estimate in estimates]
    known = tuple(each for each in points if each is not None)
    return known if len(known) == len(points) else None


def by_score(detection: Detection) -> float:
    """What detections are sorted by, the best score first; where scores are equal to `DIGITS` decimals, order stays."""
    return -round(float(detection.score), DIGITS)


def _wrong_detection(detection: object, index: int, size: tuple[int, int]) -> str | None:
    """What is wrong with a detection, None if nothing is."""
    if not isinstance(detection, Detection):
        return f"expected detection {index} to be a cell.interfaces.Detection, got {type(detection).__name__}"
    mask = np.asarray(detection.mask)
    if mask.shape != size or mask.dtype != np.bool_:
        return f"expected mask {index} to be bool of shape {size}, got {mask.dtype} of {mask.shape}"
    if not (isinstance(detection.score, Real) and 0.0 <= detection.score <= 1.0):
        return f"expected score {index} in [0, 1], got {detection.score}"
    return None


def _check_network(network: MaskEstimator | PoseEstimator) -> None:
    name, cost, images = type(network).__name__, network.inference_time, network.images
    if not (is_finite(cost) and 0.0 <= cost <= MOST_INFERENCE):
        raise EstimatorError(f"{name}: expected inference_time of 0 to {MOST_INFERENCE:g} s, got {shown(cost)}")
    if not (isinstance(images, frozenset) and all(isinstance(image, Image) for image in images)):
        raise EstimatorError(f"{name}: expected images to be a frozenset of cell.interfaces.Image, got {images!r}")


def _error(who: object, frame: Frame, what: str) -> EstimatorError:
    kind = EstimatorError if hasattr(who, "inference_time") else UncertaintyError  # which every network states
    return kind(f"{type(who).__name__} on frame {frame.index}: {what}")
