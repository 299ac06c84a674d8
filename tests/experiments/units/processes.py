"""Commands in processes of their own, and what they leave behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[3]
MARK = "GRASPCELL_TEST"  # in the environment of a command and of whatever it begins
_PRINTED = "printed.txt"


def begun(mark: str, folder: Path, *arguments: object) -> "subprocess.Popen[bytes]":
    """`graspcell` in a folder, in a session of its own; what it prints goes to a file there, see `printed`."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), MARK: mark}
    # A shell without job control starts what it puts into the background with interrupts ignored.
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with (folder / _PRINTED).open("w") as output:
            return subprocess.Popen(
                [sys.executable, "-m", "experiments.cli", *map(str, arguments)],
                cwd=folder,
                env=environment,
                start_new_session=True,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
    finally:
        signal.signal(signal.SIGINT, previous)


def printed(folder: Path) -> str:
    """What the last command in a folder has printed."""
    return (folder / _PRINTED).read_text(encoding="utf-8")


def marked(mark: str) -> list[int]:
    """The processes that a command with this mark has begun, and itself; those that have ended have no environment."""
    found = []
    for file in Path("/proc").glob("[0-9]*/environ"):
        try:
            if f"{MARK}={mark}".encode() in file.read_bytes().split(b"\0"):
                found.append(int(file.parent.name))
        except (OSError, ValueError):  # it ended meanwhile
            continue
    return found


def wait_until(holds: Callable[[], object], seconds: float = 120.0) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, f"waited for {seconds:g} s"
        time.sleep(0.05)
