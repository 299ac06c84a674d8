"""`graspcell bench` measures experiments that really run, and their commands again."""

import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from experiments.commands.bench import STAGES, bench, timers
from experiments.commands.bench_config import Bench
from experiments.errors import UsageError
from experiments.setup.experiment import kept_cell, run_experiment
from sim.errors import DivergenceError
from sim.networks.random_streams import Streams
from sim.runtime.bare_physics import Recording, record, replay
from sim.runtime.episode import starting_poses

ONE = Bench(objects=("antenna",), experiments=1, parts=1, jobs=1)


def test_bench_prints_speed_floor_shares_and_memory(capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(ONE) == 0
    printed = capsys.readouterr().out
    speed, ratio = map(float, re.findall(r"antenna: ([\d.]+) × real time; ([\d.]+) × the bare physics", printed)[0])
    assert speed > 0.0
    assert ratio > 0.5
    shares = {name: float(share) for share, name in re.findall(r"^ +(-?[\d.]+) %  (.+)$", printed, re.MULTILINE)}
    assert list(shares) == [*STAGES, "Python around them"]
    assert sum(shares.values()) == pytest.approx(100.0, abs=0.1 * len(shares))
    assert shares["physics, with setpoints"] > 20.0
    assert int(re.findall(r"memory of this process (\d+) MB", printed)[0]) > 50


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_is_a_function_that_exists(stage: str) -> None:
    module, owner, name = STAGES[stage]
    place = import_module(module) if owner is None else getattr(import_module(module), owner)
    assert callable(getattr(place, name))


def test_timers_leave_the_functions_as_they_were() -> None:
    import sim.runtime.world as place  # noqa: PLC0415

    before = place.run_periods
    with timers():
        assert place.run_periods is not before
    assert place.run_periods is before


def test_a_replay_ends_where_the_experiment_did_and_another_is_an_error() -> None:
    spec = ONE.specs()["antenna"][0]
    world = kept_cell(*spec.cell).world
    recording = record(world, lambda: run_experiment(spec))
    assert world.on_step is None
    assert len(recording.controls) > 1000
    poses = starting_poses(world, Streams(spec.seed, spec.experiment, "antenna"))
    assert replay(world, poses, recording) > 0.0
    elsewhere = Recording(recording.controls, recording.p_WO + np.array([0.01, 0.0, 0.0]))
    with pytest.raises(DivergenceError, match=r"expected the parts where they were to 1 mm, got 10\.\d mm"):
        replay(world, poses, elsewhere)


def test_bench_says_what_a_second_process_brings(capsys: pytest.CaptureFixture[str]) -> None:
    assert bench(replace(ONE, jobs=2)) == 0
    printed = capsys.readouterr().out
    (gain,) = re.findall(r"^2 processes do ([\d.]+) × the experiments of one, with \d+ MB each$", printed, re.MULTILINE)
    assert float(gain) > 0.0


def test_an_invalid_option_is_named() -> None:
    with pytest.raises(UsageError, match="--jobs"):
        Bench(jobs=0).specs()
    with pytest.raises(UsageError, match="gearbox"):
        Bench(objects=("gearbox",)).specs()
