"""Every disturbance does what its physics says, and nothing else."""

from contextlib import closing
from dataclasses import fields

import numpy as np
import pytest

from cell.interfaces import Frame
from cell.layout import Belt, Layout
from maskval import Camera as Pinhole
from maskval import Pose, silhouette
from sim.errors import ConditionsError
from sim.instance_ids import NO_INSTANCE, PIXEL_CENTER
from sim.model.conditions import RANGES, UNDISTURBED, Conditions
from sim.model.parts import PartModel
from sim.networks.estimators import make_estimators
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams
from sim.runtime.episode import belt_under, starting_poses
from sim.runtime.station import SimStation
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera
from tests.sim.conftest import on_belt, standing

X = Layout().belt.center_x
GRAVITY = 9.81

Images = tuple[np.ndarray, np.ndarray, np.ndarray]


def world_of(antenna: PartModel, **knobs: object) -> World:
    """A world with one antenna on its foot in the first search view."""
    world = World(Layout(), antenna, 1, Conditions(**knobs))
    world.reset([on_belt(antenna, X, 0.40, standing(antenna))])
    return world


def images(world: World) -> Images:
    """RGB, depth and instance ids."""
    with closing(WristCamera(world)) as camera:
        camera.rgb()
        return camera.rgb(), camera.depth(), camera.instance_ids([world.X_CO(0)])


def seen_frame(world: World) -> tuple[Frame, LatestTruth]:
    latest_truth = LatestTruth()
    return SimStation(world, WristCamera(world), latest_truth).take_frame(frozenset()), latest_truth


def estimated(world: World, model: PartModel) -> tuple[Frame, Pose]:
    """A frame, and where the exact networks see the antenna: X_CO_est."""
    frame, latest_truth = seen_frame(world)
    masks, (network, _) = make_estimators(
        "oracle", latest_truth, model.part, load_noise("antenna"), Streams(0, 0, "antenna")
    )
    (X_CO_est,) = network.estimate(frame, masks.detect(frame))
    return frame, X_CO_est


@pytest.fixture(scope="module")
def undisturbed(antenna: PartModel) -> Images:
    return images(world_of(antenna))


def test_light_scales_the_picture_and_changes_no_depth_or_mask(antenna: PartModel, undisturbed: Images) -> None:
    rgb, depth, numbers = undisturbed
    dim = images(world_of(antenna, light=0.5))
    belt = numbers == NO_INSTANCE
    belt[:100], belt[380:] = False, False  # the rails shine, and a grey level ends at 255
    assert belt.sum() > 100_000
    # Half the light is half the grey level. Either picture rounds by half of one three times: in the pass of the lamp
    # that throws shadows, in that of the others, and in the mean of the samples.
    assert np.abs(dim[0][belt] - 0.5 * rgb[belt]).max() <= (1.0 + 0.5) * 3 * 0.5
    assert np.array_equal(dim[1], depth)
    assert np.array_equal(dim[2], numbers)


def test_reflections_show_the_part_mirrored_in_the_belt_and_change_no_depth_or_mask(
    antenna: PartModel, undisturbed: Images
) -> None:
    rgb, depth, numbers = undisturbed
    mirrored = images(world_of(antenna, reflections=0.8))
    changed = np.abs(mirrored[0].astype(int) - rgb).max(axis=2) > 20
    assert changed[numbers == NO_INSTANCE].sum() > 1000
    assert np.array_equal(mirrored[1], depth)
    assert np.array_equal(mirrored[2], numbers)


def test_the_picture_is_the_true_cameras(antenna: PartModel) -> None:
    world = world_of(antenna, focal_error_percent=3.0, principal_point_error_px=(12.0, -7.0))
    believed = world.layout.camera
    true = Pinhole(believed.fx * 1.03, believed.fy * 1.03, believed.cx + 12.0, believed.cy - 7.0, 640, 480)
    numbers = WristCamera(world).instance_ids([world.X_CO(0)])
    expected = silhouette(antenna.part.mesh, world.X_CO(0), true, pixel_center=PIXEL_CENTER).mask
    assert expected.sum() > 2000
    assert (expected ^ (numbers == 0)).sum() <= 2
    assert seen_frame(world)[0].camera == believed


