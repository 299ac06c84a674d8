"""`python -m benchmarks.instance_ids`: instance ids by geometry against those of MuJoCo's renderer, and their time.

Compares both in every n-th period of the controller, through whole experiments of several conditions. Needs OpenGL.
"""

import argparse
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field

import numpy as np

from experiments.commands.config import Compare
from experiments.setup.experiment import kept_cell, run_experiment
from sim.instance_ids import NO_INSTANCE
from sim.model.conditions import Conditions
from sim.model.renderer import Renderer
from sim.runtime.episode import SimCell

CONDITIONS = {
    "undisturbed": Conditions(),
    "distractors": Conditions(clutter="distractors"),
    "touching": Conditions(clutter="touching"),
    "moving belt": Conditions(belt_speed=0.1),
    "displaced camera": Conditions(
        hand_eye_error_mm=(5.0, -8.0, 6.0),
        hand_eye_error_deg=(1.0, 2.0, -3.0),
        focal_error_percent=5.0,
        principal_point_error_px=(12.0, -7.0),
    ),
}


@dataclass
class Comparison:
    """What was counted: per state the pixels that differ and those of parts, and process times, s."""

    differing: list[int] = field(default_factory=list)
    shown: list[int] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=lambda: {"geometry": 0.0, "OpenGL": 0.0})

    def timed(self, name: str, ids: Callable[[], np.ndarray]) -> np.ndarray:
        """The instance ids; their time is added to that of the name."""
        begin = time.process_time()
        found = ids()
        self.seconds[name] += time.process_time() - begin
        return found

    def __str__(self) -> str:
        share = 100 * np.array(self.differing) / (640 * 480)
        ms = ", ".join(f"{name} {1e3 * spent / len(share):.2f} ms" for name, spent in self.seconds.items())
        return (
            f"{len(share)} states, {np.count_nonzero(self.shown)} with parts; differing pixels of the image: mean "
            f"{share.mean():.5f} %, worst {share.max():.5f} %; process time: {ms}"
        )


def compare_every(period: int, cell: SimCell, renderer: Renderer, into: Comparison) -> Callable[[], None]:
    """What compares when it is called, once in so many calls."""
    world, calls = cell.world, 0

    def step() -> None:
        nonlocal calls
        calls += 1
        if calls % period:
            return
        X_CO_true = [world.X_CO(part) for part in range(world.parts)]
        ours = into.timed("geometry", lambda: cell.camera.instance_ids(X_CO_true))
        theirs = into.timed("OpenGL", lambda: renderer.instance_ids(world.data, "wrist"))
        into.differing.append(int(np.count_nonzero(ours != theirs)))
        into.shown.append(int(np.count_nonzero(theirs != NO_INSTANCE)))

    return step


def main() -> None:
    """Runs the experiments and prints a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=250, help="periods of the controller between two comparisons")
    arguments = parser.parse_args()
    for name, conditions in CONDITIONS.items():
        for part in ("antenna", "handle"):
            compare = Compare(
                objects=(part,), methods=("maskval",), experiments=1, conditions=conditions, thresholds="paper"
            )
            (spec,) = compare.specs()
            cell, found = kept_cell(*spec.cell), Comparison()
            with closing(Renderer(cell.world.mj_model, 480, 640)) as renderer:
                cell.world.on_step = compare_every(arguments.every, cell, renderer, found)
                run_experiment(spec)
                cell.world.on_step = None
            print(f"{part}, {name}: {found}", flush=True)


if __name__ == "__main__":
    main()
