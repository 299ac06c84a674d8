"""Constants of the library, each held by its reason, and values on the edges of their ranges."""

import math
import warnings

import numpy as np
import pytest

from maskval import (
    METHODS,
    Ensemble,
    Estimates,
    Evaluation,
    InvalidEstimatesError,
    InvalidFileError,
    MaskVal,
    Mesh,
    Needs,
    Pose,
    TemporalConsistency,
    bop,
    certified_threshold,
    conformal_threshold,
    recall_curve,
    silhouette,
    uncertainty,
)
from maskval.methods.ensemble import ENSEMBLE_MAXIMUM_M, ENSEMBLE_MAXIMUM_RAD
from maskval.methods.view_agreement import BASELINE_M, MAXIMUM_M
from maskval.symmetry import right_angle_symmetries
from tests.maskval import bop_dataset, shapes
from tests.maskval.shapes import VGA

SHEET = shapes.square()
PAPER_DISTANCE_M = 0.6  # of the cell's camera to the part


def estimates(X_CO: Pose, X_BC: Pose | None = None) -> Estimates:
    mask = silhouette(SHEET, X_CO, VGA).mask
    return Estimates(VGA, SHEET, mask[None], ((X_CO,),), np.ones(1), X_BC=X_BC)


def cut_off(share: float) -> Estimates:
    """A sheet of 100 px whose rightmost columns, this share of it, are outside of the image; its mask is exact."""
    return estimates(Pose.from_translation((0.32 + (share - 0.5) * 0.1, 0.0, 0.6)))


@pytest.mark.parametrize("share", [0.1, 0.3, 0.7, 0.95])
def test_without_visibility_no_share_outside_of_the_image_matters(share: float) -> None:
    made = cut_off(share)
    assert MaskVal(alpha=1.0)(made) == pytest.approx([share], abs=0.011)  # a column of 100
    assert METHODS["maskval-no-visibility"]()(made).tolist() == [0.0]


def test_maskval_looks_at_the_visibility_below_the_papers_eighty_percent() -> None:
    below, above = cut_off(0.22), cut_off(0.18)
    for method in (MaskVal(), METHODS["maskval"]()):
        assert method(below) == pytest.approx([0.22], abs=0.011)
        assert method(above).tolist() == [0.0]
    for made, least, most in ((below, 0.2, 0.23), (above, 0.0, 0.0)):
        (u,) = uncertainty(SHEET, made.poses[0], made.masks, VGA).u
        assert least <= u <= most


def brick(size: float, off: float) -> Mesh:
    """A brick with two points inside, of which one is off along x by a share of the brick's diameter."""
    corners = shapes.cube(1.0)
    brick = corners.vertices * (0.5, 0.6, 0.7) * size
    diameter = size * math.sqrt(0.5**2 + 0.6**2 + 0.7**2)
    inside = np.array([[0.1 * size + off * diameter, 0, 0], [-0.1 * size, 0, 0]])
    return Mesh(np.concatenate((brick, inside)), corners.faces)


@pytest.mark.parametrize("size", [0.05, 0.5, 8.0])
def test_vertices_are_the_same_up_to_a_millionth_of_the_diameter(size: float) -> None:
    # Only the half turn about x leaves the two points where they are.
    assert len(right_angle_symmetries(brick(size, 0.9e-6))) == 3
    assert len(right_angle_symmetries(brick(size, 1.1e-6))) == 1


@pytest.mark.parametrize("maximum", [math.inf, math.nan])
def test_an_ensemble_needs_a_maximum_that_is_finite(maximum: float) -> None:
    with pytest.raises(InvalidEstimatesError, match=r"0 <= minimum < maximum, but are 0\.0 and"):
        Ensemble("add", 0.0, maximum)


def test_the_scales_of_disagreements_are_the_papers_five_centimetres_and_half_a_turn() -> None:
    assert ENSEMBLE_MAXIMUM_M == MAXIMUM_M == 0.05
    assert math.pi == ENSEMBLE_MAXIMUM_RAD
    assert TemporalConsistency.u_grasp * MAXIMUM_M == pytest.approx(0.015)  # the paper's error of a good pose


def test_two_views_are_apart_by_nine_degrees_at_the_papers_distance() -> None:
    assert int(math.degrees(math.atan(BASELINE_M / PAPER_DISTANCE_M))) == 9


@pytest.mark.parametrize(("apart_m", "u"), [(BASELINE_M - 1e-6, 1.0), (BASELINE_M + 1e-6, 0.2)])
def test_by_default_views_at_least_the_baseline_apart_are_compared_on_the_papers_scale(
    apart_m: float, u: float
) -> None:
    method = TemporalConsistency()
    shift = Pose.from_translation((apart_m, 0, 0))
    method(estimates(Pose.from_translation((0, 0, 0.6)), Pose.identity()))
    seen = Pose.from_translation((0.2 * MAXIMUM_M, 0, 0.6))
    assert method(estimates(shift.inverse() @ seen, shift)) == pytest.approx([u], abs=1e-9)


