"""`graspcell report`: one page that shows what runs came to, and why."""

from experiments.reporting.assemble import page
from experiments.reporting.config import Report
from experiments.reporting.data.source import read_sources
from experiments.reporting.pictures.illustrate import Asked, illustrate
from experiments.results.files import write_text
from experiments.setup.checks import worker_count


def report(config: Report) -> int:
    """Reads the runs and writes the page; returns the exit code.

    Raises:
        UsageError: an invalid argument, a folder without a run, or an experiment that does not come to the same again.
    """
    config.check()
    sources = read_sources(config.runs)
    illustrate(sources, Asked(config.most_pictures, worker_count(config.jobs), needed=config.pictures is not None))
    write_text(config.out, page(sources))
    for source in sources:
        for note in source.notes:
            print(note)
    print(f"report in {config.out}: open it in a browser")
    return 0
