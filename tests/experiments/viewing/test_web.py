"""The view in a browser, without one: its page is asked for, its buttons are pressed by the test."""

import threading
import time
import urllib.request
from collections.abc import Iterator
from typing import Any

import pytest

from experiments.observing.observer import Observer
from experiments.observing.take import Take
from experiments.viewing.web import WebView, web_view
from sim.networks.ground_truth import LatestTruth

TRUTH = LatestTruth()


@pytest.fixture(scope="module")
def view(taken: Take) -> Iterator[WebView]:
    with web_view(taken.world, Observer(taken.world), port=0) as view:
        yield view
    assert taken.world.on_step is None


def in_thread(job: Any) -> threading.Thread:
    thread = threading.Thread(target=job, daemon=True)
    thread.start()
    return thread


def test_the_page_is_served_on_this_machine_alone(view: WebView) -> None:
    assert view.address.startswith("http://127.0.0.1:")
    assert view._server.get_host() == "127.0.0.1"
    with urllib.request.urlopen(view.address, timeout=10) as answer:
        assert answer.status == 200
        assert b"<html" in answer.read()


def test_the_experiment_begins_when_a_browser_has_come(view: WebView, monkeypatch: pytest.MonkeyPatch) -> None:
    clients: dict[int, object] = {}
    monkeypatch.setattr(view._server, "get_clients", lambda: clients)
    waiting = in_thread(view.wait_for_browser)
    waiting.join(0.3)
    assert waiting.is_alive()
    clients[0] = object()
    waiting.join(5.0)
    assert not waiting.is_alive()


def test_a_paused_cell_stands_still_until_it_is_to_go_on(view: WebView, taken: Take) -> None:
    view.pause()
    times: list[float] = []

    def go_on_later() -> None:
        for _ in range(3):
            time.sleep(0.1)
            times.append(taken.world.time)
        view.go_on()

    going = in_thread(go_on_later)
    begun = taken.world.time
    for _ in range(100):
        taken.world.step()
    going.join(5.0)
    assert len(times) == 3
    assert len(set(times)) == 1
    assert begun < times[0] < taken.world.time == pytest.approx(begun + 100 * taken.world.time_step)


def test_a_step_ends_at_the_next_decision_and_shows_its_u(view: WebView, taken: Take) -> None:
    decided = next(one for one in taken.observer.decisions() if one.decision.detection is not None)
    view._observer.tell(decided)
    view.tell(decided, TRUTH)
    assert not view.is_paused
    view.step()
    telling = in_thread(lambda: view.tell(decided, TRUTH))
    telling.join(0.5)
    assert telling.is_alive()
    assert view.is_paused
    assert f"u = {decided.observation.uncertainties[decided.decision.detection]:.3f}" in view._words.content
    assert view._look.image.shape == (480, 640, 3)
    view.go_on()
    telling.join(5.0)
    assert not telling.is_alive()


def test_nothing_offers_to_share_the_cell_with_the_world(view: WebView) -> None:
    themes = [
        message
        for message in view._server._websock_server._broadcast_buffer.message_from_id.values()
        if type(message).__name__ == "ThemeConfigurationMessage"
    ]
    assert themes
    assert not themes[-1].show_share_button
