import numpy as np
import pytest

from maskval import Mesh, Pose, mdd
from maskval.symmetry import right_angle_symmetries
from sim.model.parts import load_part
from tests.maskval import shapes


def box(x: float, y: float, z: float) -> Mesh:
    cube = shapes.cube(1.0)
    return Mesh(cube.vertices * (x, y, z) + (0.3, 0.0, -0.1), cube.faces)


@pytest.mark.parametrize(
    ("mesh", "count"),
    # Proper turns of a cube, a square prism and a brick: the groups O, D4 and D2 without the identity.
    [(box(0.1, 0.1, 0.1), 23), (box(0.1, 0.1, 0.2), 7), (box(0.1, 0.15, 0.2), 3)],
)
def test_a_box_has_the_turns_of_its_group(mesh: Mesh, count: int) -> None:
    found = right_angle_symmetries(mesh)
    assert len(found) == count
    corners = {tuple(corner) for corner in np.round(mesh.vertices, 9)}
    for X in found:
        assert {tuple(corner) for corner in np.round(X.apply(mesh.vertices), 9)} == corners


def test_the_handle_looks_alike_turned_by_half_and_the_antenna_never() -> None:
    (half_turn,) = right_angle_symmetries(load_part("handle").part.mesh)
    assert mdd(half_turn, Pose.from_rotvec((0, 0, np.pi)), shapes.cube(0.2).vertices) < 1e-9
    assert right_angle_symmetries(load_part("antenna").part.mesh) == ()
