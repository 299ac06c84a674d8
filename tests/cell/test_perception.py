import dataclasses
import re
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from cell.errors import EstimatorError, UncertaintyError
from cell.interfaces import Detection, Frame, Image, Observation, PoseEstimate
from cell.perception import Perception
from maskval import Correspondences, Ensemble, Needs, Pose
from tests.fakes import FakeMasks, FakeMethod, FakePoses, FakeStation, brick, on_belt, small_layout, turned

LAYOUT = small_layout()
SIZE = (LAYOUT.camera.height, LAYOUT.camera.width)
X_BO = on_belt(brick(), LAYOUT, turned())


def perception(
    detector: Any = None, estimators: Sequence[Any] | None = None, method: Any = None, pixel_center: float = 0.5
) -> Perception:
    return Perception(
        brick(), detector or FakeMasks(), tuple(estimators or [FakePoses([X_BO])]), method or FakeMethod(), pixel_center
    )


def look(seeing: Perception, station: FakeStation | None = None, refining: bool = False) -> Observation:
    return seeing.observe(seeing.take_frame(station or FakeStation(LAYOUT)), refining, time_left=5.0)


def test_detections_come_best_score_first_and_equal_ones_in_the_detectors_order():
    observation = look(perception(FakeMasks([[0.3, 0.9, 0.5, 0.9]])))
    assert [detection.score for detection in observation.detections] == [0.9, 0.9, 0.5, 0.3]
    # Detection i of the detector is the pixel (i, i).
    assert [int(detection.mask.argmax()) // SIZE[1] for detection in observation.detections] == [1, 3, 2, 0]


def test_estimators_and_method_are_given_the_detections_in_that_order():
    poses, method = FakePoses([X_BO]), FakeMethod()
    observation = look(perception(FakeMasks([[0.3, 0.9]]), [poses], method, pixel_center=0.25))
    assert [detection.score for detection in poses.given[0]] == [0.9, 0.3]
    estimates = method.given[0]
    assert estimates.scores.tolist() == [0.9, 0.3]
    np.testing.assert_array_equal(estimates.masks, [detection.mask for detection in observation.detections])
    assert estimates.poses == observation.poses
    assert estimates.camera is LAYOUT.camera
    assert estimates.pixel_center == 0.25


def test_a_frame_without_detections_is_an_observation_without_uncertainties():
    observation = look(perception(FakeMasks([[]])))
    assert observation.detections == ()
    assert observation.poses == ((),)
    assert observation.uncertainties.shape == (0,)


@pytest.mark.parametrize("refining", [False, True])
def test_an_observation_says_whether_it_is_a_second_look(refining):
    assert look(perception(), refining=refining).refining is refining


@pytest.mark.parametrize(("needed", "time"), [(1, 0.5 + 0.25), (2, 0.5 + 0.25 + 2.0), (3, 0.5 + 0.25 + 2.0 + 8.0)])
def test_the_clock_is_charged_for_the_detector_and_the_networks_that_the_method_needs(needed, time):
    station = FakeStation(LAYOUT)
    estimators = [FakePoses([X_BO], inference_time=cost) for cost in (0.25, 2.0, 8.0)]
    observation = look(perception(FakeMasks(inference_time=0.5), estimators, FakeMethod(estimators=needed)), station)
    assert station.time == time
    assert observation.frame.time == 0.0, "the picture was taken before the networks ran"
    assert [len(estimator.given) for estimator in estimators] == [1] * needed + [0] * (3 - needed)
    assert len(observation.poses) == needed


def test_all_images_that_a_network_in_use_reads_are_taken_and_no_others():
    station = FakeStation(LAYOUT)
    estimators = [FakePoses([X_BO], images=frozenset(images)) for images in ((), {Image.RGB})]
    detector = FakeMasks(images=frozenset({Image.DEPTH}))
    look(perception(detector, estimators, FakeMethod(estimators=1)), station)
    look(perception(detector, estimators, FakeMethod(estimators=2)), station)
    assert station.images == [{Image.DEPTH}, {Image.DEPTH, Image.RGB}]


class Answering(FakeMasks, FakePoses):
    """A detector and an estimator that answers whatever it is told to."""

    def __init__(self, answer: Callable[[], Any]) -> None:
        FakePoses.__init__(self, [X_BO])
        self._answer = answer

    def detect(self, frame: Frame) -> Any:
        return self._answer()

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> Any:
        return self._answer()


class Judging(FakeMethod):
    """A method that answers whatever it is told to."""

    def __init__(self, answer: Callable[[], Any]) -> None:
        super().__init__()
        self._answer = answer

    def __call__(self, estimates: object) -> Any:
        return self._answer()


def raising() -> Any:
    raise FloatingPointError("the loss went to the moon")


def assert_refused(seeing: Perception, who: str, *words: str, kind: type[EstimatorError] | None = None) -> None:
    """The second frame, of index 1, is refused in the name of the one to blame."""
    station = FakeStation(LAYOUT)
    station.take_frame(frozenset())
    with pytest.raises(EstimatorError) as refusal:
        look(seeing, station)
    assert kind is None or type(refusal.value) is kind
    message = str(refusal.value)
    assert message.startswith(f"{who} on frame 1: ")
    for word in words:
        assert word in message


GOOD_MASK = np.zeros(SIZE, dtype=bool)
BAD_DETECTIONS = [
    (raising, "raised FloatingPointError: the loss went to the moon"),
    (lambda: None, "raised TypeError"),
    (lambda: [GOOD_MASK], "expected detection 0 to be a cell.interfaces.Detection, got ndarray"),
    (lambda: [Detection(GOOD_MASK, 0.9), Detection(GOOD_MASK.T, 0.9)], f"mask 1 to be bool of shape {SIZE}"),
    (lambda: [Detection(GOOD_MASK.astype(np.uint8), 0.9)], "mask 0 to be bool", ", got uint8"),
    (lambda: [Detection(GOOD_MASK, 1.5)], "score 0 in [0, 1], got 1.5"),
    (lambda: [Detection(GOOD_MASK, -0.5)], "score 0 in [0, 1], got -0.5"),
    (lambda: [Detection(GOOD_MASK, float("nan"))], "score 0 in [0, 1], got nan"),
    (lambda: [Detection(GOOD_MASK, None)], "score 0 in [0, 1], got None"),
]


@pytest.mark.parametrize(("answer", "words"), [(answer, words) for answer, *words in BAD_DETECTIONS])
def test_a_detector_that_returns_rubbish_is_refused_by_name_and_frame(answer, words):
    assert_refused(perception(detector=Answering(answer)), "Answering", *words)


BAD_POSES = [
    (raising, "raised FloatingPointError: the loss went to the moon"),
    (lambda: None, "raised TypeError"),
    (lambda: [X_BO], "expected 2 poses, one per detection, got 1"),
    (lambda: [X_BO] * 3, "expected 2 poses, one per detection, got 3"),
    (lambda: [X_BO, X_BO.matrix], "expected pose 1 to be a maskval.Pose, got ndarray"),
    (lambda: [Pose(np.eye(3), np.array([0.0, 0.0, np.nan]))] * 2, "raised InvalidPoseError"),
    (lambda: [Pose(np.full((3, 3), 1.0), np.zeros(3))] * 2, "raised InvalidPoseError"),
]


@pytest.mark.parametrize(("answer", "words"), [(answer, words) for answer, *words in BAD_POSES])
@pytest.mark.parametrize("position", [0, 1])
def test_a_pose_estimator_that_returns_rubbish_is_refused_by_name_and_frame(answer, words, position):
    estimators = [FakePoses([X_BO])] * position + [Answering(answer)]
    seeing = perception(FakeMasks([[0.9, 0.8]]), estimators, FakeMethod(estimators=position + 1))
    assert_refused(seeing, "Answering", *words)


EXPECTED = "expected 2 uncertainties in [0, 1], got "
BAD_UNCERTAINTIES = [
    (raising, "raised FloatingPointError: the loss went to the moon"),
    (lambda: None, f"{EXPECTED}object None"),
    (lambda: "much", f"{EXPECTED}<U4 'much'"),
    (lambda: ["0.1", "0.2"], f"{EXPECTED}<U3 ['0.1', '0.2']"),
    (lambda: [True, False], f"{EXPECTED}bool [True, False]"),
    (lambda: [0.1 + 0.1j, 0.2], f"{EXPECTED}complex128 "),
    (lambda: [[0.1], [0.1, 0.2]], "raised ValueError"),
    (lambda: np.zeros(3), f"{EXPECTED}float64 [0.0, 0.0, 0.0]"),
    (lambda: np.zeros((2, 1)), EXPECTED),
    (lambda: np.array([0.5, np.nan]), f"{EXPECTED}float64 [0.5, nan]"),
    (lambda: np.array([0.5, 1.5]), f"{EXPECTED}float64 [0.5, 1.5]"),
    (lambda: np.array([-0.5, 0.5]), f"{EXPECTED}float64 [-0.5, 0.5]"),
    (lambda: [10**400, 0], f"{EXPECTED}object "),
]


@pytest.mark.parametrize(("answer", "words"), [(answer, words) for answer, *words in BAD_UNCERTAINTIES])
def test_a_method_that_returns_rubbish_is_refused_by_name_and_frame(answer, words):
    assert_refused(
        perception(FakeMasks([[0.9, 0.8]]), method=Judging(answer)), "Judging", *words, kind=UncertaintyError
    )


def test_a_method_that_needs_more_estimators_than_there_are_is_refused():
    with pytest.raises(EstimatorError, match=r"^Ensemble: expected to need at most 1 estimators, as there are, got 2$"):
        look(perception(method=Ensemble()))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"inference_time": -1.0}, "expected inference_time of 0 to 60 s, got -1.0"),
        ({"inference_time": float("nan")}, "expected inference_time of 0 to 60 s, got nan"),
        ({"inference_time": "1 s"}, "expected inference_time of 0 to 60 s, got '1 s'"),
        ({"inference_time": True}, "expected inference_time of 0 to 60 s, got True"),
        ({"inference_time": 1e6}, "expected inference_time of 0 to 60 s, got 1000000.0"),
        ({"images": [Image.RGB]}, "expected images to be a frozenset of cell.interfaces.Image, got "),
        ({"images": frozenset({"rgb"})}, "expected images to be a frozenset of cell.interfaces.Image, got "),
    ],
)
@pytest.mark.parametrize("of", [FakeMasks, FakePoses])
def test_a_network_that_says_of_itself_what_cannot_be_is_refused_by_name(of, change, words):
    network = of([[0.9]] if of is FakeMasks else [X_BO])
    for name, value in change.items():
        setattr(network, name, value)
    with pytest.raises(EstimatorError, match=f"^{of.__name__}: {re.escape(words)}"):
        look(perception(network) if of is FakeMasks else perception(estimators=[network]))


