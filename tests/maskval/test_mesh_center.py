import numpy as np
import pytest

from maskval import Mesh
from tests.maskval import shapes


def test_the_center_is_the_middle_of_the_box_and_not_the_mean_of_the_vertices() -> None:
    mesh = Mesh(np.array([[0.0, -1, 2], [3, 0, 2], [0, 4, 3]]), [[0, 1, 2]])
    assert mesh.center.tolist() == [(0 + 3) / 2, (-1 + 4) / 2, (2 + 3) / 2]


def test_nobody_can_write_to_the_center() -> None:
    with pytest.raises(ValueError, match="read-only"):
        shapes.cube().center[0] = 1
