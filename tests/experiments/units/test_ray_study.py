"""`compare --ray` on real clusters of several raylets on this machine; a cluster takes half a minute to start."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from experiments.units import ray_cluster
from experiments.units.identity import versions
from tests.experiments.command import Told, command, overriding
from tests.experiments.comparisons import contents
from tests.experiments.own import folder_with
from tests.experiments.units.processes import begun, marked, printed, wait_until

EXPERIMENTS = 12
SMALL = ("--parts", 1, "--speed", "fast", "--estimator", "oracle", "--objects", "antenna", "--methods", "none")
# Writes down where each experiment begins. The node named in the file `victim` holds its second experiment for good.
TELLING = """
import time
from pathlib import Path
import numba
import ray
from policies import Always

class Telling:
    def __init__(self, setup):
        self.fresh = True

    def decide(self, observation):
        if self.fresh and ray.is_initialized():
            assert numba.config.NUMBA_NUM_THREADS == 1
            node = ray.get_runtime_context().get_node_id()
            with open("begun", "a") as file:
                file.write(node + "\\n")
            if node == Path("victim").read_text() and Path("begun").read_text().count(node) >= 2:
                Path("held").touch()
                time.sleep(200)
        self.fresh = False
        return Always().decide(observation)
"""
KILLING = """
import os, signal
import ray
from policies import Always

class Killing:
    def __init__(self, setup):
        pass

    def decide(self, observation):
        if ray.is_initialized():
            with open("begun", "a") as file:
                file.write("x")
            os.kill(os.getpid(), signal.SIGKILL)
        return Always().decide(observation)
"""


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Three nodes of one core each."""
    from ray.cluster_utils import Cluster  # noqa: PLC0415

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    for _ in range(2):
        cluster.add_node(num_cpus=1)
    yield cluster
    cluster.shutdown()


def compared(capsys: pytest.CaptureFixture[str], out: Path, *arguments: object) -> Told:
    return command(capsys, "compare", *overriding(*SMALL, "--out", out, *arguments))


@pytest.mark.study
def test_a_cluster_that_loses_a_node_in_the_middle_writes_the_bytes_of_one_process(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cluster: Any
) -> None:
    arguments = ("--experiments", EXPERIMENTS, "--policy", "telling:Telling")
    with folder_with(tmp_path, {"telling": TELLING}, monkeypatch):
        victim = cluster.add_node(num_cpus=1)
        Path("victim").write_text(victim.node_id)

        def kill() -> None:
            wait_until(Path("held").exists)
            cluster.remove_node(victim, allow_graceful=False)

        killer = Thread(target=kill)
        killer.start()
        told = compared(capsys, tmp_path / "cluster", *arguments, "--ray", cluster.address)
        killer.join()
        assert f"{EXPERIMENTS} experiments expected = {EXPERIMENTS} completed + 0 failed" in told.out
        assert told.code == 0
        assert "raylet" not in told.out + told.err
        nodes = Path("begun").read_text().split()
        assert len(set(nodes)) == 4
        assert len(nodes) == EXPERIMENTS + 1, "the experiment that the lost node held was not begun twice"
        assert compared(capsys, tmp_path / "alone", *arguments, "--jobs", 1).code == 0
    files = contents(tmp_path / "cluster")
    assert len([name for name in files if name.startswith("units/")]) == EXPERIMENTS
    assert files == contents(tmp_path / "alone")


@pytest.mark.study
def test_an_experiment_that_kills_its_worker_each_time_has_failed_and_says_so(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cluster: Any
) -> None:
    arguments = ("--experiments", 1, "--policy", "killing:Killing")
    with folder_with(tmp_path, {"killing": KILLING}, monkeypatch):
        told = compared(capsys, tmp_path / "out", *arguments, "--ray", cluster.address)
        assert told.code == 3
        assert "1 experiments expected = 0 completed + 1 failed" in told.out
        assert "its worker process died 4 times" in told.out
        assert Path("begun").read_text() == "xxxx"


@pytest.mark.study
def test_a_node_with_another_version_is_refused_before_anything_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cluster: Any
) -> None:
    there = versions()
    monkeypatch.setattr(ray_cluster, "versions", lambda: {**there, "code": "another", "numpy": "1.0"})
    told = compared(capsys, tmp_path / "out", "--experiments", 1, "--ray", cluster.address)
    assert told.code == 2
    (line,) = [line for line in told.err.splitlines() if line]
    assert f"has code {there['code']}, here another; numpy {there['numpy']}, here 1.0" in line
    assert not (tmp_path / "out" / "units").exists()


@pytest.mark.study
def test_files_that_options_name_are_found_from_the_folder_of_the_command(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cluster: Any
) -> None:
    arguments = ("--parts", 1, "--speed", "fast", "--objects", "antenna", "--methods", "none", "--experiments", 1)
    monkeypatch.chdir(tmp_path)
    assert command(capsys, "compare", *arguments, "--out", "recorded").code == 0
    replay = ("compare", *arguments, "--estimator", "replay", "--recorded", "recorded")
    told = command(capsys, *replay, "--ray", cluster.address, "--out", "replayed")
    assert (told.code, told.err.count("error")) == (0, 0), told.err


@pytest.mark.study
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_a_signal_ends_a_cluster_of_this_machine_keeps_what_is_finished_and_leaves_no_process(
    tmp_path: Path, number: signal.Signals, code: int
) -> None:
    mark = f"{tmp_path}"
    arguments = ("compare", *SMALL, "--experiments", 500, "--jobs", 2, "--ray", "local", "--out", tmp_path / "out")
    process = begun(mark, tmp_path, *arguments)
    wait_until(lambda: len(list((tmp_path / "out").glob("units/*/0*.json.gz"))) >= 2)
    assert len(marked(mark)) > 3
    if number == signal.SIGINT:
        os.killpg(process.pid, number)  # as a terminal does
    else:
        process.send_signal(number)
    assert process.wait(60) == code
    out = printed(tmp_path)
    assert "Traceback" not in out
    if code > 0:
        assert "interrupted: 500 experiments expected" in out
        assert (tmp_path / "out" / "experiments.parquet").is_file()
    wait_until(lambda: not marked(mark))
