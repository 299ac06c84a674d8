"""`graspcell merge`: joins the shares of a run into one folder."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from experiments.errors import UsageError


@dataclass(frozen=True)
class Merge:
    """Join the folders of a run's shards into one run, and print its table.

    What is missing is said, and compare without --shard in the new folder runs it. The folders stay as they are.
    """

    folders: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Folders that compare --shard has written."""
    overwrite: bool = False
    """Remove the results that are in --out first."""
    out: Path = Path("out/merged")
    """Folder for the run; made if missing, or one to which the others are added."""


def merge(config: Merge) -> int:
    """Copies every unit once, then prints and writes the table; returns the exit code.

    Raises:
        UsageError: a folder holds no run, or runs of different kinds, or two results of one experiment.
    """
    from experiments.commands.compare import report  # noqa: PLC0415  # loads the engine
    from experiments.progress import counted  # noqa: PLC0415
    from experiments.units.run_folder import RunFolder  # noqa: PLC0415

    if not config.folders:
        raise UsageError("expected the folders of at least one shard, got none")
    if config.out.resolve() in {folder.resolve() for folder in config.folders}:
        raise UsageError(f"expected --out to be none of the folders to be joined, got {config.out}")
    shards = [RunFolder.read(folder) for folder in config.folders]
    with RunFolder.opened(config.out, overwrite=config.overwrite) as folder:
        for shard in shards:
            folder.ask(shard.asked, shard.options)
        for shard in shards:
            for place, ok, packed in counted(shard.files(), "experiment", f"join {shard.path}"):
                folder.add(place, packed, ok=ok)
        return report(folder, None)