def test_a_view_from_exactly_the_baseline_counts_and_one_without_a_baseline_always() -> None:
    for baseline_m in (0.125, 0.0):
        method = TemporalConsistency(baseline_m=baseline_m)
        ahead, shift = Pose.from_translation((0, 0, 0.5)), Pose.from_translation((baseline_m, 0, 0))
        method(estimates(ahead, Pose.identity()))
        assert method(estimates(shift.inverse() @ ahead, shift)).tolist() == [0.0]


def test_a_method_that_says_nothing_needs_one_estimator_and_no_more() -> None:
    least = Needs()
    assert (least.estimators, least.depth, least.X_BC) == (1, False, False)
    assert Needs.together() == least


def test_a_pose_exactly_at_a_threshold_is_kept_by_its_certificate() -> None:
    # One bad pose among 2,000: the bound for one of two thresholds is 0.3 %.
    bad = np.arange(2000) == 7
    found = certified_threshold(np.full(2000, 0.5), bad, grid=[0.25, 0.5])
    assert found is not None
    assert found[:3] == (0.5, 2000, 1)


def test_conformal_risk_is_of_the_poses_and_one_more() -> None:
    # The 50th of 99 is bad, and one to come: 2 of 100 are more than 1.99 %.
    u, bad = np.arange(99) / 99, np.arange(99) == 49
    assert conformal_threshold(u, bad, maximum_risk=0.02) == u[98]
    assert conformal_threshold(u, bad, maximum_risk=0.0199) == u[48]


def test_where_no_threshold_reaches_the_ap_nothing_is_recalled() -> None:
    bad = Evaluation(2, [0, 1], [0, 1], [0.5, 0.6], [0.1, 0.2], [0, 1], [1, 1])
    curve = recall_curve(bad, np.array([0.01, 0.02]))
    assert curve.u == (None, None)
    assert (curve.ar.tolist(), curve.aru.tolist(), curve.auc) == ([0, 0], [0, 0], 0)


def test_a_rotation_given_alone_is_about_the_origin() -> None:
    for X in (Pose.from_quaternion_wxyz((0, 1, 0, 0)), Pose.from_rotvec((np.pi, 0, 0))):
        assert X.translation.tolist() == [0, 0, 0]


def test_what_is_left_of_a_quaternions_norm_is_no_stretch() -> None:
    for norm in (1 - 9e-7, 1 + 9e-7):
        R = Pose.from_quaternion_wxyz(norm * np.array([0.5, 0.5, 0.5, 0.5])).rotation
        np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0, atol=1e-14)


def test_a_list_at_a_vertex_of_a_model_is_refused(tmp_path) -> None:
    path = tmp_path / "file"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    path.write_text(
        f"ply\nformat ascii 1.0\nelement vertex 1\n{axes}property list uchar int near\nend_header\n0 0 0 0\n"
    )
    with pytest.raises(InvalidFileError, match="file: expected no list 'near' in the element 'vertex'"):
        bop.read_model(path)


@pytest.mark.parametrize("number", [2**63, -(2**63) - 1])
def test_whole_numbers_are_of_64_bits(tmp_path, number: int) -> None:
    path = tmp_path / "file"
    path.write_text(f'[{{"im_id": 1, "inst_count": 1, "obj_id": 1, "scene_id": {number}}}]')
    with pytest.raises(InvalidFileError, match="scene_id: expected a whole number, but found"):
        bop.read_targets(path)


def test_the_warning_of_inexact_rotations_points_to_where_the_file_was_asked_for(tmp_path) -> None:
    path = tmp_path / "results.csv"
    path.write_text("1,2,3,1.0,1.004 0 0 0 1 0 0 0 1,1 2 3,-1\n")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        bop.read_results(path)
    assert [one.filename for one in told] == [__file__]


def test_an_image_without_an_object_has_no_masks_of_the_size_of_the_scenes_first_one(tmp_path) -> None:
    bop_dataset.write(tmp_path)
    scene = tmp_path / "test" / f"{bop_dataset.SCENE:06d}"
    alone = bop.read_scene_gt(scene / "scene_gt.json")[0][:1]
    bop.write_scene_gt(scene / "scene_gt.json", {0: alone})
    bop.mask_path(scene, 0, 1).unlink()
    masks = bop.SceneMasks(bop.Dataset(tmp_path)).masks(bop.ImageObject(bop_dataset.SCENE, 0, bop_dataset.STAR))
    assert (len(masks), masks.height, masks.width) == (0, 240, 320)
