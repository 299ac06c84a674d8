"""The memory of the process that `compare` runs in, over the number of experiments.

    python -m benchmarks.driver_memory --out benchmarks/results/driver_memory.json

Nothing is simulated but one experiment: its unit stands for all others, each with its own number and name, so that the
process collects, writes and reads as many real units as it is told to, in one process or through a Ray cluster.
"""

import importlib
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import tyro

from experiments.commands import compare as command
from experiments.commands.config import Compare
from experiments.setup.actors import Actors
from experiments.setup.experiment import ExperimentSpec
from experiments.units import ray_cluster
from experiments.units.execution import Executor, Ran, Stream
from experiments.units.identity import describe
from experiments.units.unit import Unit, run_unit

MB = 1e6


@dataclass(frozen=True)
class Options:
    """Measure the memory of compare."""

    experiments: tuple[int, ...] = (100, 3000, 12000, 24000)
    """How many experiments, one process for each number."""
    ray: bool = False
    """Run them through a Ray cluster of two cores on this machine."""
    out: Path | None = None
    """JSON file to write."""
    alone: int | None = None
    """Used by the command itself: measure in this process."""


@cache
def one() -> Unit:
    """A real unit, of one part."""
    return Unit.from_bytes(run_unit(config(1, Path()).specs()[0])[2], "the one")


def stubbed(spec: ExperimentSpec, _: str = "") -> Ran:
    """The unit of an experiment as if it had been run."""
    tables = {name: [{**row, "experiment": spec.experiment} for row in rows] for name, rows in one().tables.items()}
    unit = replace(one(), description=describe(spec), tables=tables)
    return unit.place, True, unit.to_bytes()


def here(specs: Sequence[ExperimentSpec]) -> Stream:
    for spec in specs:
        yield spec, stubbed(spec)


def config(experiments: int, out: Path) -> Compare:
    small = {"objects": ("antenna",), "methods": ("none",), "parts": 1, "speed": "fast"}
    return Compare(**small, actors=Actors(estimator="oracle"), experiments=experiments, out=out)  # type: ignore[arg-type]


def executor(*, ray: bool) -> Executor:
    if not ray:
        return here
    ray_cluster._run = importlib.import_module("benchmarks.driver_memory").stubbed  # as the nodes can import it
    return ray_cluster.on_ray(ray_cluster.LOCAL, 2)


def measured(experiments: int, *, ray: bool) -> dict[str, float]:
    """Memory, MB; time of the command and of the same one again, s; size on disk, bytes per experiment."""
    one()  # what a first experiment loads and compiles counts for every number of them
    command.executor_of = lambda _: executor(ray=ray)
    with tempfile.TemporaryDirectory() as folder:
        before, begin = peak(), time.perf_counter()
        command.compare(config(experiments, Path(folder)))
        end = time.perf_counter()
        memory = peak()
        command.compare(config(experiments, Path(folder)))
        return {
            "experiments": experiments,
            "peak_mb_before": before,
            "peak_mb": memory,
            "seconds": round(end - begin, 1),
            "again_seconds": round(time.perf_counter() - end, 1),
            "unit_bytes": round(size(Path(folder).glob("units/*/*")) / experiments),
            "table_bytes": round(size(Path(folder).glob("*.parquet")) / experiments),
        }


def peak() -> float:
    return round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / MB, 1)


def size(files: Iterable[Path]) -> int:
    return sum(file.stat().st_size for file in files)


def main(options: Options) -> None:
    if options.alone is not None:
        print(json.dumps(measured(options.alone, ray=options.ray)))
        return
    rows: list[dict[str, Any]] = []
    for experiments in options.experiments:
        arguments = ["--alone", str(experiments), *(["--ray"] if options.ray else [])]
        told = subprocess.run(
            [sys.executable, "-m", "benchmarks.driver_memory", *arguments],
            check=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=os.environ,
        )
        rows.append(json.loads(told.stdout.splitlines()[-1]))
        print(rows[-1])
    if options.out is not None:
        options.out.write_text(json.dumps({"ray": options.ray, "rows": rows}, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(tyro.cli(Options))
