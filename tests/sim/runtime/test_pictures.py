from contextlib import closing

import numpy as np

from sim.instance_ids import NO_INSTANCE
from sim.model.parts import PartModel
from sim.runtime.pictures import Pictures
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera
from tests.sim.conftest import on_belt, standing


def reset(world: World, antenna: PartModel) -> None:
    """An antenna that falls over, and one that stands, in the first search view."""
    x = world.layout.belt.center_x
    world.reset([on_belt(antenna, x, 0.45, standing(antenna)), on_belt(antenna, x + 0.05, 0.3, 0, yaw=1.0)])


def states(world: World, steps: int) -> np.ndarray:
    world.data.qvel[:] += 0.2
    rows = []
    for _ in range(steps):
        world.step()
        rows.append(np.concatenate((world.data.qpos, world.data.qvel)))
    return np.array(rows)


def test_pictures_change_nothing_in_the_world(antenna_world: World, antenna: PartModel) -> None:
    reset(antenna_world, antenna)
    unseen = states(antenna_world, 60)
    with closing(Pictures(antenna_world, 48, 64, samples=1)) as pictures:
        reset(antenna_world, antenna)
        antenna_world.on_step = lambda: _look(pictures)
        try:
            seen = states(antenna_world, 60)
        finally:
            antenna_world.on_step = None
    assert np.ptp(unseen, axis=0).max() > 1e-3
    assert np.array_equal(seen, unseen)


def _look(pictures: Pictures) -> None:
    assert pictures.rgb("wrist").any()


def test_a_picture_shows_the_world_as_it_is_now_and_repeats_bit_for_bit(
    antenna_world: World, antenna: PartModel
) -> None:
    reset(antenna_world, antenna)
    with closing(Pictures(antenna_world, 120, 160, samples=2)) as pictures:
        first = pictures.rgb("overview")
        assert (first.shape, first.dtype) == ((120, 160, 3), np.uint8)
        assert np.array_equal(pictures.rgb("overview"), first)
        antenna_world.data.qpos[0] += 0.3
        assert not np.array_equal(pictures.rgb("overview"), first)


def test_the_close_up_shows_both_jaws_beside_the_middle_of_the_picture(
    antenna_world: World, antenna: PartModel
) -> None:
    reset(antenna_world, antenna)
    with closing(Pictures(antenna_world, 120, 160, samples=1, shadows=0)) as pictures:
        first = pictures.close_up()
        assert np.array_equal(pictures.close_up(antenna_world.data.qpos), first)
        narrower = antenna_world.data.qpos.copy()
        for name in ("finger_left", "finger_right"):
            body = antenna_world.mj_model.body(name)
            narrower[antenna_world.mj_model.jnt_qposadr[body.jntadr[0]]] *= 0.5
        changed = (pictures.close_up(narrower) != first).any(axis=2)
        assert np.array_equal(pictures.close_up(), first)
    columns = np.flatnonzero(changed.any(axis=0))
    assert 20 < columns.min() < 75  # one jaw left of the middle, 80, the other right of it
    assert 85 < columns.max() < 140


def test_more_samples_give_the_same_picture_with_smooth_outlines(antenna_world: World, antenna: PartModel) -> None:
    reset(antenna_world, antenna)
    greys = {}
    for samples in (1, 12):
        with closing(Pictures(antenna_world, 480, 640, samples)) as pictures:
            greys[samples] = pictures.rgb("wrist").mean(axis=2)
    assert np.abs(greys[1] - greys[12]).mean() < 3.0  # of 255
    # Between neighbours, 80 of 255: without samples a pixel shows a part, its shadow or the belt, and nothing between.
    steps = {samples: (np.abs(np.diff(grey)) > 80).sum() for samples, grey in greys.items()}
    assert steps[1] > 200
    assert steps[12] < 0.7 * steps[1]


def test_the_wrist_picture_shows_parts_where_their_instance_ids_are(antenna_world: World, antenna: PartModel) -> None:
    reset(antenna_world, antenna)
    with closing(WristCamera(antenna_world)) as camera:
        numbers = camera.instance_ids([antenna_world.X_CO(part) for part in range(2)])
        rgb = camera.rgb()[100:380].astype(float)
    shown = numbers[100:380] != NO_INSTANCE
    assert shown.sum() > 5000
    colourless = np.ptp(rgb, axis=2) < 0.08 * rgb.max(axis=2) + 3  # as the antenna is, and the green belt is not
    assert (colourless & shown).sum() / (colourless | shown).sum() > 0.95
