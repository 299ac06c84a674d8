import dataclasses
from itertools import product

import numpy as np
import pytest

from cell.arm.limits import PRESETS
from cell.layout import Belt, Layout
from cell.motion import Motion
from cell.viewpoints import REFINE_DISTANCE, SearchRun, refinement_view, search_run
from maskval import Pose
from tests.fakes import FakeStation, brick, on_belt, small_layout, turned

WIDE = Layout()
SHORT = Layout(belt=Belt(loading_length=0.5))  # a single view, 0.55 m * 640 px / 600 px = 0.587 m long, shows all of it


def pixels_of(layout: Layout, X_BC: Pose, points_B: np.ndarray) -> np.ndarray:
    return layout.camera.project(X_BC.inverse().apply(points_B))


def is_inside(layout: Layout, pixels: np.ndarray) -> np.ndarray:
    return ((pixels >= 0) & (pixels <= [layout.camera.width, layout.camera.height])).all(axis=-1)


@pytest.mark.parametrize("layout", [WIDE, SHORT], ids=["loaded 1.4 m", "loaded 0.5 m"])
def test_the_search_run_shows_every_point_of_the_loaded_belt(layout):
    belt = layout.belt
    x = belt.center_x + np.linspace(-belt.width / 2, belt.width / 2, 21)
    y = np.linspace(-belt.loading_length / 2, belt.loading_length / 2, 141)
    points_B = layout.X_WB.inverse().apply(np.array([(*xy, belt.top_z) for xy in product(x, y)]))
    shown = np.array([is_inside(layout, pixels_of(layout, X_BC, points_B)) for X_BC in search_run(layout).views])
    assert shown.shape[1] == 21 * 141
    assert shown.any(axis=0).all()


def test_a_part_of_200_mm_anywhere_on_the_middle_line_is_whole_in_some_view():
    views = search_run(WIDE).views
    middles = np.linspace(-0.6, 0.6, 121)  # ends 100 mm before those of the loaded belt
    whole = 0
    for y in middles:
        ends_B = WIDE.X_WB.inverse().apply(np.array([[0.68, y + end, WIDE.belt.top_z] for end in (-0.1, 0.1)]))
        whole += any(is_inside(WIDE, pixels_of(WIDE, X_BC, ends_B)).all() for X_BC in views)
    assert whole == 121


def test_the_search_run_begins_at_the_end_away_from_the_container_and_goes_along_the_belt():
    assert WIDE.container.center_y < 0
    points_W = np.array([WIDE.X_WB.apply(X_BC.translation) for X_BC in search_run(WIDE).views])
    assert len(points_W) >= 3
    assert points_W[0, 1] > 0
    assert (np.diff(points_W[:, 1]) < 0).all()
    np.testing.assert_allclose(points_W[:, 0], WIDE.belt.center_x)


def test_the_arm_reaches_every_view_and_the_camera_is_then_there():
    station = FakeStation(WIDE)
    motion = Motion(station, WIDE, PRESETS["ur-default"])
    views = search_run(WIDE).views
    assert len(views) >= 3
    for X_BC in (*views, *views[::-1]):
        assert motion.to_camera(X_BC) is None
        np.testing.assert_allclose(station.take_frame(frozenset()).X_BC.matrix, X_BC.matrix, atol=1e-9)


def test_view_goes_to_and_fro_and_looks_at_the_ends_once_per_turn():
    views = tuple(Pose.from_translation((x, 0, 0)) for x in range(4))
    run = SearchRun(views)
    visited = [int(run.view(index).translation[0]) for index in range(14)]
    assert visited == [0, 1, 2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0, 1]


def test_a_search_run_of_one_view_stays_there():
    run = search_run(SHORT)
    assert len(run.views) == 1
    assert [run.view(index) for index in range(3)] == [run.views[0]] * 3
    np.testing.assert_allclose(SHORT.X_WB.apply(run.views[0].translation)[:2], [SHORT.belt.center_x, 0.0])


def test_a_refinement_view_looks_down_on_the_estimated_middle_of_the_part_from_nearby():
    part, layout = brick(), small_layout()
    X_BO = on_belt(part, layout, turned(roll_deg=90, yaw_deg=40), y_W=0.3)
    X_BC = refinement_view(X_BO, part.mesh.center)
    np.testing.assert_allclose(X_BC.rotation[:, 2], [0, 0, -1], atol=1e-12)
    # The brick's middle is 10, 5 and 20 mm from its origin.
    middle_B = X_BO.apply(np.array([0.01, 0.005, 0.02]))
    np.testing.assert_allclose(pixels_of(layout, X_BC, middle_B), [32 / 2, 24 / 2])
    assert X_BC.inverse().apply(middle_B)[2] == pytest.approx(REFINE_DISTANCE)


def test_a_wider_camera_needs_fewer_views():
    camera = dataclasses.replace(WIDE.camera, fx=300.0, fy=300.0)
    assert len(search_run(Layout(camera=camera)).views) < len(search_run(WIDE).views)
