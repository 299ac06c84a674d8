"""Runs that are killed a hundred times, at random moments, end in the bytes of an undisturbed one."""

import os
import random
import signal
import subprocess
from pathlib import Path

import pytest

from tests.experiments.comparisons import contents
from tests.experiments.units.processes import begun, marked, printed, wait_until

KILLS = 100
LONGEST = 12.0  # s from a start, or from a worker's kill, to the next kill; a whole run takes some 15 s
EXPERIMENTS = 30  # of each of two methods
# --retry-failed: an experiment whose worker is killed twice in a row has failed, for all that the command can tell.
COMMAND = (
    *("compare", "--jobs", 2, "--parts", 1, "--speed", "fast", "--estimator", "oracle", "--seed", 3, "--retry-failed"),
    *("--objects", "antenna", "--methods", "none", "maskval", "--experiments", EXPERIMENTS, "--out", "run"),
)


def killed_on_the_way(folder: Path, draws: random.Random) -> list[str]:
    """Begins the command again and again until it comes to its end; says whom the kills hit."""
    hit, mark = list[str](), str(folder)
    process = begun(mark, folder, *COMMAND)
    while True:
        try:
            code = process.wait(draws.uniform(0.0, LONGEST))
            if code == 0:
                return hit
            assert code in (1, 3), printed(folder)  # too many workers died, or experiments failed
        except subprocess.TimeoutExpired:
            whom = struck(process, mark, draws)
            hit += whom
            if whom != ["command"]:
                continue
            process.wait()
        wait_until(lambda: not marked(mark))  # its workers end with it
        process = begun(mark, folder, *COMMAND)


def struck(process: "subprocess.Popen[bytes]", mark: str, draws: random.Random) -> list[str]:
    """Kills the command, or one of the processes that it has begun; says which, if that had not ended meanwhile."""
    workers = sorted(set(marked(mark)) - {process.pid})
    if workers and draws.random() < 0.5:
        try:
            os.kill(draws.choice(workers), signal.SIGKILL)
        except ProcessLookupError:
            return []
        return ["worker"]
    process.kill()
    return ["command"]


@pytest.mark.study
def test_runs_killed_a_hundred_times_end_in_the_bytes_of_an_undisturbed_one(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    whole.mkdir()
    assert begun("whole", whole, *COMMAND).wait() == 0, printed(whole)
    expected = contents(whole / "run")
    assert len([name for name in expected if name.startswith("units/")]) == 2 * EXPERIMENTS
    draws, hit, runs = random.Random(12), list[str](), 0
    while len(hit) < KILLS:
        folder = tmp_path / f"killed-{runs}"
        folder.mkdir()
        hit += killed_on_the_way(folder, draws)
        assert contents(folder / "run") == expected, printed(folder)
        runs += 1
    assert min(hit.count("command"), hit.count("worker")) > KILLS / 5
    figures = f"{hit.count('command')} kills of the command, {hit.count('worker')} of its workers, in {runs} runs"
    print(figures)  # with pytest -s
