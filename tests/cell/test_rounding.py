import numpy as np
import pytest

from cell.rounding import first_least, rounded


def test_numbers_that_differ_in_the_last_bit_have_the_same_bits_once_rounded():
    number = 0.1234567891234
    neighbours = [np.nextafter(number, -1.0), number, np.nextafter(number, 1.0)]
    assert len({rounded(value).tobytes() for value in neighbours}) == 1
    assert rounded(number) == pytest.approx(0.123456789, abs=1e-15)


def test_rounding_twice_is_rounding_once():
    numbers = np.random.default_rng(0).normal(size=10_000)
    assert rounded(rounded(numbers)).tobytes() == rounded(numbers).tobytes()


def test_minus_zero_becomes_zero():
    assert not np.signbit(rounded([-0.0, -1e-17])).any()


def test_of_equals_the_first_is_taken_whatever_their_last_bits():
    assert (
        first_least([("a", 0.3), ("b", 0.1 + 0.2), ("c", np.nextafter(0.3, 0.0))], key=lambda item: item[1])[0] == "a"
    )
    assert first_least([("a", 0.3), ("b", 0.3 - 1e-8)], key=lambda item: item[1])[0] == "b"
