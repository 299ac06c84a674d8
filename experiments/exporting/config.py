"""What a person sets for `graspcell export`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from experiments.errors import UsageError
from experiments.setup.checks import writable_folder


@dataclass(frozen=True)
class Export:
    """Write a run's experiments in a format of others: as a BOP dataset with its results, or as a LeRobot dataset.

    What the run did not keep is made by simulating its experiments again; they must come to the same bits, so the
    version and the machine are to be those of the run. Experiments without a result are left out.
    """

    run: Annotated[Path, tyro.conf.Positional]
    """Folder of a run, as compare or merge writes it."""
    bop: Path | None = None
    """Folder for a BOP dataset; made if missing, refused if it holds anything."""
    lerobot: Path | None = None
    """Folder for a LeRobot dataset, likewise. Needs the extra lerobot (PyAV)."""
    objects: tuple[str, ...] = ()
    """Names of parts; all of the run by default."""
    methods: tuple[str, ...] = ()
    """Methods; all of the run by default."""
    policies: tuple[str, ...] = ()
    """Policies by their names in the logs; all of the run by default."""
    experiments: tuple[int, ...] = ()
    """Numbers of experiments; all of the run by default."""
    rgb: bool = False
    """Write the wrist camera's pictures too, for LeRobot those of the overview as well; needs OpenGL."""
    depth: bool = False
    """For --bop, write depth images too; needs OpenGL."""
    fps: int = 10
    """For --lerobot, frames per second of the cell's clock: a divisor of 500."""

    @property
    def out(self) -> Path:
        """The folder to write to, tested by writing.

        Raises:
            UsageError: it cannot be written to or holds something; an invalid argument.
        """
        chosen = [folder for folder in (self.bop, self.lerobot) if folder is not None]
        if len(chosen) != 1:
            raise UsageError(f"expected --bop DIR or --lerobot DIR, got {'both' if chosen else 'neither'}")
        if self.depth and self.bop is None:
            raise UsageError("expected --bop with --depth, got --lerobot, whose datasets have none here")
        if not 1 <= self.fps <= 500 or 500 % self.fps:
            raise UsageError(f"expected --fps that divides 500, the steps per second, got {self.fps}")
        (out,) = chosen
        if any(writable_folder(out).iterdir()):
            raise UsageError(f"{out} is not empty: expected a new or empty folder")
        return out
