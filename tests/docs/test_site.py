"""The site: every page is in its menu and in llms.txt, every public name in its reference."""

import importlib
import importlib.util
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")}


def test_the_menu_names_every_page_once() -> None:
    menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    named = re.findall(r"[\w/-]+\.md", menu)
    assert sorted(named) == sorted(PAGES)


def test_llms_txt_names_every_page_once() -> None:
    named = re.findall(r"\]\(([^)]+)\)", (DOCS / "llms.txt").read_text(encoding="utf-8"))
    assert sorted(named) == sorted(PAGES - {"index.md"})


@pytest.mark.parametrize("package", ["maskval", "cell"])
def test_the_reference_names_every_public_name_once(package: str) -> None:
    text = (DOCS / "reference" / f"{package}.md").read_text(encoding="utf-8")
    named = re.findall(rf"^::: {package}\.(\w+)$", text, re.MULTILINE)
    assert sorted(named) == sorted(importlib.import_module(package).__all__)


@pytest.mark.parametrize(
    ("page", "text", "shown"),
    [
        ("a.md", "[the models](../sim/noise)", "the models (`sim/noise`)"),
        ("a.md", "[sim/noise](../sim/noise)", "sim/noise"),
        ("a.md", "[b](b.md#c), [d](results/d.json)", "[b](b.md#c), [d](results/d.json)"),
        ("reference/a.md", "[b](../b.md)", "[b](../b.md)"),
        ("reference/a.md", "[b](../../README.md)", "b (`README.md`)"),
        ("a.md", "[e](https://example.org)", "[e](https://example.org)"),
    ],
)
def test_a_link_out_of_the_pages_becomes_the_name_of_the_file(page: str, text: str, shown: str) -> None:
    spec = importlib.util.spec_from_file_location("links", DOCS / "hooks" / "repository_links.py")
    assert spec is not None
    assert spec.loader is not None
    links = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(links)
    assert links.on_page_markdown(text, SimpleNamespace(file=SimpleNamespace(src_uri=page))) == shown
