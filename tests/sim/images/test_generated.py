from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose, mdd
from sim.images.generated import Recipe, clutter_shapes, draw_nearest, make_image
from sim.instance_ids import NO_INSTANCE
from sim.model.parts import PartModel
from sim.networks.ground_truth import FrameTruth
from sim.networks.image_estimates import ImageEstimates, estimate_image
from sim.networks.noise_model import PartNoise
from sim.networks.random_streams import Streams
from tests.round_noise import ROUND

CAMERA = Camera(600, 600, 320, 240, 640, 480)
SMALL = Camera(45, 45, 24, 18, 48, 36)
NOISE = ROUND
EXACT = replace(
    NOISE,
    pose=replace(NOISE.pose, lateral_mm=0.0, rotation_deg=0.0, outlier_probability=0.0),
    mask=replace(
        NOISE.mask, field_cells=0.0, box_share=0.0, leak_cells=0.0, drop_probability=0.0, miss_probability=0.0
    ),
)


def image(mesh: Mesh, number: int = 0, recipe: Recipe | None = None, camera: Camera = CAMERA, **key: object):
    streams = replace(Streams(seed=3, experiment=number, part_name="antenna"), **key)
    return make_image(mesh, camera, recipe or Recipe(), streams).truth


def estimates(truth: FrameTruth, noise: PartNoise = NOISE, number: int = 0) -> ImageEstimates:
    return estimate_image(truth, noise, Streams(3, number, "antenna"))


