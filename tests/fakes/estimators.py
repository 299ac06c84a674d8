"""Detector, pose networks and uncertainty whose answers are written down."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame, Image
from maskval import Estimates, Needs, Pose
from tests.fakes.script import MASK_TIME, POSE_TIME, scripted

PoseScript = Sequence[Pose | Sequence[Pose]]


class FakeMasks:
    """Implements `cell.interfaces.MaskEstimator`: the scores of each frame's detections; mask i is pixel (i, i)."""

    def __init__(
        self,
        scores: Sequence[Sequence[float]] = ((0.9,),),
        inference_time: float = MASK_TIME,
        images: frozenset[Image] = frozenset(),
    ) -> None:
        self._scores, self.inference_time, self.images = scores, inference_time, images
        self._calls = 0

    def detect(self, frame: Frame) -> Sequence[Detection]:
        scores = scripted(self._scores, self._calls)
        self._calls += 1
        detections = []
        for index, score in enumerate(scores):
            mask = np.zeros((frame.camera.height, frame.camera.width), dtype=bool)
            mask[index, index] = True
            detections.append(Detection(mask, score))
        return detections


class FakePoses:
    """Implements `cell.interfaces.PoseEstimator`: in the n-th frame each detection is a part at the n-th X_BO.

    Where the n-th is a sequence of poses, there is one for each detection.
    """

    def __init__(
        self, X_BO: PoseScript, inference_time: float = POSE_TIME, images: frozenset[Image] = frozenset()
    ) -> None:
        self._X_BO, self.inference_time, self.images = X_BO, inference_time, images
        self.given: list[Sequence[Detection]] = []

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> Sequence[Pose]:
        X_BO = scripted(self._X_BO, len(self.given))
        self.given.append(detections)
        X_BO_each = [X_BO] * len(detections) if isinstance(X_BO, Pose) else X_BO
        return [frame.X_BC.inverse() @ X_BO_est for X_BO_est in X_BO_each]


class FakeMethod:
    """Implements `maskval.UncertaintyMethod`: in the n-th frame the detections have the n-th u, one for all or each."""

    def __init__(self, u: Sequence[float | Sequence[float]] = (0.0,), estimators: int = 1) -> None:
        self._u, self.needs = u, Needs(estimators)
        self.given: list[Estimates] = []

    def __call__(self, estimates: Estimates) -> NDArray[np.float64]:
        u = np.full(len(estimates), scripted(self._u, len(self.given)), dtype=np.float64)
        self.given.append(estimates)
        return u
