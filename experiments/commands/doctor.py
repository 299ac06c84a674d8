"""`graspcell doctor`: whether this machine has what the experiments need, and what to type if not.

It needs only Python: if `graspcell` itself does not start, `python -m experiments.commands.doctor` says why.
"""

import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, requires, version
from tempfile import TemporaryFile
from typing import Any

_OLDEST = (3, 11)
_LIBRARIES = {"egl": "libegl1 libgl1", "osmesa": "libosmesa6"}  # by the name that MUJOCO_GL takes
_PICTURES = "needed for pictures only"
_PATIENCE = 120  # s for a first picture; a machine under load takes some 5
_WORKER = 0.75e9  # bytes that a process of compare takes; 0.72e9 was measured


@dataclass(frozen=True)
class Doctor:
    """Check this machine: Python, packages, Numba's cache, cores, memory, and the OpenGL that pictures need.

    Says what to type where something does not work. The exit code is 0 if everything that is needed works, else 1.
    """


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that was checked.

    Attributes:
        name: what.
        works: whether it does.
        found: version, place or reason.
        remedy: what to type if it does not work.
        needed: whether the experiments need it.
    """

    name: str
    works: bool
    found: str
    remedy: str
    needed: bool = True


def doctor(_: Doctor) -> int:
    """Prints each check as it is made; returns the exit code."""
    broken = False
    for finding in findings():
        mark = "ok" if finding.works else "BROKEN" if finding.needed else "missing"
        print(f"{mark:8}{finding.name:24}{finding.found}", flush=True)
        if not finding.works:
            print(f"{'':8}{'type':24}{finding.remedy}")
            broken |= finding.needed
    return int(broken)


def findings() -> Iterator[Finding]:
    """All checks, in order."""
    oldest = ".".join(map(str, _OLDEST))
    yield Finding("python", sys.version_info >= _OLDEST, platform.python_version(), f"install Python {oldest} or newer")
    yield from _packages()
    yield _numba_cache()
    cores, memory = len(os.sched_getaffinity(0)), os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    yield Finding("cores", cores > 0, str(cores), "")
    fitting = max(1, int(memory / _WORKER))
    enough = fitting >= cores
    yield Finding("memory", enough, f"{memory / 2**30:.1f} GiB", f"--jobs {fitting} with every command", needed=False)
    for name, libraries in _LIBRARIES.items():
        yield _opengl(name, libraries)


def _packages() -> Iterator[Finding]:
    """The package itself, then what it requires; extras are not."""
    try:
        yield Finding("graspcell", True, version("graspcell"), "")
        wanted = [one for one in requires("graspcell") or () if "extra ==" not in one]
    except PackageNotFoundError:
        yield Finding("graspcell", False, "not installed", "pip install graspcell")
        return
    for requirement in wanted:
        name = re.split(r"[^A-Za-z0-9._-]", requirement)[0]
        remedy = f"pip install '{requirement}'"
        try:
            found = version(name)
        except PackageNotFoundError:
            yield Finding(name, False, "not installed", remedy)
            continue
        fits = meets(found, requirement)
        yield Finding(name, fits, found if fits else f"{found}, expected {requirement}", remedy)


def meets(found: str, requirement: str) -> bool:
    """Whether a version is within the bounds >= and < of a requirement."""
    bounds = re.findall(r"(>=|<)\s*([0-9.]+)", requirement)
    return all((_numbers(found) >= _numbers(bound)) == (sign == ">=") for sign, bound in bounds)


def _numbers(text: str) -> list[int]:
    """The release: of 4.0.1rc1 4, 0, 1; zeros at the end say nothing."""
    numbers = [int(part) for part in re.match(r"[0-9.]*[0-9]", text)[0].split(".")]  # type: ignore[index]
    while numbers and not numbers[-1]:
        numbers.pop()
    return numbers


def _opengl(name: str, libraries: str) -> Finding:
    """Whether a picture can be rendered, tried in a process of its own: a broken library may crash it.

    Only pictures need it: commands of which the experiments are made run without.
    """
    chosen = os.environ.get("MUJOCO_GL", "egl")
    remedy = f"sudo apt-get install {libraries}"
    if name == chosen:
        other = next(one for one in _LIBRARIES if one != name)
        remedy += f"; or, if {other} works: export MUJOCO_GL={other}"
    try:
        done = subprocess.run(
            [sys.executable, "-m", "sim.model.opengl"],
            env={**os.environ, "MUJOCO_GL": name},
            capture_output=True,
            text=True,
            timeout=_PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Finding(f"OpenGL by {name}", False, f"no picture within {_PATIENCE} s", remedy, needed=False)
    reason = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
    works = done.returncode == 0
    return Finding(f"OpenGL by {name}", works, "renders" if works else f"{_PICTURES}; {reason}", remedy, needed=False)


def _numba_cache() -> Finding:
    """Whether compiled kernels can be kept; if not, every process compiles for some 20 s."""
    name, remedy = "Numba's cache", "export NUMBA_CACHE_DIR=$HOME/.cache/numba"
    try:
        from maskval.rendering import kernels  # noqa: PLC0415  # Numba takes a second

        kernel: Any = kernels.spans
        folder = kernel.stats.cache_path
        if folder is None:
            return Finding(name, False, "no folder that Numba can write to", remedy, needed=False)
        os.makedirs(folder, exist_ok=True)
        TemporaryFile(dir=folder).close()
    except (OSError, ImportError) as error:
        return Finding(name, False, str(error), remedy, isinstance(error, ImportError))
    return Finding(name, True, folder, remedy)


if __name__ == "__main__":
    sys.exit(doctor(Doctor()))
