"""Runs experiments on a Ray cluster, of this machine or of many.

Ray runs a task again when its worker is lost, so that one may run twice; its unit is the same, and is written once.
"""

import contextlib
import importlib
import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.pool import ONE_THREAD, Died
from experiments.units.execution import Executor, Ran, Stream
from experiments.units.identity import describe, versions
from experiments.units.unit import place, run_unit

LOCAL = "local"
_RETRIES = 3  # of an experiment whose worker is lost, for whatever reason
_AHEAD = 2  # experiments that are submitted per core: one runs, and one waits
_CONNECT_S = 10.0  # to wait for the head node's answer
_STORE_BYTES = 100 * 2**20  # of a cluster of this machine; a unit has some kB


def on_ray(address: str, jobs: int) -> Executor:
    """Runs experiments as tasks of one core each.

    Args:
        address: `local` starts a cluster on this machine, which ends with the run; `auto` joins the one that runs on
            this machine, HOST:PORT one whose head node is there.
        jobs: cores of a cluster of this machine.

    Returns:
        An executor. It raises UsageError if Ray is missing, the cluster cannot be reached, or one of its nodes has
        another version of the package.
    """

    def run(specs: Sequence[ExperimentSpec]) -> Stream:
        _check_address(address)
        ray = _imported()
        with _connected(ray, address, jobs, modules_of(specs)):
            _check_nodes(ray)
            yield from _completed(ray, specs)

    return run


def _imported() -> Any:
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"  # nothing is told to anybody
    os.environ.setdefault("RAY_task_oom_retries", str(_RETRIES))  # Ray's own is without end
    try:
        return importlib.import_module("ray")
    except ImportError as error:
        raise UsageError(f"--ray needs Ray ({error}): pip install 'graspcell[ray]'") from error


@contextlib.contextmanager
def _connected(ray: Any, address: str, jobs: int, modules: list[str]) -> Iterator[None]:
    """Connects this process; a cluster that this begins ends with it.

    Raises:
        UsageError: it cannot be reached, or has another version of Ray or of Python.
    """
    own = {"num_cpus": jobs, "object_store_memory": _STORE_BYTES, "include_dashboard": False}
    environment = {"env_vars": dict.fromkeys(ONE_THREAD, "1")} | ({"py_modules": modules} if modules else {})
    try:
        with _sigterm_kept():
            ray.init(
                address,
                runtime_env=environment,
                log_to_driver=False,
                logging_level="CRITICAL",
                **(own if address == LOCAL else {}),
            )
    except (OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        raise UsageError(f"cannot use the Ray cluster {address}: {_told(error)}") from error
    # Ray has no option for this: it would print on stdout, among the results, that a node is lost.
    importlib.import_module("ray._private.worker")._worker_logs_enabled = False  # type: ignore[attr-defined]
    try:
        yield
    finally:
        ray.shutdown()


def _check_address(address: str) -> None:
    """Raises UsageError unless somebody answers there, which Ray itself would wait for and then abort."""
    if address in (LOCAL, "auto"):
        return  # for `auto`, Ray itself says at once that there is none
    host, _, port = address.rpartition(":")
    if not host or "/" in host or not port.isdecimal():
        raise UsageError(f"expected --ray local, auto, or HOST:PORT of a cluster's head node, got {address!r}")
    try:
        socket.create_connection((host, int(port)), _CONNECT_S).close()
    except (OSError, OverflowError) as error:
        raise UsageError(
            f"no Ray cluster answers at {address} ({error}): expected the head node's address, as ray start --head "
            "prints it"
        ) from error


@contextlib.contextmanager
def _sigterm_kept() -> Iterator[None]:
    """Ray sets a handler of its own, which would end this process before it writes its table."""
    before = signal.getsignal(signal.SIGTERM)
    try:
        yield
    finally:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, before)


def modules_of(specs: Sequence[ExperimentSpec]) -> list[str]:
    """Files and folders of the plug-ins that are not installed: they travel to the nodes."""
    names = {name for spec in specs for name in (spec.method, spec.policy, spec.estimator)}
    tops = sorted({name.partition(":")[0].partition(".")[0] for name in names if name is not None and ":" in name})
    found = []
    for top in tops:
        module = importlib.import_module(top)
        path = Path(next(iter(module.__path__)) if hasattr(module, "__path__") else str(module.__file__)).resolve()
        if not path.is_relative_to(Path(sys.prefix).resolve()):
            found.append(str(path))
    return found


