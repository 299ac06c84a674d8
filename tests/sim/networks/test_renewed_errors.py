import math

import numpy as np
import pytest

from cell.interfaces import Detection, Frame
from maskval import Camera, Pose, silhouette
from sim.errors import NoiseFileError
from sim.networks.estimators import make_estimators
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.mask_noise import MaskLatents
from sim.networks.noise_model import PartNoise
from sim.networks.pose_noise import PoseLatents
from sim.networks.random_streams import Streams
from tests.fakes import brick
from tests.round_noise import ROUND

PART = brick()
VIEW = Pose.from_rotvec((math.pi, 0, 0), (0.02, 0.0, 0.5)) @ Pose.from_translation(-PART.mesh.center)
CAMERA = Camera(600, 600, 320, 240, 640, 480)
STREAMS = Streams(seed=5, experiment=2, part_name="box")
SURE = ROUND.changed(
    {"mask.miss_probability": 0.0, "mask.false_alarms_per_image": 0.0, "pose.outlier_probability": 0.0}
)


def seen(noise: PartNoise, index: int) -> tuple[np.ndarray, Pose, Pose]:
    """The mask, and the poses by S1 and S2, of one part that every picture shows from the same view."""
    latest_truth = LatestTruth()
    numbers = np.where(silhouette(PART.mesh, VIEW, CAMERA, pixel_center=0.5).mask, 0, -1).astype(np.int8)
    latest_truth.keep(FrameTruth(index, numbers, (VIEW,), CAMERA, PART.mesh))
    frame = Frame(index, 0.1 * index, CAMERA, Pose.from_rotvec((math.pi, 0, 0), (0.7, 0.1, 0.5)))
    masks, networks = make_estimators("noisy", latest_truth, PART, noise, STREAMS)
    first, second = (network.estimate(frame, [Detection(numbers == 0, 1.0)])[0] for network in networks)
    return masks.detect(frame)[0].mask, first, second


def differ(ones: tuple[np.ndarray, Pose, Pose], others: tuple[np.ndarray, Pose, Pose]) -> list[bool]:
    """Whether mask, S1's pose and S2's pose of two pictures differ."""
    poses = [not np.array_equal(one.matrix, other.matrix) for one, other in zip(ones[1:], others[1:], strict=True)]
    return [not np.array_equal(ones[0], others[0]), *poses]


def test_a_renewed_share_makes_every_network_err_anew_in_every_picture() -> None:
    renewed = SURE.changed({"view.renewed_share": 0.5})
    assert differ(seen(renewed, 0), seen(renewed, 1)) == [True, True, True]
    assert differ(seen(renewed, 1), seen(renewed, 1)) == [False, False, False]


def test_without_a_renewed_share_a_view_repeats_its_errors_in_every_picture() -> None:
    assert differ(seen(SURE, 0), seen(SURE, 1)) == [False, False, False]


def test_what_S1_and_S2_share_is_renewed_for_both() -> None:
    twins = SURE.changed(
        {
            "pose.second_scale": 1.0,
            "pose.second_difficulty_correlation": 1.0,
            "pose.second_core_correlation": 1.0,
            "view.renewed_share": 1.0,
        }
    )
    for index in (0, 1):
        _, first, second = seen(twins, index)
        np.testing.assert_allclose(second.matrix, first.matrix, atol=1e-12)


def test_mask_S1_and_S2_share_a_renewed_difficulty(monkeypatch) -> None:
    told: list[float] = []
    for record in (MaskLatents, PoseLatents):
        original = record.from_vector

        def spy(difficulty, vector, original=original):
            told.append(difficulty)
            return original(difficulty, vector)

        monkeypatch.setattr(record, "from_vector", spy)
    for index in (0, 1):
        seen(SURE.changed({"view.renewed_share": 1.0}), index)
    assert len(told) == 6
    assert told[0] == told[1] == told[2] != told[3]
    assert told[3] == told[4] == told[5]


@pytest.mark.parametrize("share", [-0.1, 1.1])
def test_a_renewed_share_out_of_range_is_refused(share) -> None:
    with pytest.raises(NoiseFileError, match=r"renewed_share: expected a number in \[0, 1\]"):
        ROUND.changed({"view.renewed_share": share})
