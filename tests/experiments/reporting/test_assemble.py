"""The page's text: one file, whose data cannot become markup."""

from html.parser import HTMLParser
from pathlib import Path

import pytest

from experiments.reporting.assemble import as_script, page
from experiments.reporting.data.source import Source, read_sources
from tests.experiments.reporting.conftest import data_of

EVIL = "</script><script>alert(1)</script>{{data}}<!--\u2028"


class Elements(HTMLParser):
    """Which elements a page has, and what they load."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]


@pytest.fixture
def source(small_run: Path) -> Source:
    return read_sources((small_run,))[0]


def test_data_with_markup_stay_data(source: Source, tmp_path: Path) -> None:
    plain = Elements(page([source]))
    source.name = EVIL
    source.notes.append(EVIL)
    source.experiments[0]["items"][0]["why"] = EVIL
    text = page([source])
    assert Elements(text).tags.count("script") == 2
    assert len(Elements(text).tags) == len(plain.tags) + 1  # the note
    file = tmp_path / "page.html"
    file.write_text(text, encoding="utf-8")
    data = data_of(file)
    assert data["runs"][0]["name"] == EVIL
    assert data["experiments"][0]["items"][0]["why"] == EVIL


def test_a_script_holds_json_without_any_sign_that_could_end_it() -> None:
    assert as_script({"a": "</b>&\u2028"}) == '{"a":"\\u003c/b\\u003e\\u0026\\u2028"}'


def test_the_page_loads_nothing(page: Path) -> None:
    addresses = Elements(page.read_text(encoding="utf-8")).addresses
    assert len(addresses) >= 6
    assert [one for one in addresses if not one.startswith(("#", "data:"))] == []


def test_the_page_says_what_it_took_and_how_to_repeat_it(source: Source) -> None:
    text = page([source])
    assert "graspcell compare --parts 2 --seed 5 --gap fitted --objects handle" in text
    assert "of the cell&#x27;s time, seed 5, commit " in text


def test_only_the_papers_own_conditions_have_its_figures_beside_them(source: Source) -> None:
    assert "paper 61.4" in page([source])
    for cell in source.folder.asked:
        cell.description["common"]["conditions"]["friction"] = 0.5
    assert "paper 61.4" not in page([source])
