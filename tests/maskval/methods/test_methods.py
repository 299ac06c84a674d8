"""The library's methods by name, on a plate whose poses and masks make every u plain arithmetic."""

from typing import Any

import numpy as np
import pytest

from maskval import METHODS, Camera, Estimates, Mesh, Needs, Pose, depth_image, needs_of, silhouette

PLATE = Mesh(
    np.array([[-0.05, -0.05, 0.0], [0.05, -0.05, 0.0], [0.05, 0.05, 0.0], [-0.05, 0.05, 0.0]]), [[0, 1, 2], [0, 2, 3]]
)
CAMERA = Camera(600, 600, 320, 240, 640, 480)
AHEAD = Pose.from_translation((0.0, 0.0, 0.6))


def estimates(X_CO: Pose = AHEAD, other: Pose | None = None, X_BC: Pose | None = None) -> Estimates:
    """A plate with its exact mask and depth; the second network may see it elsewhere."""
    mask, depth = silhouette(PLATE, X_CO, CAMERA).mask, depth_image(PLATE, X_CO, CAMERA)
    poses = ((X_CO,), (X_CO if other is None else other,))
    return Estimates(CAMERA, PLATE, mask[None], poses, np.array([0.75]), depth=depth, X_BC=X_BC or Pose.identity())


def u_of(name: str, given: Estimates) -> float:
    (u,) = METHODS[name]()(given)
    return float(u)


def test_what_fits_exactly_is_certain_by_all_that_look_and_a_first_view_has_no_second_to_speak_for_it() -> None:
    found = {name: u_of(name, estimates()) for name in METHODS}
    assert found.pop("score") == 1 - 0.75
    assert found.pop("temporal") == 1.0
    assert len(found) == 10
    assert found == pytest.approx(dict.fromkeys(found, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    ("apart", "u"),
    [
        (
            Pose.from_translation((0.025, 0.0, 0.0)),  # half of 5 cm, with every point
            {"add": 0.5, "mdd": 0.5, "translation": 0.5, "rotation": 0.0},
        ),
        (
            Pose.from_rotvec((0.0, 0.0, np.pi / 6)),  # corners at 71 mm from the middle, by 2 · 71 mm · sin(15°)
            {"add": 2 * 0.05 * 2**0.5 * np.sin(np.pi / 12) / 0.05, "translation": 0.0, "rotation": 1 / 6},
        ),
        (
            Pose.from_rotvec((np.pi, 0.0, 0.0), (0.0, 0.05, 0.0)),  # turned over about its edge: 0 m there, 0.1 m here
            {"add": 1.0, "mdd": 1.0, "translation": 1.0, "rotation": 1.0},
        ),
    ],
)
def test_ensembles_are_as_uncertain_as_the_networks_are_apart(apart: Pose, u: dict[str, float]) -> None:
    given = estimates(other=AHEAD @ apart)
    for name, expected in u.items():
        assert u_of(f"ensemble-{name}", given) == pytest.approx(expected, abs=1e-9)
    # MaskVal is certain here, so that the product of certainties is the ensemble's.
    assert u_of("maskval-ensemble", given) == pytest.approx(u["add"], abs=1e-9)


def test_only_maskval_with_visibility_doubts_what_the_image_cuts_off() -> None:
    given = estimates(Pose.from_translation((0.32, 0.0, 0.6)))  # its middle is on the right edge of the image
    assert u_of("maskval", given) == pytest.approx(0.5, abs=0.01)
    assert u_of("maskval-no-visibility", given) == 0.0


def test_each_says_what_it_must_be_given() -> None:
    two = {"ensemble-add", "ensemble-mdd", "ensemble-translation", "ensemble-rotation", "maskval-ensemble"}
    special: dict[str, Needs] = {name: Needs(estimators=2) for name in two}
    special |= {"depth": Needs(depth=True), "temporal": Needs(X_BC=True)}
    assert set(special) < set(METHODS)
    for name, make in METHODS.items():
        assert needs_of(make()) == special.get(name, Needs())


@pytest.mark.parametrize("name", METHODS)
def test_each_call_makes_one_that_has_seen_nothing(name: str) -> None:
    shift = Pose.from_translation((0.2, 0.0, 0.0))
    from_elsewhere: Any = estimates(shift.inverse() @ AHEAD, X_BC=shift)  # the same plate
    used = METHODS[name]()
    used(from_elsewhere)
    used(estimates())
    assert METHODS[name]()(estimates()) == u_of(name, estimates())


def test_temporal_is_certain_of_what_it_saw_from_elsewhere() -> None:
    method, shift = METHODS["temporal"](), Pose.from_translation((0.2, 0.0, 0.0))
    assert method(estimates(shift.inverse() @ AHEAD, X_BC=shift)) == 1.0
    assert method(estimates()) == pytest.approx(0.0, abs=1e-9)