def nearest_bodies(bodies: list[tuple[Mesh, Pose]], camera: Camera, margin: int) -> NDArray[np.int64]:
    """Independent of the kernel: the body that a ray through each pixel meets first, by Möller and Trumbore."""
    v, u = np.mgrid[-margin : camera.height + margin, -margin : camera.width + margin] + 0.5
    rays = np.stack(((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, np.ones_like(u)), axis=-1)
    nearest, body = np.full(u.shape, np.inf), np.full(u.shape, NO_INSTANCE)
    for number, (mesh, X_CO) in enumerate(bodies):
        for a, b, c in X_CO.apply(mesh.vertices)[mesh.faces]:
            normal = np.cross(b - a, c - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                depth = (a @ normal) / (rays @ normal)  # the rays' z is 1
                points = depth[..., None] * rays
                sides = [(np.cross(q - p, points - p) @ normal) for p, q in ((a, b), (b, c), (c, a))]
                met = np.all([side >= 0 for side in sides], axis=0) & (depth > 0) & (depth < nearest)
            nearest[met], body[met] = depth[met], number
    return body


def test_an_image_is_a_function_of_seed_number_and_kind(antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    one, same = image(mesh, 7), image(mesh, 7)
    assert np.array_equal(one.instance_ids, same.instance_ids)
    assert all(np.array_equal(a.matrix, b.matrix) for a, b in zip(one.X_CO_true, same.X_CO_true, strict=True))
    for other in (image(mesh, 8), image(mesh, 7, seed=4), image(mesh, 7, part_name="handle")):
        assert not np.array_equal(one.instance_ids, other.instance_ids)


def test_images_keep_to_the_recipe(antenna: PartModel) -> None:
    recipe = Recipe(parts=(1, 3), clutter=(0, 2), distance=(0.5, 0.6))
    images = [image(antenna.part.mesh, number, recipe) for number in range(30)]
    assert {len(one.X_CO_true) for one in images} == {1, 2, 3}
    middles = np.array([X.apply(antenna.part.mesh.center) for one in images for X in one.X_CO_true])
    assert middles[:, 2].min() >= 0.5
    assert middles[:, 2].max() <= 0.6
    u, v = CAMERA.project(middles).T
    assert ((u > 0) & (u < 640) & (v > 0) & (v < 480)).all()


def test_numbers_and_visibilities_are_those_of_rays(handle: PartModel) -> None:
    mesh, margin = handle.part.mesh, 30
    truth = image(mesh, 11, Recipe(parts=(4, 4), clutter=(0, 0)), SMALL)
    bodies = [(mesh, X_CO) for X_CO in truth.X_CO_true]
    inside = (slice(margin, -margin), slice(margin, -margin))
    seen = nearest_bodies(bodies, SMALL, margin)[inside]
    assert np.count_nonzero(seen != truth.instance_ids) <= 2  # pixels whose ray meets an edge
    for part, body in enumerate(bodies):
        alone = nearest_bodies([body], SMALL, margin) != NO_INSTANCE
        whole = np.count_nonzero(alone)
        assert truth.visibility[part] == pytest.approx(np.count_nonzero(seen == part) / whole, abs=2 / whole)
        assert truth.in_view[part] == pytest.approx(np.count_nonzero(alone[inside]) / whole, abs=2 / whole)
    assert truth.visibility.min() < 0.9 * truth.in_view.max()  # something hides something


def test_the_nearer_body_is_seen_in_any_order_and_clutter_is_no_part() -> None:
    box = clutter_shapes()[0]
    near, far = Pose.from_translation((0.05, 0, 0.5)), Pose.from_translation((0, 0, 0.8))
    numbers, depth = draw_nearest([(box, far, 0), (box, near, 1)], CAMERA)
    for same, other in zip((numbers, depth), draw_nearest([(box, near, 1), (box, far, 0)], CAMERA), strict=True):
        assert np.array_equal(same, other)
    hidden, same = draw_nearest([(box, far, 0), (box, near, NO_INSTANCE)], CAMERA)
    assert np.array_equal(same, depth)
    # The boxes are 50 mm high and upright: their tops are 25 mm nearer than their middles.
    assert depth[numbers == 1].min() == pytest.approx(0.475, abs=1e-6)
    assert depth[numbers == 0].min() == pytest.approx(0.775, abs=1e-6)
    assert np.array_equal(depth == 0, numbers == NO_INSTANCE)
    assert set(np.unique(numbers)) == {NO_INSTANCE, 0, 1}
    assert np.array_equal(hidden == 0, numbers == 0)
    assert not (hidden == 1).any()


def test_without_errors_poses_are_true_and_masks_show_their_parts(antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    truth = image(mesh, 2)
    found = estimates(truth, EXACT)
    assert len(found.detections) >= 2
    for network in found.poses:
        for part, X_CO in zip(found.parts, network, strict=True):
            assert mdd(X_CO, truth.X_CO_true[part], mesh.vertices) < 1e-9
    for part, detection in zip(found.parts, found.detections, strict=True):
        agreeing = np.count_nonzero(detection.mask & truth.mask(part))
        assert agreeing / np.count_nonzero(detection.mask) > 0.9


def test_errors_are_a_function_of_the_image_and_differ_between_images_and_networks(antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    truth = image(mesh, 2)
    one, same, other = (estimates(truth, number=number) for number in (2, 2, 5))
    assert len(one.detections) == len(same.detections) >= 2
    for a, b in zip(one.detections, same.detections, strict=True):
        assert (a.score, a.mask.tobytes()) == (b.score, b.mask.tobytes())
    matrices = [np.array([[X.matrix for X in row] for row in found.poses]) for found in (one, same, other)]
    assert np.array_equal(matrices[0], matrices[1])
    assert not np.allclose(matrices[0][0], matrices[0][1])
    assert not np.allclose(matrices[0][0, 0], matrices[2][0, 0])


def test_a_false_alarm_gets_a_pose_even_if_it_shows_no_part(antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    noise = replace(EXACT, mask=replace(EXACT.mask, false_alarms_per_image=1.0))
    shown = []
    for number in range(12):
        truth = image(mesh, number, Recipe(parts=(1, 1), clutter=(0, 0)))
        found = estimates(truth, noise, number)
        assert len(found.detections) == len(found.parts) == len(found.poses[0]) == len(found.poses[1]) == 2
        assert found.parts[0] == 0
        shown.append(found.parts[1])
    assert shown.count(NO_INSTANCE) >= 6
