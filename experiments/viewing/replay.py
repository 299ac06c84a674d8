"""An experiment in three dimensions as one HTML file, which a browser plays without a server. Needs `viser`."""

from contextlib import closing
from pathlib import Path

from experiments.observing.drawing import Image
from experiments.observing.looks import Looks
from experiments.observing.observer import Status
from experiments.observing.take import Take
from experiments.progress import counted
from experiments.results.files import write_text
from experiments.viewing.extras import load_viser
from experiments.viewing.moments import moments
from experiments.viewing.scene import Scene
from experiments.viewing.server import serving


def write_replay(taken: Take, path: Path, *, span: tuple[float, float], interval: float) -> None:
    """Writes the page; it holds viser's player, some 2 MB, and what the cell does.

    Args:
        taken: the experiment.
        path: the file.
        span: begin and end of what is shown, s of the cell's clock.
        interval: between two moments, s.

    Raises:
        UsageError: viser is missing, or the file cannot be written.
        GraphicsError: there is no off-screen OpenGL for the pictures.
    """
    load_viser()
    with serving() as server, closing(Looks(taken.world)) as looks:
        scene = Scene(server, taken.world)
        serializer = server.get_scene_serializer()
        for time in counted(moments(span, interval), "moment", "replay"):
            status = taken.observer.at(time)
            scene.show(status, time, taken.film.at(time), _look(taken, status, looks))
            serializer.insert_sleep(interval)
        page = serializer.as_html()
    write_text(path, page)


def _look(taken: Take, status: Status, looks: Looks) -> Image | None:
    if status.decided is None:
        return None
    return looks.overlaid(status.decided, taken.film.at(status.decided.observation.frame.time))
