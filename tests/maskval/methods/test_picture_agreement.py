from dataclasses import replace

import numpy as np
import pytest
import trimesh

from maskval import Camera, Estimates, InvalidEstimatesError, Mesh, Pose, needs_of
from maskval.methods.picture_agreement import RenderNcc
from maskval.rendering.depth import depth_image

CAMERA = Camera(300.0, 300.0, 80.0, 60.0, 160, 120)
BALL = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
MESH = Mesh(BALL.vertices, BALL.faces)
BOX = trimesh.creation.box((0.10, 0.06, 0.04))
X_CO = Pose.from_translation((0.01, -0.01, 0.4))


def picture_of_ball(light: np.ndarray, gain: float, offset: float) -> np.ndarray:
    """A matt ball, lit from a direction, by its equation: the normal at a point is the way from the centre."""
    depth = depth_image(MESH, X_CO, CAMERA, pixel_center=0.5).astype(np.float64)
    v, u = np.indices(depth.shape) + 0.5
    points = np.stack(((u - CAMERA.cx) * depth / CAMERA.fx, (v - CAMERA.cy) * depth / CAMERA.fy, depth), axis=-1)
    shading = (points - X_CO.translation) / 0.05 @ light
    grey = np.where(depth > 0, gain * shading + offset, 20.0)
    return np.repeat(np.clip(np.rint(grey), 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def estimates(rgb: np.ndarray | None, *poses: Pose, mesh: Mesh = MESH) -> Estimates:
    masks = np.zeros((len(poses), 120, 160), dtype=np.bool_)
    return Estimates(CAMERA, mesh, masks, (poses,), np.ones(len(poses)), 0.5, rgb=rgb)


@pytest.mark.parametrize("light", [(0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (-0.5, 0.5, -0.7)])
@pytest.mark.parametrize(("gain", "offset"), [(80.0, 120.0), (30.0, 60.0)])
def test_the_true_pose_explains_a_matt_surface_under_any_light(
    light: tuple[float, float, float], gain: float, offset: float
) -> None:
    (u,) = RenderNcc()(estimates(picture_of_ball(np.array(light), gain, offset), X_CO))
    assert u < 0.02


def test_a_wrong_pose_is_less_certain_than_the_true_one() -> None:
    rgb = picture_of_ball(np.array((0.3, 0.2, -0.9)), 80.0, 120.0)
    poses = [Pose.from_translation(X_CO.translation + (shift, 0.0, 0.0)) for shift in (0.0, 0.01, 0.02, 0.04)]
    u = RenderNcc()(estimates(rgb, *poses))
    assert (u[1:] > u[0] + 0.1).all()  # it need not rise further: a border in the picture is explained by a light, too


def test_it_is_the_correlation_of_grey_level_and_shading_of_a_surface_of_three_planes() -> None:
    """A box that shows three faces has three normals: R² is the share of variance between the faces."""
    mesh, X = Mesh(BOX.vertices, BOX.faces), Pose.from_rotvec((0.6, 0.5, 0.2), (0.0, 0.0, 0.4))
    rng = np.random.default_rng(0)
    rgb = np.repeat(rng.integers(0, 256, (120, 160, 1), dtype=np.uint8), 3, axis=2)
    (u,) = RenderNcc()(estimates(rgb, X, mesh=mesh))
    # Noise of n pixels and 4 terms: R² is Beta(3/2, (n − 4)/2), its mean 3 / (n − 1), n about 4000.
    assert 1 - u < 0.08


def test_what_covers_nothing_of_the_image_or_shows_no_contrast_is_as_uncertain_as_can_be() -> None:
    rgb = np.full((120, 160, 3), 90, dtype=np.uint8)
    beside, behind = Pose.from_translation((2.0, 0.0, 0.4)), Pose.from_translation((0.0, 0.0, -0.4))
    assert RenderNcc()(estimates(rgb, X_CO, beside, behind)) == pytest.approx([1.0, 1.0, 1.0])


def test_it_asks_for_the_picture_and_says_so_without() -> None:
    assert needs_of(RenderNcc()).rgb
    with pytest.raises(InvalidEstimatesError, match="render-ncc needs the picture"):
        RenderNcc()(estimates(None, X_CO))


@pytest.mark.parametrize(
    "rgb", [np.zeros((120, 160), np.uint8), np.zeros((160, 120, 3), np.uint8), np.zeros((120, 160, 3), np.float64)]
)
def test_a_picture_of_another_size_or_kind_is_refused(rgb: np.ndarray) -> None:
    with pytest.raises(InvalidEstimatesError, match=r"rgb must be uint8 of shape \(120, 160, 3\)"):
        replace(estimates(None, X_CO), rgb=rgb)
