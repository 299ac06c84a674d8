import numpy as np
import pytest

from maskval import DepthConsistency, Estimates, InvalidEstimatesError, Pose, depth_image, needs_of, silhouette
from tests.maskval import shapes
from tests.maskval.shapes import VGA

AHEAD = Pose.from_translation((0, 0, 0.6))
SHEET = silhouette(shapes.square(), AHEAD, VGA).mask


def u_of(pose: Pose, depth: np.ndarray, mask: np.ndarray = SHEET, maximum_m: float = 0.02) -> float:
    made = Estimates(VGA, shapes.square(), mask[None], ((pose,),), np.ones(1), depth=depth)
    (u,) = DepthConsistency(maximum_m)(made)
    return float(u)


def plane(z: float) -> np.ndarray:
    return np.full((480, 640), z)


@pytest.mark.parametrize(("error_m", "u"), [(0.0, 0.0), (0.005, 0.25), (-0.005, 0.25), (0.02, 1.0), (0.3, 1.0)])
def test_a_sheet_before_a_plane_is_as_uncertain_as_they_are_apart(error_m: float, u: float) -> None:
    assert u_of(AHEAD, plane(0.6 + error_m)) == pytest.approx(u, abs=1e-5)


def test_the_maximum_is_the_unit() -> None:
    assert u_of(AHEAD, plane(0.61), maximum_m=0.04) == pytest.approx(0.25, abs=1e-5)


def test_a_tilted_sheet_is_off_by_the_mean_of_its_ramp() -> None:
    # The true sheet is tilted about the vertical; a flat one at its middle is off by |z - 0.6| at each pixel of it.
    tilted = AHEAD @ Pose.from_rotvec((0, 0.2, 0))
    depth = depth_image(shapes.square(), tilted, VGA)
    mask = (depth > 0) & SHEET
    expected = np.minimum(np.abs(depth[mask] - 0.6) / 0.02, 1).mean()
    assert 0.2 < expected < 0.3  # tan 0.2 of up to 50 mm: 0 to 10 mm, 5 mm in the mean
    assert u_of(AHEAD, depth, mask) == pytest.approx(expected, rel=1e-4)


def test_pixels_of_the_mask_that_the_object_does_not_cover_count_1() -> None:
    # The sheet covers the columns 270..369; the mask goes 50 columns beyond.
    mask = SHEET.copy()
    mask[190:290, 370:420] = True
    assert u_of(AHEAD, plane(0.6), mask) == pytest.approx(50 / 150, abs=1e-5)


def test_what_was_not_measured_and_what_is_outside_of_the_mask_does_not_count() -> None:
    depth = plane(0.605)
    depth[190:290, 270:320] = 0.0
    depth[~SHEET] = 3.0
    assert u_of(AHEAD, depth) == pytest.approx(0.25, abs=1e-5)


def test_nothing_measured_is_nothing_known() -> None:
    assert u_of(AHEAD, plane(0.0)) == 1.0
    assert u_of(AHEAD, plane(0.6), np.zeros_like(SHEET)) == 1.0


def test_the_surface_behind_and_before_are_equally_wrong() -> None:
    before, after = (u_of(Pose.from_translation((0, 0, 0.6 + d)), plane(0.6)) for d in (-0.004, 0.004))
    assert before == pytest.approx(0.2, abs=0.01)
    # The farther sheet does not reach the mask's border: there it counts 1.
    assert after == pytest.approx(0.2, abs=0.03)


def test_it_needs_depth() -> None:
    assert needs_of(DepthConsistency()).depth
    made = Estimates(VGA, shapes.square(), SHEET[None], ((AHEAD,),), np.ones(1))
    with pytest.raises(InvalidEstimatesError, match="needs a depth image, but the estimates hold none"):
        DepthConsistency()(made)


@pytest.mark.parametrize(
    "depth",
    [plane(0.6)[:-1], plane(-0.1), plane(np.nan), plane(np.inf)],
    ids=["another size", "negative", "NaN", "infinite"],
)
def test_a_depth_image_that_is_none_is_refused(depth: np.ndarray) -> None:
    with pytest.raises(InvalidEstimatesError, match=r"depth must be of shape \(480, 640\) \(H, W\), finite and >= 0 m"):
        u_of(AHEAD, depth)


@pytest.mark.parametrize("maximum_m", [0.0, -1.0, np.nan, np.inf])
def test_a_scale_without_end_is_refused(maximum_m: float) -> None:
    with pytest.raises(InvalidEstimatesError, match="maximum_m must be > 0 and finite"):
        DepthConsistency(maximum_m)
