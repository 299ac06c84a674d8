"""The estimators with networks that say the truth about a frame."""

from pathlib import Path

import numpy as np
import pytest

from cell.interfaces import Detection, Frame, Image
from maskval import Pose, mask_iou, mdd
from sim.errors import NetworkError
from sim.learned import estimators, weights
from sim.learned.coordinates import CROP_SIZE, MAP_SIZE
from sim.learned.crops import CropView, Square
from sim.learned.estimators import LearnedMasks, LearnedPoses, learned_estimators
from sim.learned.weights import Manifest, TrainedNetworks
from sim.model.parts import PartModel
from tests.sim.learned.perfect import CAMERA, SURE, maps_of, mask_of
from tests.sim.learned.test_grouping import perfect_maps

POSES = tuple(Pose.from_rotvec((2.8, 0.3, turn), (x, y, 0.55)) for turn, x, y in ((0.3, -0.15, 0.0), (1.5, 0.1, 0.05)))
FRAME = Frame(0, 0.0, CAMERA, Pose.identity(), rgb=np.zeros((480, 640, 3), dtype=np.uint8))


@pytest.fixture
def networks(antenna: PartModel, monkeypatch: pytest.MonkeyPatch) -> TrainedNetworks:
    """Networks that know where the antennas lie, whatever they are shown."""
    mesh = antenna.part.mesh
    masks = [mask_of(mesh, X_CO, CAMERA) for X_CO in POSES]
    part, center, votes = perfect_maps(masks)
    detector = np.concatenate((part[None], center[None], votes))[None]
    maps = [
        maps_of(mesh, X, CropView(Square.around(mask), CAMERA, CROP_SIZE)) for X, mask in zip(POSES, masks, strict=True)
    ]
    stacked = tuple(
        np.stack([getattr(one, name) for one in maps]) for name in ("coordinates", "log_scale", "visible", "head")
    )

    def network(path: Path) -> weights.Network:
        size = estimators.DETECTOR_SIZE if path.stem == weights.DETECTOR else (CROP_SIZE, CROP_SIZE)

        def run(images: np.ndarray) -> tuple[np.ndarray, ...]:
            assert images.shape[1:] == (3, *size)
            assert images.dtype == np.float32
            return (detector,) if path.stem == weights.DETECTOR else stacked

        return run

    monkeypatch.setattr(weights, "open_network", network)
    box = np.concatenate((mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)))
    manifest = Manifest("antenna", tuple(box.tolist()), 0.02, 0.03, {"s1": 0.01, "s2": 0.01}, {})
    return TrainedNetworks(Path("nowhere"), manifest)


def test_perfect_networks_find_every_part_and_its_pose(networks: TrainedNetworks, antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    detector, (first, _) = learned_estimators(networks, antenna.part)
    found = detector.detect(FRAME)
    masks = [mask_of(mesh, X_CO, CAMERA) for X_CO in POSES]
    assert [max(mask_iou(one.mask, mask) for one in found) > 0.97 for mask in masks] == [True, True]
    # The fake maps belong to the crops around the true masks.
    poses = first.estimate(FRAME, [Detection(mask, 1.0) for mask in masks])
    for pose, X_CO in zip(poses, POSES, strict=True):
        assert mdd(pose.X_CO_est, X_CO, mesh.vertices) < 0.1e-3
        assert pose.correspondences is not None
        assert np.abs(pose.correspondences.errors_px(X_CO, CAMERA)).max() < 0.01


def test_they_read_rgb_and_take_the_time_that_was_measured(networks: TrainedNetworks, antenna: PartModel) -> None:
    detector, poses = learned_estimators(networks, antenna.part)
    assert detector.images == poses[0].images == frozenset({Image.RGB})
    assert (detector.inference_time, poses[0].inference_time) == (0.02, 0.03)
    assert LearnedMasks(networks, inference_time=0.1).inference_time == 0.1
    assert LearnedPoses(networks, "s2", antenna.part, inference_time=0.2).inference_time == 0.2


def test_no_detections_need_no_network(networks: TrainedNetworks, antenna: PartModel) -> None:
    assert LearnedPoses(networks, "s1", antenna.part).estimate(FRAME, []) == []


def test_networks_of_another_part_are_refused(networks: TrainedNetworks, handle: PartModel) -> None:
    with pytest.raises(NetworkError, match=r"nowhere: expected networks of a part with the box .*`graspcell train`"):
        learned_estimators(networks, handle.part)


def test_unlikely_instances_are_left_out(
    networks: TrainedNetworks, antenna: PartModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    detector, _ = learned_estimators(networks, antenna.part)
    monkeypatch.setattr(estimators, "LEAST_SCORE", 1.0 / (1.0 + np.exp(-SURE)))  # above peak times pixels
    assert detector.detect(FRAME) == []


def test_a_crop_is_twice_as_fine_as_its_maps() -> None:
    assert CROP_SIZE == 2 * MAP_SIZE
