"""Every attempt comes out alike whatever of the processor NumPy, its BLAS and the C library use."""

import json
import os
import subprocess
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import pytest
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

from tests.goldens import ALL, FILE, METHODS, PACKAGES, PARTS

ROOT = Path(__file__).parents[2]
GOLDEN = json.loads(FILE.read_text())
USED = [name for name in __cpu_dispatch__ if __cpu_features__[name]]  # what NumPy is built to use and finds here

BLAS = {"OPENBLAS_CORETYPE": "Nehalem"}  # runs wherever NumPy's wheels do: neither AVX nor fused multiplication
NUMPY = {"NPY_DISABLE_CPU_FEATURES": " ".join(USED)}
LIBM = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4"}
SETTINGS = {
    "as it is": ({}, ALL),
    "another BLAS": (BLAS, ("handle:none",)),
    "NumPy without vector instructions": (NUMPY, ("antenna:ensemble-add",)),
    "libm without fused multiplication": (LIBM, ("handle:maskval",)),
    "all of these": (BLAS | NUMPY | LIBM, ALL),
}


@cache
def outcome(setting: str) -> dict[str, Any]:
    """The processor and the attempts of a process under this setting."""
    variables, names = SETTINGS[setting]
    clean = {key: value for key, value in os.environ.items() if key not in BLAS | NUMPY | LIBM}
    child = subprocess.run(
        [sys.executable, "-m", "tests.goldens", *names],
        cwd=ROOT,
        env=clean | variables,
        capture_output=True,
        text=True,
        check=False,
    )
    assert child.returncode == 0, child.stderr
    found: dict[str, Any] = json.loads(child.stdout)
    return found


def test_the_goldens_are_of_the_packages_that_are_installed() -> None:
    assert {name: version(name) for name in PACKAGES} == GOLDEN["packages"], "other packages: run `make goldens`"


def test_the_goldens_hold_attempts_of_every_part_and_method() -> None:
    assert sorted(GOLDEN["attempts"]) == sorted(f"{part}:{method}" for part in PARTS for method in METHODS)
    assert min(len(rows) for rows in GOLDEN["attempts"].values()) >= 3
    assert {"placed"} < {row["outcome"] for rows in GOLDEN["attempts"].values() for row in rows}


@pytest.mark.parametrize("setting", SETTINGS)
def test_outcome_grasp_and_u_of_every_attempt_are_the_goldens(setting: str) -> None:
    found = outcome(setting)["attempts"]
    assert tuple(found) == SETTINGS[setting][1]
    for name, rows in found.items():
        expected = GOLDEN["attempts"][name]
        assert [(row["outcome"], row["grasp"]) for row in rows] == [(row["outcome"], row["grasp"]) for row in expected]
        assert [row["u"] for row in rows] == pytest.approx([row["u"] for row in expected], abs=1e-6)


@pytest.mark.parametrize("setting", SETTINGS)
def test_the_setting_took_effect(setting: str) -> None:
    variables, used, plain = SETTINGS[setting][0], outcome(setting)["processor"], outcome("as it is")["processor"]
    assert plain["numpy"] == USED
    assert len(used["blas"]) == len(plain["blas"]) == 1
    if "OPENBLAS_CORETYPE" in variables:
        assert used["blas"] == ["Nehalem"]
    else:
        assert used["blas"] == plain["blas"]
    assert used["numpy"] == ([] if "NPY_DISABLE_CPU_FEATURES" in variables else USED)
    # A processor without fused multiplication has nothing to do without: there the setting cannot change a sine.
    assert (used["sines"] != plain["sines"]) == ("GLIBC_TUNABLES" in variables and plain["fma"])


def test_this_processor_can_take_every_setting_or_has_nothing_to_switch_off() -> None:
    plain = outcome("as it is")["processor"]
    assert plain["fma"] == bool(__cpu_features__["FMA3"])
    # Without fused multiplication NumPy has no instructions of the third level of x86-64 to switch off either.
    assert bool(USED) >= plain["fma"]
    assert plain["blas"] != ["Nehalem"] or not plain["fma"]
