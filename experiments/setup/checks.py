"""Checks of command line options; each failure is one line that says what is valid."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

import os
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING

from experiments.errors import UsageError
from maskval.inputs.spelling import nearest, shown

if TYPE_CHECKING:
    from experiments.setup.thresholds import Thresholds
    from sim.model.parts import PartModel

FAILED = 3  # exit code of a command whose experiments, or some of them, failed
_MOST = 2**31 - 1  # what the logs' columns hold
_MOST_OF = {  # of counts: what lies beyond is a slip of the keyboard, and fills the memory or takes years
    "experiments": 100_000,
    "images": 10_000_000,
    "trials": 100_000,
    "resamples": 100_000,
    "rounds": 1000,
    "draws": 10_000,
    "worlds": 10_000,
    "samples": 64,
    "views_per_heap": 1000,
    "after": 8,
}
_JOBS_PER_CORE, _FEW_JOBS = 4, 16  # more processes than cores only wait for one another


def check_cell(parts: int, seed: int, speed: str) -> None:
    """Raises UsageError unless the cell can be run with these options."""
    from cell.arm.limits import PRESETS
    from cell.layout import Container

    container = Container()
    slots = container.rows * container.columns
    if not 1 <= parts <= slots:
        raise UsageError(f"expected --parts in 1..{slots}, the container's slots, got {parts}")
    at_least("--seed", seed, 0)
    one_of("--speed", speed, tuple(PRESETS))


def check_part_and_method(part: str, method: str, thresholds: "Thresholds") -> str:
    """The part's name; raises UsageError unless part, error model, method and threshold exist."""
    from experiments.setup.methods import known_method
    from sim.errors import SimError
    from sim.model.parts import load_part
    from sim.networks.noise_model import load_noise

    try:
        model = load_part(part)
        load_noise(model.noise)
    except SimError as error:
        raise UsageError(str(error)) from error
    warn_of_part(model)
    known_method(method, model.part, thresholds, source=part)
    return model.part.name


@cache
def warn_of_part(model: "PartModel") -> None:
    """Says on stderr, once a process, what in a part's file works but is probably not meant."""
    from sim.parts.part_checks import warnings_of

    for line in warnings_of(model.part, model.resting_poses, model.pieces):
        print(f"graspcell: warning: {model.part.name}: {line}", file=sys.stderr)


def at_least(name: str, value: int, least: int, most: int = _MOST) -> None:
    """Raises UsageError unless the option's value is within its bounds; by default what the logs' columns hold."""
    if not least <= value <= most:
        raise UsageError(f"expected {name} of at least {least} and at most {most}, got {shown(value)}")


def all_at_least(config: object, **least: int) -> None:
    """Raises UsageError unless each of these options, named by its field, is within the bounds of its kind."""
    for name, value in least.items():
        most = most_jobs() if name == "jobs" else _MOST_OF.get(name, _MOST)
        at_least(f"--{name.replace('_', '-')}", getattr(config, name), value, most)


def most_jobs() -> int:
    """Processes that this machine has use for."""
    return max(_FEW_JOBS, _JOBS_PER_CORE * worker_count(0))


def one_of(name: str, value: str, valid: tuple[str, ...]) -> None:
    """Raises UsageError unless the option's value is one of the valid ones."""
    if value not in valid:
        raise UsageError(
            f"unknown {name.removeprefix('--')} {value!r}: expected one of {', '.join(valid)}{nearest(value, valid)}"
        )


def writable_folder(folder: Path) -> Path:
    """The folder, made if missing and tested by writing.

    Raises:
        UsageError: it cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except OSError as error:
        raise UsageError(f"cannot write to {folder}: {error.strerror or error}; expected a writable folder") from error
    return folder


def worker_count(jobs: int) -> int:
    """Processes to use for a number of jobs, of which 0 means one per core."""
    return jobs or os.cpu_count() or 1