def hanging() -> Any:
    time.sleep(30)


@pytest.mark.parametrize(
    ("who", "seeing"),
    [
        ("Answering", perception(detector=Answering(hanging))),
        ("Answering", perception(estimators=[Answering(hanging)])),
        ("Judging", perception(method=Judging(hanging))),
    ],
    ids=["detector", "pose estimator", "method"],
)
def test_who_hangs_is_ended_and_refused_by_name_and_frame(who, seeing):
    assert_refused(dataclasses.replace(seeing, time_limit=0.25), who, "took longer than 0.25 s")


def test_uncertainties_belong_to_the_observation_and_cannot_be_written():
    kept = np.array([0.5])
    observation = look(perception(method=Judging(lambda: kept)))
    kept[0] = 1.0
    assert observation.uncertainties.tolist() == [0.5]
    with pytest.raises(ValueError, match="read-only"):
        observation.uncertainties[0] = 0.0


class Pointing(FakePoses):
    """A network that tells where it saw the part's origin."""

    def estimate(self, frame: Frame, detections: Sequence[Detection]) -> list[Any]:
        seen = super().estimate(frame, detections)
        points = [Correspondences(np.zeros((1, 3)), [[i, i]], [1.0]) for i in range(len(seen))]
        return [PoseEstimate(pose, point) for pose, point in zip(seen, points, strict=True)]


