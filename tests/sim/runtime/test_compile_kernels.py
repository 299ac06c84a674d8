"""The set-up compiles every kernel that a command calls."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
# Prints the kernels, by arguments, that the set-up compiles or finds, and those which commands need beyond them.
COMMANDS = """
import contextlib, gc, io, json, sys
from numba.core.dispatcher import Dispatcher

def kernels():
    found = [one for one in gc.get_objects() if isinstance(one, Dispatcher)]
    ours = [one for one in found if one.__module__.startswith(("maskval", "sim"))]
    return {f"{one.__module__}.{one.__name__}{arguments}" for one in ours for arguments in one.overloads}

from sim.runtime.compile_kernels import compile_all
compile_all()
set_up = kernels()
from experiments.cli import main
for arguments in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        main(arguments)
print(json.dumps([sorted(set_up), sorted(kernels() - set_up)]))
"""


def test_no_command_compiles_what_the_set_up_did_not(tmp_path: Path) -> None:
    images = ["--images", "1", "--jobs", "1", "--out"]
    commands = [
        ["run", "--parts", "1", "--clutter", "distractors", "--out", str(tmp_path / "run")],
        ["dataset", "--objects", "antenna", "--methods", "all", "--resamples", "1", *images, str(tmp_path / "images")],
        ["render-dataset", *images, str(tmp_path / "pictures")],
    ]
    done = subprocess.run(
        [sys.executable, "-c", COMMANDS, json.dumps(commands)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    set_up, beyond = json.loads(done.stdout)
    assert beyond == []
    names = {kernel.split("(")[0].split(".", 1)[1] for kernel in set_up}
    assert {"rendering.kernels.measure", "rendering.depth_kernels.draw", "runtime.stepping.run_periods"} <= names
    assert list(tmp_path.glob("pictures/test/000000/rgb/*.png"))
