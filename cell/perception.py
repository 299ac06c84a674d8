"""From a picture to an observation: detect, estimate, quantify, and refuse what is no estimate."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cell.errors import EstimatorError
from cell.interfaces import Detection, Frame, MaskEstimator, Observation, PoseEstimator, Station
from cell.part import Part
from maskval import Estimates, Pose, UncertaintyMethod

T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Perception:
    """A detector, as many pose estimators as the method needs, and the method.

    Attributes:
        part: the kind of part that is looked for.
        detector: finds instances.
        pose_estimators: the first one's poses are acted upon.
        method: says how uncertain they are.
        pixel_center: where the camera samples pixel i, i + pixel_center.
    """

    part: Part
    detector: MaskEstimator
    pose_estimators: tuple[PoseEstimator, ...]
    method: UncertaintyMethod
    pixel_center: float

    def look(self, station: Station, refining: bool) -> Observation:
        """Takes a picture and concludes from it; the inference of every network used is charged to the clock.

        Raises:
            EstimatorError: an estimator or the method raised, or returned something else than it promises.
        """
        used = self.pose_estimators[: self.method.estimators]
        frame = station.take_frame(self.detector.images.union(*(estimator.images for estimator in used)))
        station.wait(self.detector.inference_time + sum(estimator.inference_time for estimator in used), frozenset())
        detections = _detect(self.detector, frame)
        poses = tuple(_estimate(estimator, frame, detections) for estimator in used)
        return Observation(frame, detections, poses, self._uncertainties(frame, detections, poses), refining)

    def _uncertainties(
        self, frame: Frame, detections: Sequence[Detection], poses: tuple[tuple[Pose, ...], ...]
    ) -> NDArray[np.float64]:
        height, width = frame.camera.height, frame.camera.width
        estimates = Estimates(
            camera=frame.camera,
            mesh=self.part.mesh,
            masks=np.array([detection.mask for detection in detections]).reshape(-1, height, width).astype(bool),
            poses=poses,
            scores=np.array([detection.score for detection in detections]),
            pixel_center=self.pixel_center,
        )
        u = _asked(self.method, frame, lambda: np.array(self.method(estimates), dtype=np.float64))
        if u.shape != (len(detections),) or not np.all((u >= 0.0) & (u <= 1.0)):
            raise _refusal(self.method, frame, f"expected {len(detections)} uncertainties in [0, 1], got {u}")
        u.setflags(write=False)
        return u


def _detect(detector: MaskEstimator, frame: Frame) -> tuple[Detection, ...]:
    detections = _asked(detector, frame, lambda: tuple(detector.detect(frame)))
    size = (frame.camera.height, frame.camera.width)
    for index, detection in enumerate(detections):
        if not isinstance(detection, Detection):
            raise _refusal(
                detector,
                frame,
                f"expected detection {index} to be a cell.interfaces.Detection, got {type(detection).__name__}",
            )
        mask = np.asarray(detection.mask)
        if mask.shape != size or mask.dtype != np.bool_:
            raise _refusal(
                detector, frame, f"expected mask {index} to be bool of shape {size}, got {mask.dtype} of {mask.shape}"
            )
        if not (isinstance(detection.score, Real) and 0.0 <= detection.score <= 1.0):
            raise _refusal(detector, frame, f"expected score {index} in [0, 1], got {detection.score}")
    return tuple(sorted(detections, key=lambda detection: -detection.score))


def _estimate(estimator: PoseEstimator, frame: Frame, detections: Sequence[Detection]) -> tuple[Pose, ...]:
    poses = _asked(estimator, frame, lambda: tuple(estimator.estimate(frame, detections)))
    if len(poses) != len(detections):
        raise _refusal(estimator, frame, f"expected {len(detections)} poses, one per detection, got {len(poses)}")
    for index, pose in enumerate(poses):
        if not isinstance(pose, Pose):
            raise _refusal(estimator, frame, f"expected pose {index} to be a maskval.Pose, got {type(pose).__name__}")
    return poses


def _asked(who: object, frame: Frame, question: Callable[[], T]) -> T:
    """The answer; whatever is raised meanwhile is said to be the estimator's."""
    try:
        return question()
    except Exception as error:
        raise _refusal(who, frame, f"raised {type(error).__name__}: {error}") from error


def _refusal(who: object, frame: Frame, what: str) -> EstimatorError:
    return EstimatorError(f"{type(who).__name__} on frame {frame.index}: {what}")
