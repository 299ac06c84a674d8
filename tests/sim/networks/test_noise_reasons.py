"""The constants of the simulated networks, held by the reasons that stand beside them."""

import math

import numpy as np
import pytest
from scipy.special import ndtri

from sim.networks import mask_noise
from sim.networks.mask_noise import CELLS, MODES, false_alarm, random_field
from sim.networks.view_noise import RandomField
from tests.round_noise import ROUND


def test_one_streams_correlation_is_within_about_a_tenth_of_the_kernels() -> None:
    # The correlation of one stream's values at 0 and x, over its weights, is the mean of cos(w · x) over frequencies
    # w. Cosines of N(0, d²) phases have mean exp(-d²/2) and variance (1 - exp(-d²))² / 2.
    x, d = np.array([1.0, 0.0, 0.0, 0.0]), 1.0
    made = (RandomField(np.random.default_rng(seed), 4, 1) for seed in range(400))
    found = np.array([np.cos(field._frequencies @ x).mean() for field in made])
    assert found.mean() == pytest.approx(math.exp(-(d**2) / 2), abs=0.02)
    assert found.std() == pytest.approx((1 - math.exp(-(d**2))) / math.sqrt(2 * 96), rel=0.15)


def test_the_grid_is_the_one_of_mask_rcnns_head() -> None:
    assert CELLS == 28


def test_the_fields_bumps_are_about_cells_by_modes_wide() -> None:
    # The highest mode, cos(π (MODES - 1) v / CELLS), goes from crest to trough in CELLS / (MODES - 1) cells.
    coefficients = np.zeros((MODES, MODES))
    coefficients[0, MODES - 1] = 1.0
    row = random_field(coefficients.ravel())[0]
    signs = np.sign(row - row.mean())
    assert np.count_nonzero(np.diff(signs)) == MODES - 1 == 4


def test_a_dropped_piece_is_left_outside_whatever_the_field_says() -> None:
    # Ten standard deviations of the shipped field, 0.2 cells, and the most of a leak, 0.4, do not bring it back.
    assert mask_noise._CUT + 10 * 0.2 + 0.4 < 0.0


def test_a_false_alarms_half_axes_vary_by_their_spread() -> None:
    always = ROUND.mask.__class__(
        **{
            name: getattr(ROUND.mask, name)
            for name in ROUND.mask.__dataclass_fields__
            if name not in ("false_alarms_per_image", "false_alarm_radius_px")
        },
        false_alarms_per_image=1.0,
        false_alarm_radius_px=100.0,
    )
    gate = float(ndtri(0.5))

    def area_px(z: float) -> int:
        latents = np.array([gate, 0.0, 0.0, 0.0, z, z, 0.0])
        alarm = false_alarm((1000, 1000), latents, always)
        assert alarm is not None
        return int(alarm.mask.sum())

    # Both half axes at one standard deviation: the area grows by exp(2 · 0.3).
    assert area_px(1.0) / area_px(0.0) == pytest.approx(math.exp(0.6), rel=0.02)


@pytest.mark.parametrize("width_px", [14, 56])
def test_the_distance_is_sampled_finely_enough_for_an_outline_to_stay_where_it_is(width_px: int) -> None:
    mask = np.zeros((100, 100), dtype=bool)
    mask[20 : 20 + width_px, 20 : 20 + width_px] = True
    box = (20.0, 20.0, 20.0 + width_px, 20.0 + width_px)
    distance = mask_noise.cell_distance(mask, box)
    middle = distance[CELLS // 2]
    # A straight side at the box's border: cell i's middle is i + 0.5 cells inside, to a quarter of a cell.
    np.testing.assert_allclose(middle[:8], np.arange(8) + 0.5, atol=0.26)
