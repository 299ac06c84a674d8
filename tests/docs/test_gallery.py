"""The gallery: its commands are understood, and what they made is shown, small, and not in the package."""

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from experiments.cli import parse

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
SHOWN = re.compile(r'(?:\]\(|src="|poster=")(gallery/[\w.-]+)')


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("make_gallery", DOCS / "make_gallery.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_command_of_the_gallery_is_understood(script: ModuleType) -> None:
    commands = [words for words in script.commands() if words[0] != "python"]
    assert len(commands) >= 12
    for name, *arguments in commands:
        assert name == "graspcell"
        parse(arguments)


def test_everything_that_the_script_keeps_is_there_and_shown_and_nothing_else(script: ModuleType) -> None:
    kept = {f"{name}.webp" for name in script.PICTURES} | set(script.FILES)
    assert {path.name for path in (DOCS / "gallery").iterdir()} == kept
    assert set(SHOWN.findall((DOCS / "gallery.md").read_text(encoding="utf-8"))) == {f"gallery/{name}" for name in kept}


def test_what_a_page_embeds_of_the_gallery_exists() -> None:
    named = [name for page in DOCS.glob("*.md") for name in SHOWN.findall(page.read_text(encoding="utf-8"))]
    assert len(named) > 20
    assert [name for name in named if not (DOCS / name).is_file()] == []


def test_the_gallery_is_small(script: ModuleType) -> None:
    sizes = {path.name: path.stat().st_size for path in (DOCS / "gallery").iterdir()}
    pictures = [size for name, size in sizes.items() if name.endswith(".webp")]
    assert len(pictures) == len(script.PICTURES)
    assert max(pictures) <= script.MOST_BYTES
    assert sum(pictures) < 1_500_000
    for name, most in script.FILES.items():
        assert sizes[name] <= most
