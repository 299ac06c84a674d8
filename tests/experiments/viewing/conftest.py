import pytest

from experiments.observing.take import Take, take
from tests.experiments.observing.test_take import SPEC


@pytest.fixture(scope="session")
def taken() -> Take:
    return take(SPEC)
