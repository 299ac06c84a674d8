import math
from dataclasses import replace

import numpy as np
import pytest

from cell.interfaces import Detection, Frame
from cell.part import Part
from maskval import Camera, Mesh, Pose, mask_iou, mdd, silhouette
from sim.networks.estimators import (
    ErrorPoses,
    NoisyMasks,
    NoisyPoses,
    OraclePoses,
    make_estimators,
    pose_with_mdd,
)
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.noise_model import PartNoise
from sim.networks.random_streams import Streams
from tests.round_noise import ROUND

CAMERA = Camera(600, 600, 320, 240, 640, 480)
NOISE = ROUND
STREAMS = Streams(seed=5, experiment=2, part_name="box")
SURE = replace(NOISE, mask=replace(NOISE.mask, miss_probability=0.0, false_alarms_per_image=0.0))


def box_part() -> Part:
    """150 × 60 × 40 mm, its origin in the middle of its base."""
    corners = np.array([(x, y, z) for x in (-0.075, 0.075) for y in (-0.03, 0.03) for z in (0.0, 0.04)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    return Part("box", Mesh(corners, np.array(faces)), grasps=(), slot_size=(0.2, 0.1))


PART = box_part()
DOWN = Pose.from_rotvec((math.pi, 0, 0))


def posed(x: float, y: float, yaw: float = 0.0, tilt: float = 0.0) -> Pose:
    """X_CO with the part's middle at (x, y, 0.5) m, seen from `tilt` (rad) beside its z axis."""
    turn = DOWN @ Pose.from_rotvec((0, tilt, 0)) @ Pose.from_rotvec((0, 0, yaw))
    return Pose.from_translation((x, y, 0.5)) @ turn @ Pose.from_translation(-PART.mesh.center)


def shown(latest_truth: LatestTruth, poses: list[Pose], index: int = 0) -> Frame:
    """A frame that shows the parts, later ones in front, with its truth."""
    numbers = np.full((480, 640), -1, dtype=np.int8)
    for part, X_CO in enumerate(poses):
        numbers[silhouette(PART.mesh, X_CO, CAMERA, pixel_center=0.5).mask] = part
    latest_truth.keep(FrameTruth(index, numbers, tuple(poses), CAMERA, PART.mesh))
    return Frame(index, 0.1 * index, CAMERA, Pose.from_rotvec((math.pi, 0, 0), (0.7, 0.1, 0.5)))


TWO = [posed(-0.1, 0.0, yaw=0.3), posed(0.1, 0.05, yaw=-1.2)]


def noisy(latest_truth: LatestTruth, noise: PartNoise = SURE, streams: Streams = STREAMS):
    return make_estimators("noisy", latest_truth, PART, noise, streams)


def same_poses(ones: list[Pose], others: list[Pose]) -> bool:
    return len(ones) == len(others) > 0 and all(
        np.array_equal(one.matrix, other.matrix) for one, other in zip(ones, others, strict=True)
    )


def same_detections(ones: list[Detection], others: list[Detection]) -> bool:
    return len(ones) == len(others) > 0 and all(
        one.score == other.score and np.array_equal(one.mask, other.mask)
        for one, other in zip(ones, others, strict=True)
    )


def test_the_same_view_has_the_same_errors_bit_for_bit() -> None:
    latest_truth = LatestTruth()
    masks, (S1, S2) = noisy(latest_truth)
    frame = shown(latest_truth, TWO)
    found = masks.detect(frame)
    poses = S1.estimate(frame, found), S2.estimate(frame, found)
    shown_elsewhere = shown(latest_truth, [posed(0.0, 0.1), posed(0.0, -0.1)], index=1)
    S2.estimate(shown_elsewhere, masks.detect(shown_elsewhere))
    again = shown(latest_truth, TWO, index=2)
    assert same_detections(masks.detect(again), found)
    assert same_poses(S1.estimate(again, found), poses[0])
    assert same_poses(S2.estimate(again, found), poses[1])


def test_no_network_depends_on_who_else_is_asked_or_in_what_order() -> None:
    latest_truth = LatestTruth()
    masks, (S1, S2) = noisy(latest_truth)
    frame = shown(latest_truth, TWO)
    second = S2.estimate(frame, masks.detect(frame)[::-1])[::-1]
    first = S1.estimate(frame, masks.detect(frame))
    alone_masks, (alone, _) = noisy(latest_truth)
    assert same_poses(alone.estimate(frame, alone_masks.detect(frame)), first)
    assert not same_poses(second, first)
    fresh = NoisyPoses(latest_truth, PART, SURE, STREAMS, network=1)
    assert same_poses(fresh.estimate(frame, masks.detect(frame)), second)


@pytest.mark.parametrize("streams", [Streams(6, 2, "box"), Streams(5, 3, "box"), Streams(5, 2, "bolt")])
def test_another_seed_experiment_or_kind_has_other_errors(streams) -> None:
    latest_truth = LatestTruth()
    frame = shown(latest_truth, TWO)
    masks, (S1, _) = noisy(latest_truth)
    other_masks, (other, _) = noisy(latest_truth, streams=streams)
    assert not same_detections(other_masks.detect(frame), masks.detect(frame))
    assert not same_poses(other.estimate(frame, masks.detect(frame)), S1.estimate(frame, masks.detect(frame)))


def test_another_view_has_a_partly_new_error() -> None:
    # Errors along the ray, of views 30° apart, from 600 experiments: expected .40, off by (1 − .4²) / √600 = .034.
    core = replace(NOISE, pose=replace(NOISE.pose, outlier_probability=0.0, difficulty_gain=0.0))
    latest_truth = LatestTruth()

    def depth_error(experiment: int, tilt: float) -> float:
        X_CO = posed(0, 0, tilt=tilt)
        frame = shown(latest_truth, [X_CO])
        S1 = NoisyPoses(latest_truth, PART, core, Streams(0, experiment, "box"), network=0)
        X_CO_est = S1.estimate(frame, [Detection(latest_truth.of(frame).mask(0), 1.0)])[0]
        return float(X_CO_est.apply(PART.mesh.center)[2] - 0.5)

    errors = np.array([[depth_error(n, 0.0), depth_error(n, math.radians(30))] for n in range(600)])
    assert np.corrcoef(errors.T)[0, 1] == pytest.approx(0.403, abs=4 * 0.034)
    # Its size: 2.5 · 0.5 mm at 0.8 m, here at 0.5 m; 600 of them are off by 1/√1200 = 2.9 %.
    assert errors[:, 0].std() == pytest.approx(2.5 * 0.5e-3 * 0.5 / 0.8, rel=4 * 0.029)


def test_noisy_masks_are_near_the_true_ones() -> None:
    latest_truth = LatestTruth()
    masks, _ = noisy(latest_truth)
    frame = shown(latest_truth, TWO)
    found = masks.detect(frame)
    assert len(found) == 2
    for part, detection in enumerate(found):
        assert 0.85 < mask_iou(detection.mask, latest_truth.of(frame).mask(part)) < 1.0


def test_a_hidden_part_is_estimated_worse() -> None:
    # The front part hides about two thirds of the one behind it: exp(1.86 · .66) = 3.4 times the core.
    core = replace(NOISE, pose=replace(NOISE.pose, outlier_probability=0.0))
    latest_truth = LatestTruth()
    frame = shown(latest_truth, [posed(0, 0), posed(0.05, 0)])
    truth = latest_truth.of(frame)
    hidden = 1.0 - truth.visibility[0]
    assert hidden == pytest.approx(2 / 3, abs=0.05)
    beside = NoisyPoses(latest_truth, PART, core, STREAMS, 0).estimate(frame, [Detection(truth.mask(0), 1.0)])[0]
    alone_frame = shown(latest_truth, [posed(0, 0)])
    whole = [Detection(latest_truth.of(alone_frame).mask(0), 1.0)]
    alone = NoisyPoses(latest_truth, PART, core, STREAMS, 0).estimate(alone_frame, whole)[0]
    turns = [np.linalg.norm((X_CO @ posed(0, 0).inverse()).rotvec) for X_CO in (beside, alone)]
    assert turns[0] / turns[1] == pytest.approx(math.exp(1.86 * hidden), rel=1e-6)


def test_oracles_tell_the_truth() -> None:
    latest_truth = LatestTruth()
    masks, (S1, S2) = make_estimators("oracle", latest_truth, PART, NOISE, STREAMS)
    frame = shown(latest_truth, TWO)
    found = masks.detect(frame)
    assert [detection.score for detection in found] == [1.0, 1.0]
    for part, detection in enumerate(found):
        np.testing.assert_array_equal(detection.mask, latest_truth.of(frame).mask(part))
    assert same_poses(S1.estimate(frame, found[::-1]), TWO[::-1])
    assert same_poses(S2.estimate(frame, found), TWO)


@pytest.mark.parametrize("kind", ["oracle", "noisy"])
def test_inference_times_come_from_the_file_and_no_image_is_asked_for(kind) -> None:
    masks, poses = make_estimators(kind, LatestTruth(), PART, NOISE, STREAMS)
    assert (masks.inference_time, [network.inference_time for network in poses]) == (0.25, [0.20, 0.20])
    assert all(estimator.images == frozenset() for estimator in (masks, *poses))


def test_a_false_alarm_gets_a_pose_in_its_direction() -> None:
    noise = replace(NOISE, mask=replace(NOISE.mask, false_alarms_per_image=1.0))
    latest_truth = LatestTruth()
    masks, networks = noisy(latest_truth, noise)
    frame = shown(latest_truth, [])
    found = masks.detect(frame)
    assert len(found) == 1
    v, u = np.argwhere(found[0].mask).mean(axis=0) + 0.5
    poses = [network.estimate(frame, found)[0] for network in networks]
    for X_CO in poses:
        np.testing.assert_allclose(CAMERA.project(X_CO.apply(PART.mesh.center)), (u, v), atol=1e-9)
    assert not same_poses(poses[:1], poses[1:])
    assert same_detections(masks.detect(frame), found)


@pytest.mark.parametrize("wanted", [0.001, 0.015, 0.06, 0.1])
def test_a_wanted_error_is_met_exactly_in_every_frame(wanted) -> None:
    latest_truth = LatestTruth()
    network = ErrorPoses(latest_truth, PART, NOISE, STREAMS, wanted_mdd=wanted)
    masks, _ = make_estimators("oracle", latest_truth, PART, NOISE, STREAMS)
    seen = []
    for index in range(10):
        frame = shown(latest_truth, TWO, index)
        poses = network.estimate(frame, masks.detect(frame))
        assert same_poses(poses, network.estimate(frame, masks.detect(frame)))
        for X_CO_est, X_CO_true in zip(poses, TWO, strict=True):
            assert mdd(X_CO_est, X_CO_true, PART.mesh.vertices) == pytest.approx(wanted, abs=1e-9)
        seen += [(X_CO @ TWO[part].inverse()).matrix.tobytes() for part, X_CO in enumerate(poses)]
    assert len(set(seen)) == 20


def test_a_wanted_error_of_zero_is_the_truth() -> None:
    assert pose_with_mdd(TWO[0], PART.mesh, 0.0, np.random.default_rng(0)) is TWO[0]


def test_wanted_errors_have_any_direction_and_any_mixture() -> None:
    # The mean of 400 unit vectors has components off by √(1/3/400) = .029. Shifts are a uniform share of an error whose
    # sum can cancel in part, so that their mean lies somewhat above a half of it, and they span all of it.
    shifts = []
    for seed in range(400):
        X_CO = pose_with_mdd(TWO[0], PART.mesh, 0.02, np.random.default_rng(seed))
        shifts.append(X_CO.apply(PART.mesh.center) - TWO[0].apply(PART.mesh.center))
    lengths = np.linalg.norm(shifts, axis=1)
    np.testing.assert_allclose((np.array(shifts) / lengths[:, None]).mean(axis=0), 0.0, atol=4 * 0.029)
    assert lengths.min() < 0.001
    assert 0.019 < lengths.max() <= 0.02 + 1e-9


def test_exact_poses_refuse_a_mask_that_shows_no_part() -> None:
    latest_truth = LatestTruth()
    frame = shown(latest_truth, TWO, index=7)
    corner = np.zeros((480, 640), dtype=bool)
    corner[:5, :5] = True
    for exact in (
        OraclePoses(latest_truth, PART, NOISE),
        ErrorPoses(latest_truth, PART, NOISE, STREAMS, wanted_mdd=0.01),
    ):
        with pytest.raises(LookupError, match="detection 0 of frame 7 shows no part"):
            exact.estimate(frame, [Detection(corner, 1.0)])


def test_what_is_no_estimator_is_refused() -> None:
    latest_truth = LatestTruth()
    with pytest.raises(ValueError, match="unknown estimator 'perfect': expected oracle or noisy"):
        make_estimators("perfect", latest_truth, PART, NOISE, STREAMS)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"network must be 0 \(S1\) or 1 \(S2\), got 2"):
        NoisyPoses(latest_truth, PART, NOISE, STREAMS, network=2)
    with pytest.raises(ValueError, match=r"wanted_mdd must be in \[0, 0.1\] m, got 60"):
        ErrorPoses(latest_truth, PART, NOISE, STREAMS, wanted_mdd=60)


def test_an_older_frame_is_refused() -> None:
    latest_truth = LatestTruth()
    masks = NoisyMasks(latest_truth, PART, NOISE, STREAMS)
    old = shown(latest_truth, TWO, index=3)
    shown(latest_truth, TWO, index=4)
    with pytest.raises(LookupError, match="frame 3 is not held any more, only frame 4"):
        masks.detect(old)
