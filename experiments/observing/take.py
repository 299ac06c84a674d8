"""An experiment with where everything was and what was known at every time, to show it later."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from cell.part import Part
from experiments.observing.observer import Observer
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, kept_cell, run_experiment
from sim.networks.ground_truth import LatestTruth
from sim.runtime.film import Film
from sim.runtime.world import World

Tell = Callable[[object, LatestTruth], None]
Run = Callable[[Tell], ExperimentResult]  # in the process's cell of the experiment


@dataclass(slots=True)
class Take:
    """One experiment to show.

    Attributes:
        spec: the experiment.
        world: where it ran.
        film: where everything was.
        observer: what was known.
        result: what it came to.
    """

    spec: ExperimentSpec
    world: World
    observer: Observer
    film: Film = field(default_factory=Film)
    result: ExperimentResult | None = None

    @property
    def part(self) -> Part:
        """The kind of part."""
        return self.world.part_model.part

    def span(self, attempt: int | None) -> tuple[float, float]:
        """Begin and end of what is to be shown, s: the experiment, or an attempt from the look that caused it on.

        Raises:
            LookupError: there was no attempt of this number; the message says how many there were.
        """
        if attempt is None:
            return 0.0, self.film.duration
        attempts = self.observer.attempts
        if not 0 <= attempt < len(attempts):
            raise LookupError(f"in 0..{len(attempts) - 1}" if attempts else "of an experiment that has attempts")
        decided, tried = attempts[attempt]
        return decided.observation.frame.time, tried.end


@contextmanager
def taking(spec: ExperimentSpec) -> Iterator[Take]:
    """A take of what the process's cell of an experiment does in the block, if the records go to its observer.

    Raises:
        SimError: the cell cannot be set up.
    """
    world = kept_cell(*spec.cell).world
    taken = Take(spec, world, Observer(world))
    with taken.film.recording(world):
        yield taken


def take(spec: ExperimentSpec, run: Run | None = None) -> Take:
    """Runs an experiment and takes down what happens.

    Args:
        spec: the experiment.
        run: runs it and tells what it is given every record; by default `run_experiment`.

    Raises:
        SimError: the cell cannot be set up.
    """
    with taking(spec) as taken:
        tell = taken.observer.tell
        taken.result = run_experiment(spec, tell) if run is None else run(tell)
    return taken
