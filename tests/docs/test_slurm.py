"""The job scripts of docs/slurm, run by a shell that has stand-ins for the cluster's commands."""

import os
import shlex
import subprocess
from pathlib import Path

import pytest

from experiments.cli import parse

SCRIPTS = Path(__file__).parents[2] / "docs" / "slurm"
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
