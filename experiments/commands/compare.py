"""`graspcell compare`: the table of objects, methods and policies."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shutil import get_terminal_size
from typing import Any

from experiments.commands.config import Compare
from experiments.errors import UsageError
from experiments.results.paired import format_paired
from experiments.results.provenance import config_as_json
from experiments.results.report import format_table
from experiments.results.table_files import write_tables
from experiments.setup.checks import FAILED
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.options_file import write_manifest
from experiments.units.asked import Asked
from experiments.units.execution import Ended, Executor, execute, locally, missing
from experiments.units.identity import describe
from experiments.units.interruption import terminations_raised
from experiments.units.ray_cluster import on_ray
from experiments.units.run_folder import RunFolder
from experiments.units.stopping import Stopping
from experiments.units.summary import Summary, caveats_of, counted_of, summarise, thresholds_of
from sim.model.conditions import Conditions

_ELSEWHERE = (
    "jobs",
    "ray",
    "shard",
    "retry_failed",
    "overwrite",
    "out",
)  # how and where to run, which changes no result


def compare(config: Compare) -> int:
    """Runs the experiments that have not ended yet, prints the folder's table and writes it; returns the exit code.

    Each experiment is kept as it ends. What ends the command early, a signal, a full disk, a power loss, costs only the
    experiments that were under way; the same command goes on. An experiment that failed is in the table, the logs and
    the exit code, and does not end the others.

    Raises:
        UsageError: an invalid argument, or a folder that holds something else or cannot be written.
        SimError: the cell cannot be set up.
    """
    specs, (number, shares) = config.specs(), config.share
    stopping = Stopping(config.until, specs) if config.until else None
    if stopping is not None and shares > 1:
        raise UsageError("expected --until without --shard: a share alone cannot answer it")
    with terminations_raised(), RunFolder.opened(config.out, overwrite=config.overwrite) as folder:
        before = [replace(cell) for cell in folder.asked]
        folder.ask(asked_by(specs), options_of(config))
        own = share_of(specs, number, shares, by_number=stopping is not None)
        left = missing(folder, own, retry_failed=config.retry_failed)
        if len(left) < len(own):
            print(f"{len(own) - len(left)} of {len(own)} experiments are in {folder.path} already")
        ended = _run(folder, left, len(own), executor_of(config), stopping)
        if shares > 1:
            return _told_of_share(folder.path, config.shard, len(own), ended)
        if stopping is not None and ended is None:
            _stop(folder, before, stopping)
        return report(folder, ended, stopping)


def _run(
    folder: RunFolder, left: Sequence[ExperimentSpec], total: int, executor: Executor, stopping: Stopping | None
) -> Ended | None:
    """Runs what is left, until the conditions are answered; returns how it ended early."""
    enough = None
    if stopping is not None:
        answered = [stopping.add(counted_of(unit)) for unit in folder.units()]
        if answered and answered[-1]:
            return None
        enough = lambda unit: stopping.add(counted_of(unit))  # noqa: E731
    return execute(folder, left, total, executor, enough) if left else None


def _stop(folder: RunFolder, before: Sequence[Asked], stopping: Stopping) -> None:
    """Has the folder hold the experiments that answered, and those that were asked for before."""
    if stopping.experiments is None:
        return
    earlier = {tuple(cell.of.items()): cell.experiments for cell in before}
    folder.content_with(
        [
            replace(
                cell,
                experiments=min(cell.experiments, max(stopping.experiments, earlier.get(tuple(cell.of.items()), 0))),
            )
            for cell in folder.asked
        ]
    )


def executor_of(config: Compare) -> Executor:
    """What runs the experiments."""
    return locally(config.workers) if config.ray is None else on_ray(config.ray, config.workers)


def options_of(config: Compare) -> dict[str, Any]:
    """The options that decide results."""
    return {name: value for name, value in config_as_json(config).items() if name not in _ELSEWHERE}


def asked_by(specs: Sequence[ExperimentSpec]) -> list[Asked]:
    """The cells of the table that experiments belong to, in their order."""
    cells: dict[tuple[str, str, str | None], list[ExperimentSpec]] = {}
    for spec in specs:
        cells.setdefault((spec.part, spec.method, spec.policy), []).append(spec)
    return [Asked(describe(group[0]), len(group)) for group in cells.values()]


def share_of(
    specs: Sequence[ExperimentSpec], number: int, shares: int, *, by_number: bool = False
) -> list[ExperimentSpec]:
    """One of so many shares, the first being 1, each with experiments of all cells, in the order of their numbers."""
    if shares == 1 and not by_number:
        return list(specs)
    return sorted(specs, key=lambda spec: spec.experiment)[number - 1 :: shares]


def report(folder: RunFolder, ended: Ended | None, stopping: Stopping | None = None) -> int:
    """Prints the table of a folder and writes it with its logs; returns the exit code."""
    summary = summarise(folder)
    write_results(folder, summary)
    if summary.experiments:
        print_table(folder, summary)
    for line in stopping.lines() if stopping is not None else ():
        print(line)
    failed = len(summary.failures)
    for one in summary.failures:
        print(f"failed: {' × '.join(one.of[:2])}, experiment {one.experiment}: {one.failure}")
    told = f"{folder.expected} experiments expected = {summary.completed} completed + {failed} failed"
    left = folder.expected - len(summary.experiments)
    if ended is not None:
        print(f"{ended.reason}: {told} + {left} to do; the same command goes on; results in {folder.path}")
        return ended.code
    print(f"{told}{f' + {left} to do' if left else ''}; results in {folder.path}")
    return FAILED if failed or left else 0


def write_results(folder: RunFolder, summary: Summary) -> None:
    """Writes the table in all its forms and the manifest, which say the same whatever happened on the way.

    Raises:
        UsageError: they cannot be written.
    """
    write_tables(folder.path, summary.cells, summary.pairs, summary.tests)
    write_manifest(
        folder.path,
        "compare",
        folder.options,
        asked=[{**cell.of, "experiments": cell.experiments} for cell in folder.asked],
        common=folder.asked[0].description["common"],
        finished=len(summary.experiments),
        planned=folder.expected,
        u_grasp=thresholds_of(folder.asked),
    )


def print_table(folder: RunFolder, summary: Summary) -> None:
    """Prints the table, its legend, the paired differences and the caveats."""
    undisturbed = all(
        cell.description["cell"]["own_policy"]
        and cell.description["common"]["conditions"] == config_as_json(Conditions())
        for cell in folder.asked
    )
    policies = {cell.of["policy"] for cell in folder.asked if not cell.description["cell"]["own_policy"]}
    if len(policies) == 1:
        print(f"policy: {policies.pop()}")
    print(format_table(summary.cells, as_paper=undisturbed, width=get_terminal_size().columns))
    print(format_paired(summary.pairs, summary.tests), end="\n" if summary.pairs else "")
    for caveat in caveats_of(folder.asked):
        print(caveat)


def _told_of_share(path: Path, shard: str | None, experiments: int, ended: Ended | None) -> int:
    if ended is not None:
        print(f"{ended.reason}; what is finished of shard {shard} is in {path}; the same command goes on")
        return ended.code
    print(
        f"shard {shard}, {experiments} experiments, is in {path}; join all of them: graspcell merge DIR ... --out DIR"
    )
    return 0
