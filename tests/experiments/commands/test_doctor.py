import subprocess
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import numba
import pytest

from experiments.commands import doctor as doctor_module
from experiments.commands.doctor import findings, meets
from maskval.rendering import kernels
from tests.experiments.command import command


def opengl(monkeypatch: pytest.MonkeyPatch, *working: str, chosen: str = "egl") -> None:
    """Lets only these kinds of OpenGL work."""

    def run(arguments: list[str], *, env: dict[str, str], **_: Any) -> subprocess.CompletedProcess[str]:
        assert arguments[1:] == ["-m", "sim.model.opengl"]
        works = env["MUJOCO_GL"] in working
        return subprocess.CompletedProcess(arguments, int(not works), "", "" if works else "Traceback\nno EGL here\n")

    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setenv("MUJOCO_GL", chosen)


def line_of(out: str, name: str) -> str:
    (found,) = [line for line in out.splitlines() if line[8:].startswith(name)]
    return found


def test_a_machine_that_has_everything_is_told_so(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opengl(monkeypatch, "egl", "osmesa")
    told = command(capsys, "doctor")
    assert (told.code, told.err) == (0, "")
    names = ("python", "graspcell", "mujoco", "numpy", "OpenGL by egl", "OpenGL by osmesa", "Numba's cache", "cores")
    assert [name for name in names if not line_of(told.out, name).startswith("ok ")] == []
    assert "BROKEN" not in told.out


@pytest.mark.parametrize(
    ("working", "chosen"), [(("osmesa",), "egl"), (("egl",), "egl"), (("egl",), "osmesa"), ((), "egl")]
)
def test_opengl_that_does_not_work_is_named_with_what_to_type_and_breaks_nothing(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    working: tuple[str, ...],
    chosen: str,
) -> None:
    opengl(monkeypatch, *working, chosen=chosen)
    told = command(capsys, "doctor")
    assert told.code == 0
    for name, library in (("egl", "libegl1 libgl1"), ("osmesa", "libosmesa6")):
        mark = "ok" if name in working else "missing"
        line = line_of(told.out, f"OpenGL by {name}")
        assert line.split()[0] == mark
        assert ("needed for pictures only; no EGL here" in line) == (name not in working)
        assert (f"sudo apt-get install {library}" in told.out) == (name not in working)
    other = {"egl": "osmesa", "osmesa": "egl"}[chosen]
    assert (f"if {other} works: export MUJOCO_GL={other}" in told.out) == (chosen not in working)


def test_opengl_is_tried_in_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    assert doctor_module._opengl("egl", "libegl1").works
    found = doctor_module._opengl("nothing", "libegl1")
    assert not found.works
    assert "nothing" in found.found

    def hang(*_: object, timeout: float, **__: object) -> None:
        raise subprocess.TimeoutExpired("python", timeout)

    monkeypatch.setattr(subprocess, "run", hang)
    assert doctor_module._opengl("egl", "libegl1").found == "no picture within 120 s"


def test_a_package_that_is_missing_or_of_another_version_is_named_with_what_to_type(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def version(name: str) -> str:
        if name == "tqdm":
            raise PackageNotFoundError(name)
        return {"mujoco": "3.9"}.get(name, "99.0")

    wanted = ["mujoco<4.1,>=4.0", "tqdm>=4.66", "numba>=0.61", 'torch>=2; extra == "learn"']
    opengl(monkeypatch, "egl", "osmesa")
    monkeypatch.setattr(doctor_module, "version", version)
    monkeypatch.setattr(doctor_module, "requires", lambda _: wanted)
    told = command(capsys, "doctor")
    assert told.code == 1
    assert line_of(told.out, "mujoco").split(maxsplit=2) == ["BROKEN", "mujoco", "3.9, expected mujoco<4.1,>=4.0"]
    assert line_of(told.out, "tqdm").split(maxsplit=2) == ["BROKEN", "tqdm", "not installed"]
    assert line_of(told.out, "numba").split() == ["ok", "numba", "99.0"]
    assert "pip install 'mujoco<4.1,>=4.0'" in told.out
    assert "torch" not in told.out


@pytest.mark.parametrize(
    ("found", "requirement", "fits"),
    [
        ("4.0.0", "mujoco<4.1,>=4.0", True),
        ("4.0.3rc1", "mujoco<4.1,>=4.0", True),
        ("4.1.0", "mujoco<4.1,>=4.0", False),
        ("3.10", "mujoco<4.1,>=4.0", False),
        ("10.2", "numba>=9", True),
        ("1", "networkx", True),
    ],
)
def test_a_version_meets_a_requirement_within_its_bounds(found: str, requirement: str, fits: bool) -> None:
    assert meets(found, requirement) is fits


def test_a_cache_that_cannot_be_written_to_is_missing_and_breaks_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(dir: Path) -> None:
        raise PermissionError(13, "Permission denied", str(dir))

    opengl(monkeypatch, "egl", "osmesa")
    monkeypatch.setattr(doctor_module, "TemporaryFile", refuse)  # the superuser may write anywhere
    (found,) = [one for one in findings() if one.name == "Numba's cache"]
    assert (found.works, found.needed, "Permission denied" in found.found) == (False, False, True)
    assert found.remedy == "export NUMBA_CACHE_DIR=$HOME/.cache/numba"


def test_kernels_without_any_folder_for_them_are_said_to_be_compiled_in_every_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kernels, "spans", numba.njit(lambda: 0))  # as where Numba found no folder
    opengl(monkeypatch, "egl", "osmesa")
    (found,) = [one for one in findings() if one.name == "Numba's cache"]
    assert (found.works, found.needed, found.found) == (False, False, "no folder that Numba can write to")


def test_little_memory_breaks_nothing_but_says_how_many_processes_fit(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    opengl(monkeypatch, "egl", "osmesa")
    monkeypatch.setattr(doctor_module.os, "sched_getaffinity", lambda _: set(range(8)))
    monkeypatch.setattr(doctor_module.os, "sysconf", {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 2**19}.__getitem__)
    told = command(capsys, "doctor")
    assert told.code == 0
    assert line_of(told.out, "memory").split() == ["missing", "memory", "2.0", "GiB"]
    assert "--jobs 2 with every command" in told.out
