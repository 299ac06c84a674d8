"""Right poses are never suspected, however poor; each way to spoil all of them is named."""

import dataclasses

import numpy as np
import pytest

from maskval import Camera, Mesh, PackedMasks, Pose, silhouette
from maskval.plausibility.check import INSIDE, Finding, find_implausible
from maskval.plausibility.corrections import CORRECTIONS, View
from tests.maskval import shapes

CAMERA = Camera(300.0, 300.0, 160.5, 120.0, 320, 240)
X_CW = Pose.from_rotvec((2.0, 0.3, -0.4), (0.1, 0.2, 0.9))
# No turn maps it onto itself: its legs are 12, 8 and 5 cm long.
LEGS = np.diag((0.12, 0.08, 0.05, 1.0))[:, :3]
WEDGE = Mesh(LEGS - LEGS.mean(axis=0), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
MESHES = {"wedge": WEDGE, "cube": shapes.cube(0.08), "ring": Mesh(*shapes.torus(rows=24, columns=12))}


def turn(rng: np.random.Generator, angle: float) -> Pose:
    axis = rng.normal(size=3)
    return Pose.from_rotvec(angle * axis / np.linalg.norm(axis))


def right(count: int, seed: int, mesh: Mesh = WEDGE, error: str = "none") -> list[View]:
    """Views of one part each, whose poses are right, or poor in a way that poses of estimators are."""
    rng = np.random.default_rng(seed)
    views = []
    for _ in range(count):
        X_CO = Pose.from_translation((rng.uniform(-0.12, 0.12), rng.uniform(-0.1, 0.1), rng.uniform(0.5, 0.7))) @ turn(
            rng, rng.uniform(0, np.pi)
        )
        if error == "partly out of the frame":
            X_CO = Pose(X_CO.rotation, (rng.choice((-0.53, 0.53)) * X_CO.translation[2], 0.0, X_CO.translation[2]))
        mask = silhouette(mesh, X_CO, CAMERA, pixel_center=0.5).mask.copy()
        shift = rng.normal(size=3)
        estimates = {
            "1 cm off": Pose.from_translation(0.01 * shift / np.linalg.norm(shift)) @ X_CO,
            "3 cm off": Pose.from_translation(0.03 * shift / np.linalg.norm(shift)) @ X_CO,
            "half turned": X_CO @ turn(rng, np.pi),
            "of any rotation": Pose(turn(rng, rng.uniform(0, np.pi)).rotation, X_CO.translation),
        }
        if error == "60 % occluded":
            mask[:, : int(np.quantile(np.nonzero(mask)[1], 0.6))] = False
        views.append(View(mesh, (estimates.get(error, X_CO),), PackedMasks.pack(mask), CAMERA, X_CW))
    return views


def moved(views: list[View], change) -> list[View]:
    return [dataclasses.replace(view, poses=tuple(change(X) for X in view.poses)) for view in views]


def remasked(views: list[View], change) -> list[View]:
    return [dataclasses.replace(view, masks=PackedMasks.pack(change(view.masks.unpack()))) for view in views]


def found(views: list[View]) -> list[Finding]:
    return find_implausible(views, pixel_center=0.5)


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize(
    "error",
    ["none", "3 cm off", "half turned", "60 % occluded", "partly out of the frame", "of any rotation"],
)
def test_right_poses_are_not_suspected_however_poor(error: str, mesh: str) -> None:
    for count in (1, 3, 6, 20):
        views = right(count, seed=count, mesh=MESHES[mesh], error=error)
        assert len(views) == count
        assert found(views) == []


def quaternion(X: Pose, *order: int) -> Pose:
    return Pose.from_quaternion_wxyz(X.quaternion_wxyz[list(order)], X.translation)


MISTAKES = {
    "metres where millimetres are expected": lambda X: Pose(X.rotation, X.translation / 1000),
    "millimetres where metres are expected": lambda X: Pose(X.rotation, X.translation * 1000),
    "in the world frame": lambda X: X_CW.inverse() @ X,
    "of the camera in the object": Pose.inverse,
    "OpenGL's camera axes": lambda X: Pose(np.diag((1.0, -1, -1)), np.zeros(3)) @ X,
    "rotations are transposed": lambda X: Pose(X.rotation.T, X.translation),
    "quaternions x y z w were taken for w x y z": lambda X: quaternion(X, 1, 2, 3, 0),
    "quaternions w x y z were taken for x y z w": lambda X: quaternion(X, 3, 0, 1, 2),
}


@pytest.mark.parametrize("cause", MISTAKES)
@pytest.mark.parametrize("error", ["none", "1 cm off"])
def test_a_mistake_in_all_poses_is_certain_and_named(cause: str, error: str) -> None:
    odd = found(moved(right(40, seed=1, error=error), MISTAKES[cause]))
    assert odd[0].is_certain
    assert cause in odd[0].message
    assert not any(other in odd[0].message for other in MISTAKES if other != cause)


@pytest.mark.parametrize("cause", MISTAKES)
def test_three_poses_are_enough_for_a_warning(cause: str) -> None:
    odd = found(moved(right(3, seed=4), MISTAKES[cause]))
    assert odd
    assert cause in " ".join(one.message for one in odd)


def test_masks_written_row_by_row_are_named() -> None:
    def spoilt(masks: np.ndarray) -> np.ndarray:
        return masks.reshape(-1, 320, 240).transpose(0, 2, 1)

    odd = found(remasked(right(30, seed=2), spoilt))
    assert odd[0].is_certain
    assert "run lengths go row by row" in odd[0].message


def test_transposed_masks_are_named() -> None:
    views = remasked(right(30, seed=2), lambda masks: masks.transpose(0, 2, 1))
    turned = Camera.from_K(CAMERA.K, CAMERA.height, CAMERA.width)
    odd = found([dataclasses.replace(view, camera=turned) for view in views])
    assert odd[0].is_certain
    assert "masks are transposed" in odd[0].message


def test_a_camera_within_a_tenth_of_the_radius_of_the_middle_is_impossible() -> None:
    view = right(1, seed=0, mesh=MESHES["cube"])[0]
    radius = 0.04 * np.sqrt(3)
    for share, is_odd in ((0.99 * INSIDE, True), (1.01 * INSIDE, False)):
        near = dataclasses.replace(view, poses=(Pose.from_translation((0, 0, share * radius)),))
        assert any("middle of the object" in one.message and one.is_certain for one in found([near])) == is_odd


def test_one_pose_of_many_behind_the_camera_is_an_outlier() -> None:
    views = right(20, seed=3)
    views[0] = dataclasses.replace(views[0], poses=(Pose.from_translation((0, 0, -0.6)),))
    (one,) = found(views)
    assert one.message.startswith("1 of 20 poses lie behind the camera")
    assert not one.is_certain


def test_poses_of_another_image_meet_no_mask() -> None:
    views = moved(right(10, seed=5), lambda X: Pose.from_translation((-0.24, 0.12, 0.6)))
    corner = np.zeros((1, 240, 320), dtype=bool)
    corner[:, :20, 280:] = True
    (one,) = found(remasked(views, lambda masks: corner))
    assert one.is_certain
    assert one.message.startswith("10 of 10 silhouettes meet no mask of their object: wrong unit, frame")
    (few,) = found(remasked(views[:5], lambda masks: corner))
    assert not few.is_certain


def test_poses_without_masks_of_their_object_are_odd_from_half_on() -> None:
    none = np.zeros((0, 240, 320), dtype=bool)
    views = right(6, seed=6)
    assert found([*remasked(views[:2], lambda masks: none), *views[2:]]) == []
    (half,) = found([*remasked(views[:3], lambda masks: none), *views[3:]])
    assert (half.is_certain, half.message[:6]) == (False, "3 of 6")
    (whole,) = found(remasked(views, lambda masks: none))
    assert whole.is_certain
    assert "do obj_id and category_id" in whole.message


def test_undoing_a_mistake_gives_the_poses_back() -> None:
    views = right(4, seed=7)
    names = {cause: next(one for one in CORRECTIONS if cause in one.cause) for cause in MISTAKES}
    assert len({one.cause for one in names.values()}) == len(MISTAKES) == len(CORRECTIONS) - 2
    for cause, correction in names.items():
        for view, spoilt in zip(views, moved(views, MISTAKES[cause]), strict=True):
            undone = correction.undo(spoilt)
            assert undone is not None
            np.testing.assert_allclose(undone.poses[0].matrix, view.poses[0].matrix, rtol=0, atol=1e-12)


def test_of_many_views_few_are_kept_evenly_spread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maskval.plausibility.check.MOST_VIEWS", 32)
    # Were only the first 32 looked at, nothing would be odd.
    spoilt = moved(right(224, seed=9), MISTAKES["rotations are transposed"])
    (one,) = found([*right(32, seed=8), *spoilt])
    assert "rotations are transposed" in one.message
    assert any(f"mean IoU of {count} silhouettes" in one.message for count in range(16, 33))
