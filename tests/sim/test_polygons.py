import numpy as np
import pytest

from sim.polygons import are_apart, gap

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_the_gap_of_two_squares_is_their_distance() -> None:
    assert gap(SQUARE, np.add(SQUARE, [1.3, 0.2])) == pytest.approx(0.3)
    assert gap(SQUARE, np.add(SQUARE, [0.9, 0.5])) == pytest.approx(-0.1)
    # Corner to corner the true distance is 0.3 √2; the bound is the larger of the two shifts.
    assert gap(SQUARE, np.add(SQUARE, [1.3, 1.3])) == pytest.approx(0.3)


def test_polygons_are_apart_where_their_boxes_or_an_edge_show_the_clearance() -> None:
    diamond = np.array([[0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]])
    assert are_apart(SQUARE, np.add(SQUARE, [1.3, 0.2]), 0.29)
    assert not are_apart(SQUARE, np.add(SQUARE, [1.3, 0.2]), 0.31)
    # Their boxes overlap; the distance across the edges is (0.7 + 0.7 − 1) / √2 = 0.283.
    assert are_apart(diamond, np.add(diamond, [0.7, 0.7]), 0.28)
    assert not are_apart(diamond, np.add(diamond, [0.7, 0.7]), 0.29)
