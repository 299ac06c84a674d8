from collections.abc import Iterator

import pytest

from sim.gym.decision_env import GraspCellEnv
from tests.sim.gym.decisions import made


@pytest.fixture(scope="module")
def env() -> Iterator[GraspCellEnv]:
    env = made()
    yield env
    env.close()


@pytest.fixture(scope="module")
def oracle() -> Iterator[GraspCellEnv]:
    env = made(estimator="oracle", methods=("maskval", "ensemble-add"), images=("rgb", "depth", "masks"))
    yield env
    env.close()
