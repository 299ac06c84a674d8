"""`python -m tests.experiments.units.killed_runs FOLDER KILLS`: a comparison whose process is killed so many times.

Each try is a fork of this process, which has compiled the cell before, so that a try takes no longer than its
experiments. Prints how many tries were killed, and the exit code of the last one, which nobody kills.
"""

import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from experiments.cli import main
from experiments.setup.experiment import kept_cell
from sim.model.conditions import Conditions

EXPERIMENTS = 40
LONGEST = 0.25  # s: one or two experiments


def compare(out: Path) -> None:
    arguments = ["--objects", "antenna", "--methods", "none", "--experiments", str(EXPERIMENTS), "--parts", "1"]
    main(["compare", *arguments, "--estimator", "oracle", "--speed", "fast", "--jobs", "1", "--out", str(out)])


def tried(out: Path, lifetime: float | None) -> int:
    """The wait status of a try: killed after its lifetime, s, or left alone."""
    child = os.fork()
    if child == 0:
        with Path(os.devnull).open("w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            os.dup2(nowhere.fileno(), 2)
            try:
                compare(out)
            except SystemExit as end:
                os._exit(int(end.code or 0))
    if lifetime is not None:
        time.sleep(lifetime)
        os.kill(child, signal.SIGKILL)
    return os.waitpid(child, 0)[1]


def run(out: Path, kills: int) -> tuple[int, int]:
    """How many tries were killed, of so many, and the exit code of the last."""
    kept_cell("antenna", 1, Conditions(), False)
    lifetimes = np.random.default_rng(12).uniform(0.0, LONGEST, kills)
    killed = sum(os.WIFSIGNALED(tried(out, lifetime)) for lifetime in lifetimes)
    return killed, os.waitstatus_to_exitcode(tried(out, None))


if __name__ == "__main__":
    print(*run(Path(sys.argv[1]), int(sys.argv[2])))
