import pytest

from cell.records import Tally
from experiments.commands.compare import asked_by
from experiments.commands.config import Compare
from experiments.setup import error_models
from experiments.setup.actors import Actors
from experiments.setup.experiment import ExperimentResult
from experiments.units.summary import caveats_of, counted_of, summary_of, thresholds_of
from experiments.units.unit import unit_of
from sim.model import parts


def test_a_whole_comparison_makes_each_part_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    make = parts.resting_poses
    monkeypatch.setattr(parts, "resting_poses", lambda mesh: made.append(1) or make(mesh))
    parts._build.cache_clear()
    error_models._draws.cache_clear()
    specs = Compare(methods=("all",), experiments=20, actors=Actors(gap="fitted")).specs()
    count = Tally(parts=8, tp=8, fp=0, fn=0, void=0, unreachable=0, timeouts=0, duration=90.0)
    results = [ExperimentResult(spec, count, None, {"attempts": [], "estimates": []}) for spec in specs]
    summary = summary_of([counted_of(unit_of(result)) for result in results])
    assert {cell.object for cell in summary.cells} == {"antenna", "handle"}
    assert (len(summary.pairs), len(thresholds_of(asked_by(specs)))) == (28, 2)
    assert len(caveats_of(asked_by(specs))) == 4  # score and temporal, of both parts
    assert len(made) == 2
