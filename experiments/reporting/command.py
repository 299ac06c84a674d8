"""`graspcell report`: one page that shows what runs came to, and why."""

from experiments.reporting.config import Report
from experiments.reporting.page import page
from experiments.reporting.source import read_sources
from experiments.results.files import write_text

_PICTURELESS = "The wrist picture, the overview and the true pose were not made for this one."


def report(config: Report) -> int:
    """Reads the runs and writes the page; returns the exit code.

    Raises:
        UsageError: an invalid argument, or a folder without a run.
    """
    config.check()
    sources = read_sources(config.runs)
    write_text(config.out, page(sources, _PICTURELESS))
    print(f"report in {config.out}: open it in a browser")
    return 0
