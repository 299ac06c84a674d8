import numpy as np
import pytest

from maskval import Combined, DepthConsistency, Ensemble, InvalidEstimatesError, MaskVal, Needs, needs_of
from tests.fakes import FakeMethod
from tests.maskval.methods.test_baselines import estimates
from tests.maskval.shapes import random_poses

MADE = estimates(random_poses(0, 4))


def test_certainties_multiply() -> None:
    first, second = FakeMethod([[0.0, 0.5, 0.2, 1.0]]), FakeMethod([[0.0, 0.5, 0.5, 0.0]])
    assert Combined((first, second))(MADE) == pytest.approx([0.0, 0.75, 1 - 0.8 * 0.5, 1.0])


def test_one_method_is_itself_and_the_order_does_not_matter() -> None:
    u = np.array([0.1, 0.2, 0.3, 0.4])
    assert Combined((FakeMethod([u]),))(MADE) == pytest.approx(u)
    there, back = (Combined((FakeMethod([a]), FakeMethod([b])))(MADE) for a, b in ((u, u[::-1]), (u[::-1], u)))
    assert there == pytest.approx(back, abs=1e-15)


def test_it_is_never_more_certain_than_any_of_its_methods() -> None:
    rng = np.random.default_rng(0)
    values = rng.uniform(size=(3, 4))
    u = Combined(tuple(FakeMethod([row]) for row in values))(MADE)
    assert (u >= values.max(axis=0)).all()
    assert (u <= 1.0).all()


def test_it_needs_what_all_of_its_methods_need() -> None:
    assert needs_of(Combined((MaskVal(), Ensemble()))) == Needs(estimators=2)
    assert needs_of(Combined((DepthConsistency(), Ensemble()))) == Needs(estimators=2, depth=True)
    assert needs_of(Combined((Combined((DepthConsistency(),)), MaskVal()))) == Needs(depth=True)


def test_no_methods_are_refused() -> None:
    with pytest.raises(InvalidEstimatesError, match="at least one, but are none"):
        Combined(())
