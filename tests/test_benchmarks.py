import inspect
from importlib import import_module

import pytest

from benchmarks.experiment import STAGES
from benchmarks.mechanics import ObservedStation, subject
from sim.runtime.station import SimStation


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_of_the_speed_table_is_a_function_that_exists(stage):
    module, owner, name = STAGES[stage]
    place = import_module(module) if owner is None else getattr(import_module(module), owner)
    assert callable(getattr(place, name))


def test_the_mechanics_hook_into_the_station_that_experiments_run_on():
    assert subject.SimStation is SimStation
    ours, theirs = (inspect.signature(station._run) for station in (ObservedStation, SimStation))
    assert list(ours.parameters) == list(theirs.parameters)
