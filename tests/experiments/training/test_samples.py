"""What the networks are shown, and what they should say of it."""

import numpy as np
import pytest

from experiments.training.detector_samples import DetectorSamples, stored_pictures, targets
from experiments.training.lighting import relit
from experiments.training.pictures import SeenPart, TruePicture, looks_alike
from experiments.training.pose_samples import PoseSamples, StoredCrop, stored_crops
from maskval import Camera, Pose, silhouette
from sim.learned.coordinates import ObjectCoordinates
from sim.learned.grouping import VOTE_SCALE, instances
from sim.model.parts import load_part

CAMERA = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
ANTENNA, HANDLE = load_part("antenna"), load_part("handle")
POSES = tuple(Pose.from_rotvec((2.8, 0.3, turn), (x, y, 0.55)) for turn, x, y in ((0.3, -0.15, 0.0), (1.5, 0.1, 0.05)))


def picture(*poses: Pose, visibility: float = 1.0) -> TruePicture:
    """White parts on black."""
    masks = [silhouette(ANTENNA.part.mesh, X_CO, CAMERA, pixel_center=0.5).mask for X_CO in poses]
    rgb = np.repeat(255 * np.any(masks, axis=0)[..., None], 3, axis=2).astype(np.uint8)
    return TruePicture(rgb, CAMERA, tuple(SeenPart(X, visibility, mask) for X, mask in zip(poses, masks, strict=True)))


def samples(size: int = 4, seed: int = 0) -> PoseSamples:
    crops = stored_crops([picture(*POSES)])
    return PoseSamples(crops, ANTENNA.part.mesh, (Pose.identity(),), size=size, seed=seed)


def test_the_parts_that_are_learned_from_are_those_of_which_enough_is_seen() -> None:
    assert len(stored_crops([picture(*POSES), picture(POSES[0])])) == 3
    assert stored_crops([picture(*POSES, visibility=0.2)]) == []


def test_a_batch_is_a_function_of_seed_and_step() -> None:
    same, again, later, other = samples().batch(3), samples().batch(3), samples().batch(4), samples(seed=1).batch(3)
    for name in ("images", "coordinates", "visible", "head"):
        one = getattr(same, name)
        assert one.dtype == np.float32
        assert np.array_equal(one, getattr(again, name))
        assert not np.array_equal(one, getattr(later, name))
        assert not np.array_equal(one, getattr(other, name))


def test_the_visible_pixels_are_where_the_crop_shows_the_part() -> None:
    batch = samples(size=16).batch(0)
    bright = batch.images.mean(axis=1).reshape(16, 32, 2, 32, 2).mean(axis=(2, 4))  # of white parts, lit differently
    for image, visible in zip(bright, batch.visible > 0, strict=True):
        patch_free = image[visible].mean()
        assert visible.sum() > 30
        assert patch_free > image[~visible].mean()


def test_coordinates_belong_to_points_that_project_to_their_pixel() -> None:
    batch = samples(size=8).batch(1)
    coordinates = ObjectCoordinates.of(ANTENNA.part.mesh)
    for maps, visible in zip(batch.coordinates[:, 0], batch.visible > 0, strict=True):
        v, u = np.nonzero(visible)
        points_O = coordinates.points_O(maps[:, v, u].T.astype(np.float64))
        pixels = np.stack((u, v), axis=1) + 0.5
        # The camera of a crop of 32 pixels is not told here: a general projection is fitted, then its errors.
        P = _projection(points_O, pixels)
        seen = np.column_stack((points_O, np.ones(len(points_O)))) @ P.T
        assert np.abs(seen[:, :2] / seen[:, 2:] - pixels).max() < 0.01


def _projection(points: np.ndarray, pixels: np.ndarray) -> np.ndarray:
    """The direct linear transform: P with s (u, v, 1) = P (x, y, z, 1)."""
    rows = []
    scale = np.abs(points).max()
    for (x, y, z), (u, v) in zip(points / scale, pixels / 32.0, strict=True):
        p = np.array((x, y, z, 1.0))
        rows += [np.concatenate((p, np.zeros(4), -u * p)), np.concatenate((np.zeros(4), p, -v * p))]
    P = np.linalg.svd(np.array(rows))[2][-1].reshape(3, 4)
    P[:2] *= 32.0
    P[:, :3] /= scale
    return P


