import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.setup.plugins import chosen, load_object, make_object

MODULE = """
import math

NUMBER = 3

class Thing:
    estimators = 1
    def __init__(self, size):
        self.size = 1 / size

def make_thing(size):
    return Thing(size)
"""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A person's folder with modules, which is the current one; what is imported from it is forgotten afterwards."""
    before, path = set(sys.modules), list(sys.path)
    files = {
        "plugin_things": MODULE,
        "plugin_raises": "def f(): return [][1]\nf()\n",
        "plugin_garbled": "class Thing(:\n",
        "plugin_leaves": "import sys\nsys.exit('bye')\n",
        "plugin_needs": "import no_such_package_anywhere\n",
        "json": "raise RuntimeError('not the json of Python')\n",
    }
    for name, code in files.items():
        (tmp_path / f"{name}.py").write_text(code)
    (tmp_path / "plugin_package").mkdir()
    (tmp_path / "plugin_package" / "inner.py").write_text(MODULE)
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    sys.path[:] = path
    for name in set(sys.modules) - before:
        del sys.modules[name]


@pytest.mark.parametrize("reference", ["plugin_things:Thing", "plugin_package.inner:Thing", "plugin_things:make_thing"])
def test_a_class_or_function_in_the_current_folder_is_found(reference: str) -> None:
    assert load_object(reference)(4).size == 0.25


def test_a_file_of_the_current_folder_never_replaces_an_installed_module(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "json")
    assert load_object("json:dumps")([1]) == "[1]"


BAD = {
    "no colon": ("plugin_things.Thing", r"expected package.module:Class, got 'plugin_things.Thing'"),
    "no module name": (":Thing", r"expected package.module:Class, got ':Thing'"),
    "no class name": ("plugin_things:", r"expected package.module:Class"),
    "a path": ("./plugin_things.py:Thing", r"expected package.module:Class"),
    "no such module": (
        "plugin_thing:Thing",
        r"^plugin_thing:Thing: no module plugin_thing, neither installed nor in /",
    ),
    "no such inner module": ("plugin_package.outer:T", r"no module plugin_package.outer, neither"),
    "no such package": ("plugin_packages.inner:T", r"no module plugin_packages, neither"),
    "an import that raises": ("plugin_raises:f", r"raised IndexError: list index .*\(plugin_raises.py:1\)"),
    "no Python": (
        "plugin_garbled:Thing",
        r"importing plugin_garbled raised SyntaxError: .*plugin_garbled.py, line 1\)$",
    ),
    "an import that leaves": ("plugin_leaves:Thing", r"importing plugin_leaves raised SystemExit: bye"),
    "a package that it lacks": ("plugin_needs:Thing", r"raised ModuleNotFoundError: .*no_such_package_anywhere"),
    "no such class": ("plugin_things:Thin", r"plugin_things has no Thin; it has Thing, make_thing"),
    "no class": ("plugin_things:NUMBER", r"expected a class, or a function .*, got 3"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_reference_to_nothing_usable_is_refused_in_one_line(case: str) -> None:
    reference, words = BAD[case]
    with pytest.raises(UsageError, match=words) as refused:
        load_object(reference)
    assert "\n" not in str(refused.value)


def test_a_known_name_is_taken_before_a_reference() -> None:
    known = {"plugin_things:Thing": "mine", "plain": "other"}
    assert chosen("--policy", "plugin_things:Thing", known) == "mine"
    assert chosen("--policy", "plain", known) == "other"
    assert chosen("--policy", "plugin_things:Thing", {}) is load_object("plugin_things:Thing")


def test_an_unknown_name_is_refused_with_the_known_ones_and_the_form_of_ones_own() -> None:
    with pytest.raises(UsageError, match=r"unknown policy 'c': expected one of a, b, or your own as package.module:Cl"):
        chosen("--policy", "c", {"a": 1, "b": 2})


def test_an_object_is_made_if_it_has_what_is_asked_for() -> None:
    thing = load_object("plugin_things:Thing")
    assert make_object("plugin_things:Thing", thing, ("size", "estimators"), 2).size == 0.5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((2,), r"expected an object with size, decide; Thing lacks decide"),
        ((0,), r"called with \(int\), it raised ZeroDivisionError: .*plugin_things.py:9\)"),
        ((), r"called with \(\), it raised TypeError: .*missing 1 required positional argument: 'size'"),
    ],
)
def test_an_object_that_cannot_be_made_or_lacks_members_is_refused_by_name(
    arguments: tuple[object, ...], words: str
) -> None:
    with pytest.raises(UsageError, match=f"^plugin_things:Thing: {words}"):
        make_object("plugin_things:Thing", load_object("plugin_things:Thing"), ("size", "decide"), *arguments)