def _check_nodes(ray: Any) -> None:
    """Raises UsageError unless every node has this version of the package and of what decides its numbers."""
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy as On  # noqa: PLC0415

    def found() -> object:  # within a function, so that it reaches a node that lacks the package
        try:
            from experiments.units.identity import versions  # noqa: PLC0415
        except ImportError as error:
            return str(error)
        return versions()

    nodes = [node for node in ray.nodes() if node["Alive"] and node["Resources"].get("CPU")]
    if not nodes:
        raise UsageError("the Ray cluster has no cores: expected nodes that ray start has begun with some")
    on_each = [
        ray.remote(found).options(num_cpus=0, scheduling_strategy=On(node["NodeID"], soft=False)).remote()
        for node in nodes
    ]
    for node, answer in zip(nodes, on_each, strict=True):
        where = f"the Ray node {node['NodeManagerAddress']} ({node['NodeManagerHostname']})"
        try:
            there = ray.get(answer)
        except (ray.exceptions.TaskUnschedulableError, ray.exceptions.NodeDiedError):
            continue  # it has left meanwhile
        except ray.exceptions.RayError as error:
            raise UsageError(f"{where} runs no task: {_told(error)}") from error
        if not isinstance(there, dict):
            raise UsageError(f"{where} cannot import graspcell ({there}): expected the same installation on every node")
        other = [
            f"{name} {there.get(name)}, here {here}" for name, here in versions().items() if there.get(name) != here
        ]
        if other:
            raise UsageError(f"{where} has {'; '.join(other)}: expected the same installation on every node")


def _completed(ray: Any, specs: Sequence[ExperimentSpec]) -> Stream:
    """Yields every experiment as it ends; only a few per core are submitted at any time."""
    task = ray.remote(_run).options(num_cpus=1, max_retries=_RETRIES)
    left, here = iter(specs), os.getcwd()
    under_way: dict[Any, ExperimentSpec] = {}
    try:
        while True:
            most = _AHEAD * max(1, int(ray.cluster_resources().get("CPU", 1)))  # nodes may join
            for spec in islice(left, max(0, most - len(under_way))):
                under_way[task.remote(spec, here)] = spec
            if not under_way:
                return
            (done,), _ = ray.wait(list(under_way), num_returns=1)
            spec = under_way.pop(done)
            yield spec, _result(ray, done, spec)
    finally:
        for reference in under_way:
            ray.cancel(reference, force=True)


def _run(spec: ExperimentSpec, folder: str) -> Ran:
    """On a node: runs an experiment in the command's own folder, where there is one."""
    with contextlib.suppress(FileNotFoundError):
        os.chdir(folder)
    return run_unit(spec)


def _result(ray: Any, reference: Any, spec: ExperimentSpec) -> Ran | Died:
    """What a task came to.

    Raises:
        SimError: the cell cannot be set up.
        UsageError: likewise, or the node ran something else, or the cluster is lost.
    """
    lost = ("WorkerCrashedError", "NodeDiedError", "OutOfMemoryError", "ObjectLostError")
    try:
        ran: Ran = ray.get(reference)
    except ray.exceptions.RayTaskError as error:
        raise (error.cause if isinstance(error.cause, Exception) else error) from error
    except tuple(getattr(ray.exceptions, name) for name in lost):
        return Died(1 + _RETRIES)
    except ray.exceptions.RayError as error:
        raise UsageError(f"the Ray cluster is lost ({_told(error)}); the same command goes on") from error
    expected = place(describe(spec))
    if ran[0] != expected:
        raise UsageError(
            f"a Ray node ran {ran[0]}, expected {expected}: expected the same plug-ins and parts on every node"
        )
    return ran


def _told(error: Exception) -> str:
    """What Ray says of an error in its last line; before that it says where it was."""
    return f"{type(error).__name__}: {(str(error).strip().splitlines() or ['no reason given'])[-1]}"
