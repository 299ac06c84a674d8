"""With perfect maps the whole way from a crop to a pose must be exact: half a pixel of bias would cost 5 mm."""

import numpy as np
import pytest

from cell.interfaces import PoseEstimate
from maskval import Camera, Pose, mdd, mssd
from sim.learned.coordinates import CROP_SIZE, Maps, ObjectCoordinates, estimate_of
from sim.learned.crops import CropView, Square
from sim.model.parts import PartModel, load_part
from tests.sim.learned.perfect import CAMERA, SKEWED, UNSURE, maps_of, mask_of


def looked_at(model: PartModel, X_CO: Pose, camera: Camera, weight: float = 0.01, **changes: float) -> PoseEstimate:
    view = CropView(Square.around(mask_of(model.part.mesh, X_CO, camera)), camera, CROP_SIZE)
    maps = maps_of(model.part.mesh, X_CO, view, **changes)
    return estimate_of(maps, view, ObjectCoordinates.of(model.part.mesh), weight)


@pytest.mark.parametrize("part", ["antenna", "handle"])
@pytest.mark.parametrize("camera", [CAMERA, SKEWED], ids=["square pixels", "skewed"])
def test_perfect_maps_give_the_true_pose(part: str, camera: Camera) -> None:
    model, rng = load_part(part), np.random.default_rng(0)
    for _ in range(5):
        X_CO = Pose.from_rotvec(rng.normal(size=3), (*rng.uniform(-0.08, 0.08, 2), rng.uniform(0.4, 0.7)))
        found = looked_at(model, X_CO, camera)
        alike = ObjectCoordinates.of(model.part.mesh).alike
        assert len(alike) == (2 if part == "handle" else 1)
        assert mssd(found.X_CO_est, X_CO, model.part.mesh.vertices, alike) < 0.1e-3  # m; maps are 32-bit numbers


def test_correspondences_are_those_of_the_image(antenna: PartModel) -> None:
    X_CO = Pose.from_rotvec((0.4, -0.7, 0.9), (0.06, -0.05, 0.55))
    points = looked_at(antenna, X_CO, CAMERA).correspondences
    assert points is not None
    assert len(points) > 100
    assert np.abs(points.errors_px(X_CO, CAMERA)).max() < 0.01


def test_a_sigma_in_pixels_is_the_networks_in_half_sizes_at_the_parts_own_depth(antenna: PartModel) -> None:
    mesh = antenna.part.mesh
    X_CO = Pose.from_rotvec((0.4, -0.7, 0.9), (0.06, -0.05, 0.55))
    points = looked_at(antenna, X_CO, CAMERA, log_scale=np.log(0.1)).correspondences
    assert points is not None
    half_size = (mesh.vertices.max(axis=0) - mesh.vertices.min(axis=0)).mean() / 2
    # The crop is a little larger than the part's diameter, for which its side is taken here.
    assert points.sigma_px == pytest.approx(0.1 * half_size * 600 / 0.55, rel=0.5)


def test_the_heads_depth_decides_where_correspondences_hardly_count(antenna: PartModel) -> None:
    mesh, X_CO = antenna.part.mesh, Pose.from_rotvec((0.1, 0.2, 0.3), (0.02, 0.03, 0.5))
    view = CropView(Square.around(mask_of(mesh, X_CO, CAMERA)), CAMERA, CROP_SIZE)
    maps = maps_of(mesh, X_CO, view)
    off = maps.head + np.array((0.0, 0.0, np.log(1.1), -4.0), dtype=np.float32)
    wrong = Maps(maps.coordinates, maps.log_scale, maps.visible, off)
    coordinates = ObjectCoordinates.of(mesh)
    center_z = X_CO.apply(coordinates.center_O)[2]
    depths = [
        estimate_of(wrong, view, coordinates, weight).X_CO_est.apply(coordinates.center_O)[2] / center_z
        for weight in (1e-9, 1e3)
    ]
    assert depths[0] == pytest.approx(1.1, rel=1e-3)
    assert depths[1] == pytest.approx(1.0, rel=1e-3)


def test_a_crop_that_shows_nothing_gets_the_heads_place(antenna: PartModel) -> None:
    mesh, X_CO = antenna.part.mesh, Pose.from_rotvec((0.1, 0.2, 0.3), (0.02, 0.03, 0.5))
    view = CropView(Square.around(mask_of(mesh, X_CO, CAMERA)), CAMERA, CROP_SIZE)
    maps = maps_of(mesh, X_CO, view)
    blind = Maps(maps.coordinates, maps.log_scale, np.full_like(maps.visible, UNSURE), maps.head)
    found = estimate_of(blind, view, ObjectCoordinates.of(mesh), 0.01)
    center_O = ObjectCoordinates.of(mesh).center_O
    assert found.X_CO_est.apply(center_O) == pytest.approx(X_CO.apply(center_O), abs=1e-5)
    assert found.correspondences is not None
    assert len(found.correspondences) == 0


def test_networks_that_see_a_symmetric_part_turned_by_its_symmetry_give_the_same_pose(handle: PartModel) -> None:
    mesh, rng = handle.part.mesh, np.random.default_rng(2)
    coordinates = ObjectCoordinates.of(mesh)
    for _ in range(5):
        X_CO = Pose.from_rotvec((*rng.normal(size=2) * 0.3, rng.uniform(-3, 3)), (0.02, 0.03, 0.5))
        view = CropView(Square.around(mask_of(mesh, X_CO, CAMERA)), CAMERA, CROP_SIZE)
        one, other = (
            estimate_of(maps_of(mesh, X_CO @ turn, view), view, coordinates, 0.01) for turn in coordinates.alike
        )
        assert mdd(one.X_CO_est, other.X_CO_est, mesh.vertices) < 0.1e-3
        for found in (one, other):
            assert found.correspondences is not None
            assert np.abs(found.correspondences.errors_px(found.X_CO_est, CAMERA)).max() < 0.01