def test_correspondences_go_to_the_method_and_into_the_observation_beside_plain_poses():
    method = FakeMethod(estimators=2)
    observation = look(perception(FakeMasks([[0.9, 0.3]]), [Pointing([X_BO]), FakePoses([X_BO])], method))
    told = method.given[0].correspondences
    assert told is observation.correspondences
    assert [each.pixels.tolist() for each in told] == [[[0.0, 0.0]], [[1.0, 1.0]]]
    assert all(isinstance(pose, Pose) for poses in observation.poses for pose in poses)


def test_estimates_of_a_network_without_correspondences_hold_none():
    method = FakeMethod(estimators=2)
    observation = look(perception(FakeMasks([[0.9]]), [FakePoses([X_BO]), Pointing([X_BO])], method))
    assert observation.correspondences is None
    assert method.given[0].correspondences is None


def test_a_method_that_judges_the_picture_is_given_it():
    method = FakeMethod()
    method.needs = Needs(rgb=True)
    seeing = perception(method=method)
    assert seeing.images == {Image.RGB}
    rgb = np.full((*SIZE, 3), 7, dtype=np.uint8)
    seeing.observe(dataclasses.replace(seeing.take_frame(FakeStation(LAYOUT)), rgb=rgb), False, time_left=5.0)
    assert np.array_equal(method.given[0].rgb, rgb)
