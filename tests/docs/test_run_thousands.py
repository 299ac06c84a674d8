"""The page on large runs: its job scripts in docs/slurm, its makefile and its figures."""

import json
import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from experiments.cli import parse

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "run-thousands.md").read_text(encoding="utf-8")
SCRIPTS = ROOT / "docs" / "slurm"
SLURM = {
    "SLURM_ARRAY_TASK_ID": "7",
    "SLURM_CPUS_PER_TASK": "4",
    "SLURM_JOB_NODELIST": "node[1-4]",
    "SLURM_JOB_NUM_NODES": "4",
}


def called(script: str, folder: Path) -> list[str]:
    """What the script calls at its end, word by word."""
    stand_ins = {"scontrol": "printf 'node1\\nnode2\\n'", "srun": 'printf "%s\\n" "$@"'}
    stand_ins["graspcell"] = 'printf "%s\\n" graspcell "$@"'
    for name, code in stand_ins.items():
        (folder / name).write_text(f"#!/bin/sh\n{code}\n")
        (folder / name).chmod(0o755)
    environment = {"PATH": f"{folder}{os.pathsep}{os.environ['PATH']}", **SLURM}
    run = subprocess.run(["bash", SCRIPTS / script], env=environment, capture_output=True, text=True, check=True)
    return run.stdout.split("\n")[:-1]


def test_a_task_of_the_array_runs_its_own_shard_into_its_own_folder(tmp_path: Path) -> None:
    name, *arguments = called("shards.sbatch", tmp_path)
    config = parse(arguments)
    assert name == "graspcell"
    assert (config.share, config.jobs, config.out) == ((7, 20), 4, Path("out/shard-7"))


def test_the_array_has_as_many_tasks_as_there_are_shards() -> None:
    text = (SCRIPTS / "shards.sbatch").read_text(encoding="utf-8")
    assert "#SBATCH --array=1-20\n" in text
    assert "\nSHARDS=20 " in text


def test_the_job_on_ray_starts_on_all_nodes_and_joins_the_first(tmp_path: Path) -> None:
    words = called("ray.sbatch", tmp_path)
    end = words.index("--")
    assert shlex.join(words[:end]) == "ray symmetric-run --address node1:6379 --min-nodes 4"
    name, *arguments = words[end + 1 :]
    config = parse(arguments)
    assert (name, config.ray, config.experiments) == ("graspcell", "node1:6379", 1000)


@pytest.mark.parametrize("script", ["shards.sbatch", "ray.sbatch"])
def test_a_script_that_runs_outside_a_job_says_which_variable_is_missing(script: str, tmp_path: Path) -> None:
    run = subprocess.run(["bash", SCRIPTS / script], env={"PATH": os.environ["PATH"]}, capture_output=True, check=False)
    assert run.returncode != 0
    assert b"SLURM_" in run.stderr


def test_the_makefile_of_the_page_runs_every_shard_and_joins_them(tmp_path: Path) -> None:
    (code,) = re.findall(r"^```make\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (tmp_path / "shards.mk").write_text(code)
    environment = {"PATH": os.environ["PATH"]}  # without the flags of a make that runs the tests
    make = subprocess.run(
        ["make", "-nf", "shards.mk"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
    )
    *shards, joined = [shlex.split(line.partition(" && ")[0]) for line in make.stdout.splitlines()]
    configs = [parse(arguments) for _, *arguments in shards]
    assert sorted(config.share for config in configs) == [(number, 20) for number in range(1, 21)]
    assert parse(joined[1:]).folders == tuple(Path(f"out/shard-{number}") for number in range(1, 21))
    assert {config.out for config in configs} == set(parse(joined[1:]).folders)


def test_the_commands_for_a_cluster_are_understood() -> None:
    commands = re.findall(r"^head\$ +graspcell (.*)$", PAGE, re.MULTILINE)
    assert [parse(shlex.split(command)).ray for command in commands] == ["head:6379"]


@pytest.mark.parametrize(("file", "count"), [("driver_memory", 4), ("driver_memory_ray", 2)])
def test_the_figures_of_the_page_are_those_of_the_committed_benchmark(file: str, count: int) -> None:
    rows = json.loads((ROOT / "benchmarks" / "results" / f"{file}.json").read_text(encoding="utf-8"))["rows"]
    assert len(rows) == count
    for row in rows:
        memory = row["peak_mb"] - row["peak_mb_before"]
        shown = f"| {row['experiments']:,} | {memory:.0f} MB | {row['seconds']} s | {row['again_seconds']} s |"
        assert shown in PAGE
