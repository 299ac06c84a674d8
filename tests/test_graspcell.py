import os
import subprocess
import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from pathlib import Path

import pytest

import graspcell

ROOT = Path(__file__).parents[1]


def made_in(folder: Path) -> subprocess.CompletedProcess[str]:
    """What making an environment comes to where Python looks into the current folder first, as a script's does."""
    script = "import gymnasium; gymnasium.make('graspcell:GraspCell-v0', n_parts=1); print('made')"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", script], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def test_a_folder_with_a_package_of_the_same_name_is_told_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "sim").mkdir()
    (tmp_path / "sim" / "__init__.py").write_text("")
    line = made_in(tmp_path).stderr.splitlines()[-1]
    assert line == (
        f"ImportError: expected graspcell's own package sim in {ROOT / 'sim'}, but Python finds {tmp_path / 'sim'}: "
        "rename the other one, or run from another folder"
    )


def test_folders_of_names_that_the_environments_do_not_need_are_no_hindrance(tmp_path: Path) -> None:
    for name in ("experiments", "policies"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "__init__.py").write_text("raise ImportError('not this one')")
    assert made_in(tmp_path).stdout == "made\n"


@pytest.mark.parametrize("name", ["maskval", "cell", "sim"])
def test_a_module_or_a_folder_without_init_is_found_out_too(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    spaces = ModuleSpec(name, None, is_package=True)
    spaces.submodule_search_locations = ["/elsewhere/folder"]
    for spec, found in (
        (ModuleSpec(name, None, origin="/elsewhere/module.py"), "/elsewhere/module.py"),
        (spaces, "/elsewhere/folder"),
        (None, "None"),
    ):
        with monkeypatch.context() as patch:
            specs = {**{one: find_spec(one) for one in graspcell._PACKAGES}, name: spec}
            patch.setattr(graspcell, "find_spec", specs.__getitem__)
            with pytest.raises(ImportError, match=f"own package {name} in {ROOT / name}, but Python finds {found}: "):
                graspcell.check_packages()
    graspcell.check_packages()