def test_the_head_is_the_place_and_depth_of_the_boxs_middle() -> None:
    crops = stored_crops([picture(POSES[0])])
    batch = PoseSamples(crops, ANTENNA.part.mesh, (Pose.identity(),), size=8, seed=0).batch(0)
    coordinates = ObjectCoordinates.of(ANTENNA.part.mesh)
    z = POSES[0].apply(coordinates.center_O)[2]
    assert (batch.visible.sum(axis=(1, 2)) > 0).any()
    for head, visible in zip(batch.head, batch.visible, strict=True):
        # From the depth follows the side of the crop in pixels of the image, hence the part's size in the crop.
        side_px = 600.0 * coordinates.diameter / z * np.exp(head[2])
        area_px = visible.sum() * (side_px / 32) ** 2
        true_px = silhouette(ANTENNA.part.mesh, POSES[0], CAMERA, pixel_center=0.5).mask.sum()
        assert area_px <= true_px * 1.05
        assert np.abs(head[:2]).max() < 0.5
    assert max(batch.visible.sum(axis=(1, 2)) > 0) == 1


def test_a_symmetric_part_has_the_coordinates_of_all_poses_that_look_alike() -> None:
    alike = looks_alike(HANDLE)
    assert len(alike) == 2
    mask = silhouette(HANDLE.part.mesh, POSES[0], CAMERA, pixel_center=0.5).mask
    seen = TruePicture(np.zeros((480, 640, 3), dtype=np.uint8), CAMERA, (SeenPart(POSES[0], 1.0, mask),))
    batch = PoseSamples(stored_crops([seen]), HANDLE.part.mesh, alike, size=2, seed=0).batch(0)
    one, other = batch.coordinates[0]
    v, u = np.nonzero(batch.visible[0])
    # Half a turn about z through the box's middle: x and y change their signs, z stays.
    assert other[:2, v, u] == pytest.approx(-one[:2, v, u], abs=1e-4)
    assert other[2, v, u] == pytest.approx(one[2, v, u], abs=1e-4)


def test_a_stored_crop_shows_more_than_is_cut_of_it() -> None:
    (crop,) = stored_crops([picture(POSES[0])])
    assert isinstance(crop, StoredCrop)
    border = np.concatenate((crop.mask[0], crop.mask[-1], crop.mask[:, 0], crop.mask[:, -1]))
    assert not border.any()
    assert crop.image.shape == (*crop.mask.shape, 3)


def test_light_changes_but_stays_between_black_and_white() -> None:
    ramp = np.repeat(np.arange(256, dtype=np.uint8).reshape(16, 16, 1), 3, axis=2)
    lit = [relit(ramp, np.random.default_rng(seed)) for seed in range(20)]
    assert min(image.min() for image in lit) >= 0
    assert max(image.max() for image in lit) <= 1
    assert np.std([image.mean() for image in lit]) > 0.05


def test_the_detectors_targets_group_into_the_parts_again() -> None:
    (stored,) = stored_pictures([picture(*POSES)])
    part, center, votes = targets(stored.numbers)
    logits = np.where(part > 0, 8.0, -8.0).astype(np.float32), (20 * center - 19).astype(np.float32)
    found = instances(*logits, votes, (480, 640))
    assert len(found) == 2
    for X_CO in POSES:
        mask = silhouette(ANTENNA.part.mesh, X_CO, CAMERA, pixel_center=0.5).mask
        assert max((one.mask & mask).sum() / (one.mask | mask).sum() for one in found) > 0.93
    v, u = np.nonzero(stored.numbers == 1)
    aims = np.stack((u, v)) + VOTE_SCALE * votes[:, v, u]
    assert aims == pytest.approx(np.repeat([[u.mean()], [v.mean()]], len(u), axis=1), abs=1e-3)


def test_what_is_hardly_visible_does_not_count_for_the_detector() -> None:
    (stored,) = stored_pictures([picture(POSES[0], visibility=0.05)])
    part, center, votes = targets(stored.numbers)
    assert set(np.unique(part)) == {-1.0, 0.0}
    assert not center.any()
    assert not votes.any()


def test_the_detectors_batches_are_mirrored_at_random() -> None:
    batches = DetectorSamples(stored_pictures([picture(POSES[0])]), size=16, seed=0)
    batch = batches.batch(0)
    assert batch.images.shape == (16, 3, 240, 320)
    corners = {
        (int(np.nonzero(part > 0)[1].mean() > 80), int(np.nonzero(part > 0)[0].mean() > 60)) for part in batch.part
    }
    assert {left for left, _ in corners} == {0, 1}
    again = batches.batch(0)
    assert np.array_equal(batch.images, again.images)
