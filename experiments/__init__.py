"""Experiments in the simulated cell: the only place with a command line, files, seeds and printing."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.reading.run import Run


def load(folder: Path | str) -> "Run":
    """The tables of a run: see `experiments.reading.run.load`."""
    from experiments.reading.run import load as load_run  # noqa: PLC0415  # loads Arrow, which --help does not wait for

    return load_run(Path(folder))
