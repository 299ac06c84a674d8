"""An experiment watched while it runs: in MuJoCo's window, in a browser, by a recording."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from experiments.errors import UsageError
from experiments.observing.take import Tell, taking
from experiments.progress import saying
from experiments.setup.experiment import ExperimentSpec, kept_cell
from experiments.setup.names import WEB, WINDOW
from experiments.viewing.extras import load_rerun, load_viser
from experiments.viewing.recording import write_recording
from experiments.viewing.web import web_view
from sim.errors import GraphicsError
from sim.networks.ground_truth import LatestTruth
from sim.runtime.viewer import Window
from sim.runtime.world import World

_INTERVAL = 0.05  # s of the cell's clock between two poses of a recording


@contextmanager
def watched(
    spec: ExperimentSpec, view: str | None, recording: Path | None, say: Callable[[str], None], title: str
) -> Iterator[Tell]:
    """Watches what the process's cell of an experiment does in the block; yields what is to be told every record.

    Args:
        spec: the experiment.
        view: where it is shown; None for nowhere. With a browser, the block begins when one has come.
        recording: the Rerun file to write at the end; None for none.
        say: is given lines for the person who watches.
        title: the first of them; nothing is said if something is missing.

    Raises:
        UsageError: an extra is missing, there is no display for a window, or the file cannot be written.
        GraphicsError: there is no off-screen OpenGL for pictures.
    """
    told: list[Tell] = []
    if recording is not None:
        load_rerun()
    if view == WEB:
        load_viser()
    with ExitStack() as stack:
        if view == WINDOW:
            stack.enter_context(_window(kept_cell(*spec.cell).world))
        say(title)
        if view == WEB or recording is not None:
            told.append(stack.enter_context(_observed(spec, view, recording, say)))

        def tell(record: object, truth: LatestTruth) -> None:
            for one in told:
                one(record, truth)

        yield tell


@contextmanager
def _observed(
    spec: ExperimentSpec, view: str | None, recording: Path | None, say: Callable[[str], None]
) -> Iterator[Tell]:
    """Shows it in a browser, and writes the recording afterwards, as far as they are asked for."""
    with taking(spec) as taken, ExitStack() as stack:
        web = stack.enter_context(web_view(taken.world, taken.observer)) if view == WEB else None

        def tell(record: object, truth: LatestTruth) -> None:
            taken.observer.tell(record)
            if web is not None:
                web.tell(record, truth)

        if web is not None:
            say(f"open {web.address} in a browser on this machine; the experiment begins then")
            web.wait_for_browser()
        yield tell
        if web is not None:
            say("the view ends with its last page in the browser, or with Ctrl-C")
            web.stay()
    if recording is not None:
        with saying("write the recording"):
            write_recording(taken, recording, span=taken.span(None), interval=_INTERVAL)
        say(f"{recording}: open it with rerun {recording}")


@contextmanager
def _window(world: World) -> Iterator[None]:
    """MuJoCo's window, for the block."""
    try:
        window = Window(world)
    except GraphicsError as error:
        raise UsageError(
            "--view opens a window and needs a display with OpenGL, but there is none here; expected --view web, which "
            "shows the cell in a browser"
        ) from error
    before, world.on_step = world.on_step, window.show
    try:
        yield
    finally:
        world.on_step = before
        window.close()
