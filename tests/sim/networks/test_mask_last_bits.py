"""Masks are made without single precision's last bits, in which processors differ."""

import math

import cv2
import numpy as np

from sim.networks.mask_noise import CELLS, MODES, paste, random_field


def test_the_random_field_is_the_exact_sum_rounded_to_single_precision() -> None:
    coefficients = np.random.default_rng(0).normal(size=MODES**2)
    place = (np.arange(CELLS) + 0.5) / CELLS
    along = [[math.sqrt(2 if k else 1) * math.cos(math.pi * k * x) for x in place] for k in range(MODES)]
    exact = [
        [
            math.fsum(
                coefficients[MODES * i + j] * along[i][v] * along[j][u] / MODES
                for i in range(MODES)
                for j in range(MODES)
            )
            for u in range(CELLS)
        ]
        for v in range(CELLS)
    ]
    np.testing.assert_array_equal(random_field(coefficients), np.float32(exact))


def test_a_pasted_mask_is_the_one_that_opencv_interpolates() -> None:
    rng, compared = np.random.default_rng(0), 0
    for _ in range(50):
        distance = cv2.blur(rng.normal(size=(CELLS, CELLS)).astype(np.float32), (5, 5))
        left, top = rng.uniform(-30, 60, size=2)
        right, bottom = left + rng.uniform(20, 80), top + rng.uniform(20, 80)
        mask = paste(distance, (left, top, right, bottom), (90, 120))
        du, dv = CELLS / (right - left), CELLS / (bottom - top)
        to_grid = np.array([[du, 0.0, (0.5 - left) * du - 0.5], [0.0, dv, (0.5 - top) * dv - 0.5]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        warped = cv2.warpAffine(distance, to_grid, (120, 90), flags=flags, borderMode=cv2.BORDER_REPLICATE)
        v, u = np.mgrid[:90, :120] + 0.5
        inside = (u >= left) & (u < right) & (v >= top) & (v < bottom)
        clear = np.abs(warped) > 1e-3  # cells; older releases of OpenCV interpolate in steps of 1/32 pixel
        np.testing.assert_array_equal(mask[clear], (inside & (warped > 0.0))[clear])
        compared += int((inside & clear).sum())
    assert compared > 50_000
