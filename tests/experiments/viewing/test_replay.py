"""The page that replays an experiment holds where everything was, and needs nothing from outside."""

import base64
import re
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import zstandard

from experiments.observing.take import Take
from experiments.viewing.moments import moments
from experiments.viewing.replay import write_replay


def content_of(page: str) -> dict[str, Any]:
    """What viser's player is given: a length, then compressed: the length of a message pack, and that."""
    (data,) = re.findall(r'__VISER_EMBED_DATA__="([^"]+)"', page)
    inner = zstandard.ZstdDecompressor().decompressobj().decompress(base64.b64decode(data)[8:])
    length = int.from_bytes(inner[:8], "little")
    found: dict[str, Any] = msgspec.msgpack.decode(inner[8 : 8 + length])
    return found


def test_the_last_place_of_each_part_is_where_it_was_at_that_time(taken: Take, tmp_path: Path) -> None:
    path, span = tmp_path / "replay.html", taken.span(0)
    write_replay(taken, path, span=span, interval=0.5)
    page = path.read_text(encoding="utf-8")
    assert len(page) < 3e6
    assert re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="(?:https?:)?//', page) == []
    content = content_of(page)
    assert content["durationSeconds"] == pytest.approx(0.5 * len(moments(span, 0.5)))
    places: dict[str, Any] = {}
    for _, message in content["messages"]:
        if message["type"] == "SetPositionMessage":
            places[message["name"]] = message["position"]
    assert {"/part_0", "/part_1", "/camera"} <= places.keys()
    lifted = taken.film.at(span[1])
    for part in range(2):
        joint = int(taken.world.mj_model.body_jntadr[taken.world.mj_model.body(f"part_{part}").id])
        address = int(taken.world.mj_model.jnt_qposadr[joint])
        assert np.abs(np.array(places[f"/part_{part}"]) - lifted[address : address + 3]).max() < 2e-4


def test_moments_are_one_interval_apart_and_end_with_the_span() -> None:
    assert moments((1.0, 2.0), 0.5) == [1.0, 1.5, 2.0]
    assert moments((0.0, 0.7), 0.5) == [0.0, 0.5, 0.7]
    assert moments((3.0, 3.0), 0.5) == [3.0]
