"""The running cell in a browser on this machine, which can pause it and step from decision to decision."""

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from typing import Any

from cell.records import DecisionRecord
from experiments.observing.looks import Looks
from experiments.observing.observer import Observer
from experiments.observing.words import headline
from experiments.viewing.pace import Pace
from experiments.viewing.scene import Scene
from experiments.viewing.server import HOST, serving
from sim.networks.ground_truth import LatestTruth
from sim.runtime.pictures import Pictures
from sim.runtime.world import World

PORT = 8080  # the next free one where it is taken
SCENES_PER_SECOND, PICTURES_PER_SECOND = 15.0, 4.0
PICTURE = 240, 320  # px, height and width of the wrist camera's
_REST = 0.1  # s between two looks at the clock while nothing goes on
GONE_AFTER = 3.0  # s without a browser after which nobody watches; a page that is loaded anew is back sooner


class WebView:
    """Shows a world to browsers; `show` is called after every step, `tell` upon every record.

    Args:
        server: viser's.
        world: what is shown.
        observer: what is known of it; it is told of every record before this is.
        wrist: takes the wrist camera's pictures.
        looks: takes those of looks.
    """

    def __init__(self, server: Any, world: World, observer: Observer, wrist: Pictures, looks: Looks) -> None:
        self._server, self._world, self._observer = server, world, observer
        self._wrist, self._looks, self._pace = wrist, looks, Pace()
        self._scene = Scene(server, world)
        self._goes_on, self._stops_at_decision = threading.Event(), threading.Event()
        self._goes_on.set()
        self._shown_at, self._pictured_at = -1.0, -1.0
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        self._words = server.gui.add_markdown("")
        self._pause = server.gui.add_button("Pause")
        self._step = server.gui.add_button("To the next decision")
        self._live = server.gui.add_image(wrist.rgb("wrist"), label="wrist camera")
        self._look = server.gui.add_image(wrist.rgb("wrist"), label="newest look: mask, model at the estimated pose, u")
        self._pause.on_click(lambda _: self.go_on() if self.is_paused else self.pause())
        self._step.on_click(lambda _: self.step())
        self._draw()  # a browser that comes early sees the cell, not its bodies in one heap
        self._shown_at = self._pictured_at = -1.0

    @property
    def address(self) -> str:
        """Where a browser finds it."""
        return f"http://{HOST}:{self._server.get_port()}"

    @property
    def is_paused(self) -> bool:
        """Whether the cell stands still."""
        return not self._goes_on.is_set()

    def pause(self) -> None:
        """Has the cell stand still from the next step on."""
        self._goes_on.clear()
        self._pause.label = "Go on"

    def go_on(self) -> None:
        """Lets the cell go on until the next pause."""
        self._stops_at_decision.clear()
        self._pause.label = "Pause"
        self._goes_on.set()

    def step(self) -> None:
        """Lets the cell go on until the next decision."""
        self.go_on()
        self._stops_at_decision.set()

    def show(self) -> None:
        """Draws the world as it is, at most so many times per second; waits while it is to stand still."""
        now = self._world.time
        if now < self._shown_at:  # the world was reset
            self._shown_at = self._pictured_at = -1.0
        if now - self._shown_at < 1.0 / SCENES_PER_SECOND:
            return
        self._pace.keep(now)
        self._draw()
        self._wait()

    def tell(self, record: object, _: LatestTruth) -> None:
        """Shows a decision, and waits there if it is the one to stop at."""
        if isinstance(record, DecisionRecord):
            self._look.image = self._looks.overlaid(record, self._world.data.qpos)
            self._draw()
            if self._stops_at_decision.is_set():
                self.pause()
            self._wait()

    def wait_for_browser(self) -> None:
        """Returns when there is one."""
        while not self._server.get_clients():
            time.sleep(_REST)

    def stay(self) -> None:
        """Returns when no browser has been there for a while."""
        gone = 0.0
        while gone < GONE_AFTER:
            gone = 0.0 if self._server.get_clients() else gone + _REST
            time.sleep(_REST)

    def _draw(self) -> None:
        now, status = self._world.time, self._observer.newest
        look = None if status.decided is None else self._looks.overlaid(status.decided)
        self._scene.show(status, now, look=look)
        self._words.content = headline(status, now, self._world.parts).replace(" | ", "  \n")
        if now - self._pictured_at >= 1.0 / PICTURES_PER_SECOND:
            self._live.image, self._pictured_at = self._wrist.rgb("wrist"), now
        self._shown_at = now

    def _wait(self) -> None:
        while self.is_paused:
            self._goes_on.wait(_REST)


@contextmanager
def web_view(world: World, observer: Observer, port: int = PORT) -> Iterator[WebView]:
    """A view of a world for the block; the world goes as it would without, bit for bit, but not faster than real time.

    Raises:
        UsageError: viser is missing.
        GraphicsError: there is no off-screen OpenGL for the pictures.
    """
    with ExitStack() as stack:
        server = stack.enter_context(serving(port))
        wrist = stack.enter_context(closing(Pictures(world, *PICTURE, 1, shadows=0)))
        looks = stack.enter_context(closing(Looks(world)))
        view = WebView(server, world, observer, wrist, looks)
        before, world.on_step = world.on_step, view.show
        try:
            yield view
        finally:
            world.on_step = before
