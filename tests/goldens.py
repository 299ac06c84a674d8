"""What became of every attempt of one experiment per part and method: `make goldens` writes it to tests/goldens.json.

`python -m tests.goldens antenna:maskval ...` runs these experiments and prints their attempts, and what of the
processor NumPy, its BLAS and the C library use, as JSON.
"""

import hashlib
import json
import math
import random
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import threadpoolctl
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

from experiments.commands.config import Compare
from experiments.setup.actors import Actors
from experiments.setup.experiment import run_experiment

FILE = Path(__file__).with_suffix(".json")
PARTS, METHODS = ("antenna", "handle"), ("none", "ensemble-add", "maskval")
ALL = tuple(f"{part}:{method}" for part in PARTS for method in METHODS)
# Another release of these is another physics, or draws another mask: `make` installs the ones of constraints.txt.
PACKAGES = ("mujoco", "numpy", "opencv-python-headless", "ruckig", "scipy", "trimesh")


def attempts(part: str, method: str) -> list[dict[str, Any]]:
    """Outcome, grasp and u of every attempt of experiment 0 of `make run`."""
    (spec,) = Compare(
        objects=(part,), methods=(method,), experiments=1, actors=Actors(gap="fitted"), thresholds="paper"
    ).specs()
    result = run_experiment(spec)
    assert result.failure is None, result.failure
    rows = result.tables["attempts"]
    return [{"outcome": row["outcome"], "grasp": row["grasp"], "u": round(row["u"], 9)} for row in rows]


def processor() -> dict[str, Any]:
    """What is used of this processor: NumPy's own instructions, its BLAS' kernels, the last bits of the C library."""
    numpy_blas = [info for info in threadpoolctl.threadpool_info() if "numpy.libs" in info["filepath"]]
    numbers = random.Random(0)
    sines = [math.sin(numbers.uniform(-10.0, 10.0)).hex() for _ in range(20_000)]
    return {
        "numpy": [name for name in __cpu_dispatch__ if __cpu_features__[name]],
        "fma": bool(__cpu_features__["FMA3"]),
        "blas": [info["architecture"] for info in numpy_blas],
        "sines": hashlib.sha256("".join(sines).encode()).hexdigest(),
    }


def run(names: tuple[str, ...]) -> dict[str, Any]:
    """The attempts by part:method, and the processor."""
    np.ones((2, 2)) @ np.ones((2, 2))  # has the BLAS loaded
    found = {name: attempts(*name.split(":")) for name in names}
    return {"processor": processor(), "attempts": found}


if __name__ == "__main__":
    if sys.argv[1:]:
        sys.stdout.write(json.dumps(run(tuple(sys.argv[1:]))))
    else:
        golden = {"packages": {name: version(name) for name in PACKAGES}, "attempts": run(ALL)["attempts"]}
        FILE.write_text(json.dumps(golden, indent=1) + "\n")