def test_a_shifted_principal_point_shifts_the_estimate_by_z_over_f(antenna: PartModel) -> None:
    world = world_of(antenna, principal_point_error_px=(6.0, -3.0))
    frame, X_CO_est = estimated(world, antenna)
    center_O = antenna.part.mesh.center
    true = world.X_CO(0).apply(center_O)
    per_pixel = true[2] / frame.camera.fx
    assert per_pixel == pytest.approx(0.6 / 600, rel=0.2)
    assert X_CO_est.apply(center_O) - true == pytest.approx([6.0 * per_pixel, -3.0 * per_pixel, 0.0], abs=1e-12)


def test_a_longer_focal_length_than_believed_brings_the_estimate_nearer(antenna: PartModel) -> None:
    world = world_of(antenna, focal_error_percent=2.0)
    _, X_CO_est = estimated(world, antenna)
    center_O = antenna.part.mesh.center
    seen, true = X_CO_est.apply(center_O), world.X_CO(0).apply(center_O)
    assert seen[2] == pytest.approx(true[2] / 1.02)
    assert seen[:2] == pytest.approx(true[:2])  # the same pixel at f/1.02 and z/1.02


def test_the_estimate_with_a_wrong_camera_still_fits_the_mask(antenna: PartModel) -> None:
    world = world_of(antenna, focal_error_percent=2.0, principal_point_error_px=(10.0, 10.0))
    frame, X_CO_est = estimated(world, antenna)
    believed = silhouette(antenna.part.mesh, X_CO_est, frame.camera, pixel_center=PIXEL_CENTER).mask
    shown = WristCamera(world).instance_ids([world.X_CO(0)]) == 0
    # Perspective inside the part remains: 2 % of distance over its 60 mm of height at 0.6 m is 0.1 px per 50 px.
    assert (believed & shown).sum() / (believed | shown).sum() > 0.97


def test_hand_eye_errors_shift_and_turn_the_estimate_in_the_base(antenna: PartModel) -> None:
    shift, turn = np.array([4.0, 0.0, -3.0]), np.radians(2.0)
    world = world_of(antenna, hand_eye_error_mm=tuple(shift), hand_eye_error_deg=(0.0, 0.0, 2.0))
    frame, X_CO_est = estimated(world, antenna)
    X_BO_est = frame.X_BC @ X_CO_est
    X_BO_true = world.layout.X_WB.inverse() @ world.X_WO(0)
    # The camera stands at X_BC · X_error: what it sees is put back as if it stood at X_BC.
    c, s = np.cos(turn), np.sin(turn)
    error = Pose(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), shift / 1000)
    expected = frame.X_BC @ error.inverse() @ frame.X_BC.inverse() @ X_BO_true
    assert X_BO_est.translation == pytest.approx(expected.translation, abs=1e-4)  # the servo's and the parts' sag
    assert np.linalg.norm(X_BO_est.translation - X_BO_true.translation) > 0.003


def wake(world: World) -> None:
    world.data.qvel[:] += 1e-6


def pushed(world: World, force: float) -> float:
    """How far the part slides in 0.2 s under a horizontal force through its middle, m."""
    before = world.X_WO(0).translation
    world.data.xfrc_applied[world.mj_model.body("part_0").id, :2] = [0.0, force]
    wake(world)
    for _ in range(100):
        world.step()
    return float(np.linalg.norm((world.X_WO(0).translation - before)[:2]))


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_friction_scales_the_force_at_which_a_part_begins_to_slide(antenna: PartModel, scale: float) -> None:
    # Coulomb: it slides above μ m g; MuJoCo takes the larger μ of part and belt, 0.7 here.
    limit = scale * max(0.7, antenna.friction) * antenna.mass * GRAVITY
    assert pushed(world_of(antenna, friction=scale), 0.9 * limit) < 0.002
    assert pushed(world_of(antenna, friction=scale), 1.3 * limit) > 0.01


def test_friction_scales_the_hold_of_the_jaws(antenna: PartModel) -> None:
    usual, slippery = (world_of(antenna, **knobs).mj_model for knobs in ({}, {"friction": 0.3}))
    assert usual.npair == 2 * len(antenna.pieces)  # two pads on every piece of the one part
    np.testing.assert_allclose(slippery.pair_friction[:, :2], 0.3 * usual.pair_friction[:, :2], rtol=1e-12, atol=0)
    np.testing.assert_array_equal(slippery.pair_friction[:, 2:], usual.pair_friction[:, 2:])


