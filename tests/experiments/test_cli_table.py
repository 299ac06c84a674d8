import ast
import importlib
import subprocess
import sys
import typing
from dataclasses import fields
from importlib.metadata import version
from pathlib import Path

import pytest

from experiments.cli import COMMANDS, options
from experiments.commands.config import CellOptions, Compare, Run
from experiments.setup.methods import METHODS
from experiments.setup.names import METHOD_NAMES, POLICY_NAMES
from policies import POLICIES
from tests.experiments.command import command

ROOT = Path(__file__).parents[2]


def loaded_by(code: str) -> set[str]:
    """Modules that a fresh Python has loaded after the code."""
    script = f"import atexit, sys; atexit.register(lambda: print(sorted(sys.modules), file=sys.stderr)); {code}"
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    names: list[str] = ast.literal_eval(done.stderr.strip().splitlines()[-1])
    return set(names)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_job_of_a_command_takes_its_configuration_and_returns_an_exit_code(name: str) -> None:
    config, job, _ = COMMANDS[name]
    module, _, function = job.partition(":")
    hints = typing.get_type_hints(getattr(importlib.import_module(module), function))
    assert hints.pop("return") is int
    assert list(hints.values()) == [config]


def test_no_two_commands_share_a_configuration() -> None:
    assert len(COMMANDS) == 20
    assert len({one.config for one in COMMANDS.values()}) == len(COMMANDS)


def test_commands_that_need_no_engine_do_not_load_it() -> None:
    light = [one.job.partition(":")[0] for one in COMMANDS.values() if not one.engine]
    assert len(light) == 6
    loaded = loaded_by(f"import {', '.join(light)}")
    assert set(light) <= loaded
    assert "mujoco" not in loaded


def test_the_doctor_needs_nothing_but_python() -> None:
    own = {"numpy", "scipy", "tyro", "cv2", "maskval", "cell", "sim"}
    assert loaded_by("import experiments.commands.doctor") & own == set()


def test_help_loads_neither_the_engine_nor_what_computes() -> None:
    loaded = loaded_by("from experiments.cli import main; main(['--help'])")
    assert "tyro" in loaded
    slow = {"mujoco", "numba", "trimesh", "pyarrow", "ruckig", "networkx", "gymnasium", "scipy.spatial", "scipy.stats"}
    assert loaded & slow == set()


def test_the_names_in_help_texts_are_those_of_the_methods_and_policies(capsys: pytest.CaptureFixture[str]) -> None:
    assert tuple(METHODS) == METHOD_NAMES
    assert tuple(POLICIES) == POLICY_NAMES
    for job in ("compare", "run"):
        told = " ".join(command(capsys, job, "--help").out.replace("│", " ").split())
        assert f"{', '.join(METHOD_NAMES)}; or your own as package.module:Class" in told
        assert f"{', '.join(POLICY_NAMES)}, or your own as package.module:Class" in told


def test_compare_and_run_have_their_common_options_from_one_record() -> None:
    common = options(CellOptions)
    assert {"--parts", "--seed", "--estimator", "--thresholds", "--speed", "--friction"} <= set(common)
    for config in (Compare, Run):
        assert options(config)[: len(common)] == common
        assert "--policy" in options(config)
        assert {field.name for field in fields(CellOptions)} & set(config.__annotations__) == set()


def test_version_says_which_graspcell_this_is(capsys: pytest.CaptureFixture[str]) -> None:
    told = command(capsys, "--version")
    assert (told.code, told.out, told.err) == (0, f"graspcell {version('graspcell')}\n", "")
