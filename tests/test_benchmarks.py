import inspect

from benchmarks.mechanics import ObservedStation, subject
from sim.runtime.station import SimStation


def test_the_mechanics_hook_into_the_station_that_experiments_run_on():
    assert subject.SimStation is SimStation
    ours, theirs = (inspect.signature(station._run) for station in (ObservedStation, SimStation))
    assert list(ours.parameters) == list(theirs.parameters)