def test_mass_scales_weight_and_inertia(antenna: PartModel) -> None:
    light, heavy = (world_of(antenna, **knobs) for knobs in ({}, {"mass": 2.5}))
    body = light.mj_model.body("part_0").id
    assert heavy.mj_model.body_mass[body] == pytest.approx(2.5 * antenna.mass)
    assert heavy.mj_model.body_inertia[body] == pytest.approx(2.5 * light.mj_model.body_inertia[body])
    for world, mass in ((light, antenna.mass), (heavy, 2.5 * antenna.mass)):
        wake(world)
        world.step()
        weight = world.data.qfrc_constraint[world.mj_model.body_dofadr[body] + 2]  # what the belt pushes up with
        assert weight == pytest.approx(mass * GRAVITY, rel=0.02)


def test_a_picture_arrives_by_the_latency_later_than_it_was_taken(antenna: PartModel) -> None:
    world = world_of(antenna, latency_s=0.7)
    station = SimStation(world, WristCamera(world), LatestTruth())
    frame = station.take_frame(frozenset())
    assert frame.time == 0.0
    assert station.time == pytest.approx(0.7)


def moving(antenna: PartModel, parts: int = 1, **knobs: float) -> World:
    """A world whose belt moves, before its reset."""
    conditions = Conditions(belt_speed=0.1, **knobs)
    return World(Layout(belt=belt_under(conditions, parts)), antenna, parts, conditions)


@pytest.mark.parametrize("error", [0.0, 20.0, -10.0])
def test_the_belt_runs_by_its_error_faster_than_the_controller_believes(antenna: PartModel, error: float) -> None:
    world, duration = moving(antenna, belt_speed_error_percent=error), 2.0
    world.reset([on_belt(antenna, X, 0.40, standing(antenna))])
    for _ in range(round(duration / world.time_step)):
        world.step()
    speed = 0.1 * (1 + error / 100)
    slip = speed**2 / (2 * 0.7 * GRAVITY)  # until it is up to speed, on friction 0.7
    way = 0.40 - world.X_WO(0).translation[1]
    assert speed * (duration - world.time_step) - 1.5 * slip < way <= speed * duration + 1e-3  # to a step
    assert world.layout.belt.speed == 0.1  # what the controller is told


def test_parts_come_in_takt_whatever_the_controller_believes_of_the_belt(antenna: PartModel) -> None:
    exact, faster = moving(antenna, 4), moving(antenna, 4, belt_speed_error_percent=20.0)
    believed, true = (
        np.diff([pose.translation[1] for pose in starting_poses(world, Streams(0, 0, "antenna"))])
        for world in (exact, faster)
    )
    # Between the fronts it is 1.2 times as far; between the origins too, but for how the parts lie.
    assert true.sum() / believed.sum() == pytest.approx(1.2, abs=0.03)
    # Room for the same number of takts, each at most 15 s · 1.15.
    assert belt_under(faster.conditions, 4).upstream == pytest.approx(4 * 0.12 * 15 * 1.15)


def test_a_belt_at_rest_has_no_speed_to_be_wrong_about() -> None:
    assert Conditions(belt_speed_error_percent=20.0).belt_true(Belt()) == Belt()


@pytest.mark.parametrize("name", RANGES)
def test_a_knob_beyond_its_range_is_named_with_its_range(name: str) -> None:
    least, most = RANGES[name]
    default = getattr(UNDISTURBED, name)
    for value in (least - 0.01, most + 0.01, float("nan")):
        wrong = value if isinstance(default, float) else (value, *default[1:])
        option = f"--{name.replace('_', '-')}"
        with pytest.raises(ConditionsError, match=f"expected {option} within {least:g} and {most:g}, got"):
            Conditions(**{name: wrong})


def test_every_number_has_a_range_and_its_default_lies_within() -> None:
    numbers = [field.name for field in fields(Conditions) if not isinstance(getattr(UNDISTURBED, field.name), str)]
    assert numbers == list(RANGES)
