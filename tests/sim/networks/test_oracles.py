import numpy as np
import pytest

from maskval import Estimates, MaskVal, Pose, mdd, silhouette, spearman
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.oracles import OracleMask, OracleMdd
from tests.maskval.shapes import VGA, square

MESH = square()
TRUE = tuple(Pose.from_translation((0.15 * i - 0.2, 0, 0.6)) for i in range(3))
MASKS = np.array([silhouette(MESH, X_CO, VGA, pixel_center=PIXEL_CENTER).mask for X_CO in TRUE])


def latest_truth() -> LatestTruth:
    numbers = np.full((480, 640), NO_INSTANCE, dtype=np.int8)
    for part, mask in enumerate(MASKS):
        numbers[mask] = part
    made = LatestTruth()
    made.keep(FrameTruth(0, numbers, TRUE, VGA, MESH))
    return made


def estimates(poses: list[Pose], masks: np.ndarray) -> Estimates:
    return Estimates(VGA, MESH, masks, (tuple(poses),), np.ones(len(poses)), PIXEL_CENTER)


def test_the_oracle_of_the_error_ranks_perfectly() -> None:
    rng = np.random.default_rng(0)
    parts = rng.integers(3, size=40)
    poses = [
        TRUE[part]
        @ Pose.from_rotvec(rng.normal(scale=0.2, size=3))
        @ Pose.from_translation(rng.normal(scale=0.01, size=3))
        for part in parts
    ]
    errors = np.array([mdd(X_CO, TRUE[part], MESH.vertices) for X_CO, part in zip(poses, parts, strict=True)])
    u = OracleMdd(latest_truth())(estimates(poses, MASKS[parts]))
    assert spearman(u, errors) == pytest.approx(1.0)
    assert (u <= 0.5).tolist() == (errors <= 0.015).tolist()
    assert np.argsort(u).tolist() == np.argsort(errors).tolist()


def test_its_u_is_0_without_error_half_at_15_mm_and_1_without_a_part() -> None:
    masks = np.array([MASKS[0], MASKS[1], np.zeros((480, 640), dtype=bool)])
    u = OracleMdd(latest_truth())(estimates([TRUE[0], Pose.from_translation((0.015, 0, 0)) @ TRUE[1], TRUE[0]], masks))
    assert u == pytest.approx([0.0, 0.5, 1.0])


def test_the_oracle_of_the_mask_is_maskval_with_the_true_mask() -> None:
    half = MASKS.copy()
    half[:, :240] = False
    poses = [Pose.from_translation((0.02, 0, 0)) @ X_CO for X_CO in TRUE]
    expected = MaskVal()(estimates(poses, MASKS))
    assert expected == pytest.approx([1 - 80 / 120] * 3, abs=0.02)
    assert OracleMask(latest_truth())(estimates(poses, half)).tolist() == expected.tolist()
    nothing = np.zeros((1, 480, 640), dtype=bool)
    assert OracleMask(latest_truth())(estimates(poses[:1], nothing)).tolist() == [1.0]


@pytest.mark.parametrize("oracle", [OracleMdd, OracleMask])
def test_oracles_of_no_detections_say_nothing_and_without_a_frame_they_refuse(oracle) -> None:
    assert oracle(latest_truth())(estimates([], MASKS[:0])).shape == (0,)
    with pytest.raises(LookupError, match="no frame has been taken yet"):
        oracle(LatestTruth())(estimates([], MASKS[:0]))
