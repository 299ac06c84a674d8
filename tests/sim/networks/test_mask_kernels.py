import numpy as np
import pytest

from sim.networks.mask_kernels import fill_positive, histogram, overlap, sample, signed


def between(rows: np.ndarray, place: np.ndarray) -> np.ndarray:
    """The rows at places between them, linear; beyond the border as at the border."""
    last = len(rows) - 1
    below = np.clip(np.floor(place), 0, last).astype(int)
    share = np.clip(place - below, 0.0, 1.0)[:, None]
    return (rows[np.minimum(below + 1, last)] - rows[below]) * share + rows[below]


def bilinear(image: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return between(between(image.astype(float).T, u).T, v)


@pytest.mark.parametrize(("low", "high"), [(3.0, 20.0), (-9.0, 60.0), (45.0, 70.0)])
def test_samples_are_the_bilinear_values_to_the_last_bit(low: float, high: float) -> None:
    rng = np.random.default_rng(0)
    pixels = (rng.random((30, 40)) < 0.5).astype(np.uint8)
    u, v = np.sort(rng.uniform(low, high, 128)), np.linspace(low, high, 96)
    np.testing.assert_array_equal(sample(pixels, u, v), np.rint(255.0 * bilinear(pixels, u, v)))
    grid, mask = rng.normal(size=(28, 28)), np.zeros((96, 128), dtype=bool)
    fill_positive(grid, u, v, mask)
    np.testing.assert_array_equal(mask, bilinear(grid, u, v) > 0.0)


@pytest.mark.parametrize("size", [0, 5, 64, 83])
def test_pixels_are_counted_whatever_their_number(size: int) -> None:
    rng = np.random.default_rng(size)
    one, other = rng.random((2, size)) < 0.4
    assert overlap(one, other) == (one.sum(), other.sum(), (one & other).sum())
    numbers = rng.integers(-1, 4, size).astype(np.int8)
    assert histogram(numbers, one).tolist() == [(one & (numbers == number)).sum() for number in range(128)]


def test_a_signed_distance_is_measured_from_between_two_samples() -> None:
    to_outside, to_inside = np.array([[0, 0, 1, 2, 900]], np.float32), np.array([[2, 1, 0, 0, 0]], np.float32)
    assert signed(to_outside, to_inside, 4, 28).tolist() == [[-0.375, -0.125, 0.125, 0.375, 28.0]]
