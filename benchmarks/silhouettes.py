"""Our silhouettes, depths and overlaps beside those of ready-made renderers: `python -m benchmarks.silhouettes`.

Every contender runs in a process of its own and they take turns, so that in each round all meet the same machine:
ratios are medians of the rounds' ratios, times are medians. What is not installed is named as missing.
"""

import argparse
import json
import multiprocessing
import os
import platform
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from benchmarks.peers import OURS, PEERS
from benchmarks.scaling import floor, scaling
from benchmarks.worker import serve
from benchmarks.workload import CAMERAS, OBJECTS, load_mesh, poses
from maskval import silhouette

BASE = "ours at the base"
JOBS = ("mask", "depth", "task")
PACKAGES = ("numpy", "numba", "mujoco", "pyrender-maintained", "PyOpenGL", "open3d", "open3d-cpu", "deodr", "moderngl")


class Worker:
    """A contender's process and the line to it.

    Args:
        name: Name of the contender.
        root: The checkout of this repository that the process runs, with its own benchmarks; None for this one.
    """

    def __init__(self, name: str, root: Path | None = None) -> None:
        module, environment = PEERS[name]
        context = multiprocessing.get_context("spawn")
        self._line, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(module, environment, theirs), daemon=True)
        with _imported_from(root):  # a spawned process takes the path of its parent
            self._process.start()
        theirs.close()
        # Why it is missing, or None.
        self.missing: str | None = self._receive()

    def ask(self, *request: Any) -> Any:
        """The answer to a request."""
        self._line.send(request)
        return self._receive()

    def stop(self) -> None:
        """Ends the process."""
        if self._process.is_alive():
            self._line.send(None)
            self._process.join(10)
        self._process.terminate()

    def _receive(self) -> Any:
        try:
            return self._line.recv()
        except EOFError:
            self._process.join()
            return f"the process ended with code {self._process.exitcode}"


@contextmanager
def _imported_from(root: Path | None) -> Iterator[None]:
    path = list(sys.path)
    if root is not None:
        sys.path.insert(0, str(root.resolve(strict=True)))
    try:
        yield
    finally:
        sys.path[:] = path


def started(peers: Iterable[str], base: Path | None) -> tuple[dict[str, Worker], dict[str, str]]:
    """The contenders that run, and why the others do not."""
    found = {name: Worker(name) for name in peers}
    if base is not None:
        found[BASE] = Worker(OURS, base)
    missing = {name: worker.missing for name, worker in found.items() if worker.missing is not None}
    for name, why in missing.items():
        print(f"missing: {name}: {why}")
    return {name: worker for name, worker in found.items() if name not in missing}, missing


def wrong_pixels(answer: tuple[float, NDArray[np.uint8]], name: str, camera: str) -> tuple[int, int]:
    """Pixels that differ from the NumPy kernel's, which the tests hold against float64 triangles; and all of them."""
    pixel_center, packed = answer
    size = CAMERAS[camera]
    theirs = np.unpackbits(packed, axis=-1, count=size.width).astype(bool)
    ours = [
        silhouette(load_mesh(name), X_CO, size, pixel_center=pixel_center, implementation="numpy").mask
        for X_CO in poses(name, camera)
    ]
    return int(np.count_nonzero(theirs != ours)), int(np.count_nonzero(ours))


def time_all(workers: dict[str, Worker], rounds: int) -> dict[tuple[str, str, str], dict[str, list[float]]]:
    """Seconds of every job of every contender, round by round."""
    cases = list(product(OBJECTS, CAMERAS, JOBS))
    times: dict[tuple[str, str, str], dict[str, list[float]]] = {case: {name: [] for name in workers} for case in cases}
    rng = np.random.default_rng(0)
    for _ in tqdm(range(rounds), unit="round"):
        for case in cases:
            for name in rng.permutation(list(workers)).tolist():
                times[case][name].append(workers[name].ask("time", *case))
    return times


def summary(times: dict[str, list[float]]) -> dict[str, dict[str, float]]:
    """Median microseconds of each contender, and how many times as long as ours it takes, with the quartiles."""
    ours = np.array(times[OURS])
    return {
        name: {
            "us": float(np.median(seconds)) * 1e6,
            "times_ours": float(np.median(np.array(seconds) / ours)),
            "times_ours_quartiles": np.quantile(np.array(seconds) / ours, (0.25, 0.75)).tolist(),
        }
        for name, seconds in times.items()
    }


def versions() -> dict[str, str | None]:
    """The installed versions of what is compared."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--json", type=Path, required=True, help="file for the figures")
    parser.add_argument("--rounds", type=int, default=15, help="turns of every contender")
    parser.add_argument(
        "--base", type=Path, help="a checkout of another commit, whose maskval takes turns with the rest"
    )
    parser.add_argument("--ours-only", action="store_true", help="leave other software out")
    options = parser.parse_args()
    before = os.getloadavg()
    workers, missing = started((OURS,) if options.ours_only else PEERS, options.base)
    try:
        tables = {name: worker.ask("table", "antenna", "VGA") for name, worker in workers.items()}
        times = time_all(workers, options.rounds)
        # Asked for last, so that it is what was timed that is looked at.
        pixels = {name: {} for name in workers}
        for name, worker in workers.items():
            for which, camera in product(OBJECTS, CAMERAS):
                wrong, total = wrong_pixels(worker.ask("masks", which, camera), which, camera)
                pixels[name][f"{which} {camera}"] = {"wrong": wrong, "of": total}
    finally:
        for worker in workers.values():
            worker.stop()
    between = os.getloadavg()
    figures = {
        "machine": {"cores": os.cpu_count(), "processor": platform.machine(), "python": platform.python_version()},
        "load_average_1_min": {"before": before[0], "after_rounds": between[0]},
        "versions": versions(),
        "rounds": options.rounds,
        "missing": missing,
        "triangles": {name: len(load_mesh(name).faces) for name in OBJECTS},
        "pixels": pixels,
        # The same poses against masks 3 px off: contenders at another pixel centre have other masks.
        "mean_iou_of_task": {name: float(np.diagonal(iou).mean()) for name, (iou, _) in tables.items()},
        "mean_visibility_of_task": {name: float(v.mean()) for name, (_, v) in tables.items()},
        "jobs": {" | ".join(case): summary(found) for case, found in times.items()},
        "floor": {
            f"{name} | {camera}": floor(name, camera)
            | {"ours_us": float(np.median(times[name, camera, "task"][OURS])) * 1e6}
            for name, camera in product(OBJECTS, CAMERAS)
        },
        "scaling": scaling(),
    }
    options.json.parent.mkdir(parents=True, exist_ok=True)
    options.json.write_text(json.dumps(figures, indent=1) + "\n")
    if BASE in workers:
        for case, found in figures["jobs"].items():
            times_ours = found[BASE]["times_ours"]
            print(f"{case}: {found[BASE]['us']:.0f} µs at the base, {found[OURS]['us']:.0f} µs now, {times_ours:.2f}×")
    print(f"wrote {options.json}")


if __name__ == "__main__":
    main()
