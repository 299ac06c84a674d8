"""`graspcell compare`: the table of objects and methods."""

from collections.abc import Hashable, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from tqdm import tqdm

from cell.records import Tally
from experiments.commands.config import Compare
from experiments.results.paired import Paired, format_paired, pair
from experiments.results.provenance import manifest, write_json
from experiments.results.report import LEGEND, format_table
from experiments.results.store import LogWriter
from experiments.results.table import Cell, make_cell
from experiments.setup.checks import FAILED, writable_folder
from experiments.setup.experiment import ExperimentResult, ExperimentSpec, run_experiment
from experiments.setup.methods import known_method
from experiments.setup.pool import run_all
from policies import ThresholdPolicy
from sim.errors import SimError
from sim.model.conditions import Conditions
from sim.model.parts import load_part

INTERRUPTED = 130  # the exit code of a command that Ctrl-C ended
WORKER_DIED = 1


def compare(config: Compare) -> int:
    """Runs all experiments, prints the table and writes the results; returns the exit code.

    Ctrl-C keeps what is finished: the table, the logs and the manifest are written for it. So does the death of a
    worker process. An experiment that failed is in the table, the logs and the exit code, and does not end the others.

    Raises:
        UsageError: an invalid argument.
        SimError: the cell cannot be set up.
    """
    specs = config.specs()
    folder = writable_folder(config.out)
    results, ended_early = _run(specs, config.workers, folder)
    if ended_early is not None and not results:
        reason, code = ended_early
        print(f"{reason} after 0 of {len(specs)} experiments; {folder} is as it was")
        return code
    cells, pairs = make_cells(specs, results), make_pairs(specs, results)
    write_json(
        folder / "table.json",
        {"cells": [cell.as_json() for cell in cells], "paired": [row.as_json() for row in pairs]},
    )
    write_json(
        folder / "manifest.json",
        {
            **manifest(config),
            "seed": config.seed,
            "finished": len(results),
            "planned": len(specs),
            "u_grasp": grasp_thresholds(specs),
        },
    )
    if config.actors.policy is not None:
        print(f"policy: {config.actors.policy}")
    as_paper = config.actors.policy is None and config.conditions == Conditions()
    print(format_table(cells, as_paper=as_paper))
    print(LEGEND)
    print(format_paired(pairs), end="\n" if pairs else "")
    for caveat in caveats(specs):
        print(caveat)
    for result in results:
        if result.failure is not None:
            spec = result.spec
            print(f"failed: {spec.part} × {spec.method}, experiment {spec.experiment}: {result.failure}")
    if ended_early is not None:
        reason, code = ended_early
        print(f"{reason} after {len(results)} of {len(specs)} experiments; what is finished is in {folder}")
        return code
    print(f"results in {folder}")
    return FAILED if any(result.failure is not None for result in results) else 0


def _run(
    specs: Sequence[ExperimentSpec], workers: int, folder: Path
) -> tuple[list[ExperimentResult], tuple[str, int] | None]:
    """Runs the experiments and writes their logs; returns the results, and the reason and exit code of an early end."""
    results: list[ExperimentResult] = []
    try:
        with LogWriter(folder) as logs:  # learns what ends it: without a result, the earlier logs stay
            _write_all(specs, workers, logs, results)
    except KeyboardInterrupt:
        return results, ("interrupted", INTERRUPTED)
    except BrokenProcessPool:
        return results, ("a worker process died (out of memory?); ended", WORKER_DIED)
    return results, None


def _write_all(specs: Sequence[ExperimentSpec], workers: int, logs: LogWriter, results: list[ExperimentResult]) -> None:
    """Runs the experiments; writes the rows of each finished one and keeps the result without them."""
    with (
        tqdm(total=len(specs), unit="experiment", dynamic_ncols=True) as progress,
        closing(run_all(run_experiment, specs, workers)) as stream,
    ):
        try:
            for result in stream:
                logs.write(result.tables)
                results.append(replace(result, tables={}))
                progress.set_postfix_str(f"{result.spec.part} × {result.spec.method}", refresh=False)
                progress.update()
        except SimError:
            progress.leave = False  # the error is to be the only line
            raise


def make_cells(specs: Sequence[ExperimentSpec], results: Sequence[ExperimentResult]) -> list[Cell]:
    """One cell per object and method that has at least one result, in the order of the specs."""
    groups: dict[tuple[str, str], list[ExperimentResult]] = {(spec.part, spec.method): [] for spec in specs}
    for result in results:
        groups[result.spec.part, result.spec.method].append(result)
    return [
        make_cell(
            load_part(part).part.name,
            method,
            [result.count for result in group],
            [_world(result.spec) for result in group],
            [result.first for result in group],
        )
        for (part, method), group in groups.items()
        if group
    ]


def make_pairs(specs: Sequence[ExperimentSpec], results: Sequence[ExperimentResult]) -> list[Paired]:
    """Every method compared with the reference, object by object, over the experiments that both have finished.

    Experiments with the same error model of a domain gap are not independent: they form a group.
    """
    counts = {_place(result.spec): result.count for result in results}
    pairs = []
    for part in dict.fromkeys(spec.part for spec in specs):
        groups: dict[str, dict[Hashable, list[Tally | None]]] = {}
        for spec in specs:
            if spec.part == part:
                group = groups.setdefault(spec.method, {}).setdefault(_world(spec), [])
                group.append(counts.get(_place(spec)))
        pairs += pair(load_part(part).part.name, {method: list(group.values()) for method, group in groups.items()})
    return pairs


def _world(spec: ExperimentSpec) -> Hashable:
    """Equal for experiments with the same error model of a domain gap, which are not independent."""
    return spec.noise or spec.experiment


def _place(spec: ExperimentSpec) -> tuple[str, str, int]:
    return spec.part, spec.method, spec.experiment


def grasp_thresholds(specs: Sequence[ExperimentSpec]) -> dict[str, dict[str, float]]:
    """The u_t,g in use, by object and method."""
    found: dict[str, dict[str, float]] = {}
    for spec in {(spec.part, spec.method): spec for spec in specs}.values():
        part = load_part(spec.part).part
        policy = known_method(spec.method, part, spec.thresholds).policy
        if isinstance(policy, ThresholdPolicy):
            found.setdefault(part.name, {})[spec.method] = policy.u_grasp
    return found


def caveats(specs: Sequence[ExperimentSpec]) -> list[str]:
    """A line for each u_t,g that was neither given nor derived by the rule of the others."""
    thresholds = specs[0].thresholds
    return [
        f"{part} × {method}: u_t,g = {u:.3f}: {caveat}"
        for part, row in grasp_thresholds(specs).items()
        for method, u in row.items()
        if (caveat := thresholds.caveat(part, method)) is not None
    ]
