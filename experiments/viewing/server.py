"""viser's server, reached from this machine only."""

import io
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any

from experiments.viewing.extras import load_viser

HOST = "127.0.0.1"


@contextmanager
def serving(port: int = 0) -> Iterator[Any]:
    """A server for the block, which is stopped at its end.

    Args:
        port: where it listens; the next free one where that is taken, any free one for 0.

    Raises:
        UsageError: viser is missing.
    """
    viser = load_viser()
    with redirect_stdout(io.StringIO()):  # it says that it begins, and that it stops
        server = viser.ViserServer(host=HOST, port=port, verbose=False)
    try:
        yield server
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()
