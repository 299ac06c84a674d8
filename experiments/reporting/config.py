"""What a person sets for `graspcell report`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, writable_folder

_MOST_RUNS = 24
_PICTURES = 80  # some 6 MB and two minutes on 2 cores


@dataclass(frozen=True)
class Report:
    """Make one page that shows what runs came to and why each attempt ended as it did.

    The page is a single file that opens in any browser, without a network or a server: the table beside the paper's,
    all attempts and time-outs, failures first, what every method decided about a part, timelines and charts. Pictures
    are made by simulating experiments again: that needs the version and the machine of the run, and OpenGL.
    """

    runs: Annotated[tuple[Path, ...], tyro.conf.Positional]
    """Folders of runs, as compare or merge writes them; several stand side by side."""
    out: Path = Path("out/report.html")
    """The page, .html."""
    pictures: int | None = None
    """Attempts and time-outs to make pictures of, failures first; by default 80, fewer where a run cannot be simulated
    again."""
    jobs: int = 0
    """Processes to simulate in; 0 takes one per core."""

    @property
    def most_pictures(self) -> int:
        """How many attempts and time-outs get pictures."""
        return _PICTURES if self.pictures is None else self.pictures

    def check(self) -> None:
        """Rejects what cannot be.

        Raises:
            UsageError: says what, and why.
        """
        if not 1 <= len(self.runs) <= _MOST_RUNS or len({path.resolve() for path in self.runs}) < len(self.runs):
            given = " ".join(map(str, self.runs)) or "none"
            raise UsageError(f"expected 1 to {_MOST_RUNS} different folders of runs, got {given}")
        all_at_least(self, jobs=0, **({} if self.pictures is None else {"pictures": 0}))
        if self.out.suffix != ".html":
            raise UsageError(f"expected --out to end in .html, got {self.out}")
        writable_folder(self.out.parent)
        if self.out.is_dir():
            raise UsageError(f"cannot write {self.out}: expected the path of a page, got a folder")
