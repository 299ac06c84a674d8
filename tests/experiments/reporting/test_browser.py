"""The page in a real browser: it opens, filters, leads where its addresses say, and says nothing on the console."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from selenium.webdriver import Chrome, Keys
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

from tests.experiments.reporting.conftest import data_of, report

Row = dict[str, Any]


@pytest.fixture
def opened(chromium: Chrome, page: Path) -> Chrome:
    """The page, opened anew."""
    chromium.get("about:blank")
    chromium.get(page.as_uri())
    return chromium


@pytest.fixture
def items(page: Path) -> list[tuple[Row, Row]]:
    """Every attempt and time-out with its experiment."""
    return [(one, item) for one in data_of(page)["experiments"] for item in one["items"]]


def rows(browser: Chrome) -> list[str]:
    """The addresses of the listed rows."""
    found = browser.find_elements(By.CSS_SELECTOR, "#list tbody tr")
    return [row.get_attribute("data-address") or "" for row in found]


def address(one: Row, item: Row) -> str:
    last = f"slot-{item['s']}" if item["n"] is None else item["n"]
    return f"#{one['o']}/{one['m']}/{one['e']}/{last}"


def title(browser: Chrome) -> str:
    return browser.find_element(By.ID, "detail-title").text


def is_open(browser: Chrome) -> bool:
    return bool(browser.find_elements(By.CSS_SELECTOR, "dialog[open]"))


def test_the_numbers_are_those_of_table_json(opened: Chrome, small_run: Path) -> None:
    cells = json.loads((small_run / "table.json").read_text(encoding="utf-8"))["cells"]
    shown = opened.find_elements(By.CSS_SELECTOR, "table.rates tbody tr")
    assert len(shown) == len(cells) == 2
    for row, cell in zip(shown, cells, strict=True):
        text = {one.get_attribute("data-key"): one.text for one in row.find_elements(By.CSS_SELECTOR, "[data-key]")}
        for key in ("object", "method", "tp", "fp", "fn", "void", "timeouts", "experiments", "parts_failed"):
            assert text[key] == str(cell[key])
        for key in ("ap", "ar"):
            low, high = cell[f"{key}_ci"]
            assert text[key].split()[0] == f"{100 * cell[key]:.1f}"
            assert f"[{100 * low:.0f}–{100 * high:.0f}]" in text[key]


def test_the_list_begins_with_failures_and_shows_what_the_filters_ask_for(
    opened: Chrome, items: list[tuple[Row, Row]]
) -> None:
    failures = [address(one, item) for one, item in items if item["k"] in ("failed", "time-out")]
    assert 0 < len(failures) < len(items)
    assert sorted(rows(opened)) == sorted(failures)
    Select(opened.find_element(By.NAME, "which")).select_by_value("all")
    assert sorted(rows(opened)) == sorted(address(one, item) for one, item in items)
    kinds = [row.text for row in opened.find_elements(By.CSS_SELECTOR, "#list .badge")]
    assert kinds.index("placed") >= len(failures)
    Select(opened.find_element(By.NAME, "method")).select_by_value("maskval")
    opened.find_element(By.NAME, "errHigh").send_keys("15")
    expected = [
        address(one, item)
        for one, item in items
        if one["m"] == "maskval" and item.get("err") is not None and item["err"] <= 15
    ]
    assert expected
    assert sorted(rows(opened)) == sorted(expected)


def test_a_number_of_an_outcome_leads_to_the_attempts_that_it_counts(
    opened: Chrome, items: list[tuple[Row, Row]]
) -> None:
    buttons = opened.find_elements(By.CSS_SELECTOR, "#outcomes button")
    assert sum(int(button.text) for button in buttons) == len(items)
    for button in buttons:
        found = re.fullmatch(r"handle, (\S+): (\d+) × (.*)", button.get_attribute("aria-label") or "")
        assert found is not None
        method, count, outcome = found.groups()
        opened.execute_script("arguments[0].click()", button)
        expected = [address(one, item) for one, item in items if (one["m"], item["out"]) == (method, outcome)]
        assert sorted(rows(opened)) == sorted(expected)
        assert len(expected) == int(count)


def test_a_picture_is_shown_large_by_enter_and_small_again(
    opened: Chrome, page: Path, items: list[tuple[Row, Row]]
) -> None:
    opened.get("about:blank")
    opened.get(page.as_uri() + next(address(one, item) for one, item in items if "wrist" in item))
    frame = opened.find_element(By.CSS_SELECTOR, ".frame")
    small = frame.size["width"]
    frame.send_keys(Keys.ENTER)
    assert frame.size["width"] > 1.5 * small
    frame.send_keys(Keys.ENTER)
    assert frame.size["width"] == small


def test_the_page_is_dark_where_the_system_is(opened: Chrome) -> None:
    for scheme, dark in (("dark", True), ("light", False)):
        wanted = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
        opened.execute_cdp_cmd("Emulation.setEmulatedMedia", wanted)
        text, ground = (
            sum(map(int, re.findall(r"\d+", opened.find_element(By.TAG_NAME, "body").value_of_css_property(name))[:3]))
            for name in ("color", "background-color")
        )
        assert (text > ground) == dark
    opened.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})


def test_two_runs_stand_side_by_side_and_addresses_say_which_run_they_mean(
    chromium: Chrome, small_run: Path, tmp_path: Path
) -> None:
    shutil.copytree(small_run, tmp_path / "again")
    page = tmp_path / "page.html"
    assert report(small_run, tmp_path / "again", "--out", page, "--pictures", 0) == 0
    chromium.get(f"{page.as_uri()}#again/handle/maskval/1/0")
    assert title(chromium) == "handle · maskval (again) · experiment 1 · attempt 0"
    who = [name.text.partition(":")[0] for name in chromium.find_elements(By.CSS_SELECTOR, "dialog .who > b")]
    assert who == ["none (run)", "maskval (run)", "none (again)", "maskval (again)"]
    shown = [row.get_attribute("data-run") for row in chromium.find_elements(By.CSS_SELECTOR, "table.rates tbody tr")]
    assert shown == ["run", "run", "again", "again"]


def test_an_address_leads_to_its_attempt(opened: Chrome, page: Path, items: list[tuple[Row, Row]]) -> None:
    pictured = next((one, item) for one, item in items if "wrist" in item and item["n"] is not None)
    for one, item in (pictured, items[-1]):
        opened.get("about:blank")
        opened.get(page.as_uri() + address(one, item))
        last = f"slot {item['s']}" if item["n"] is None else f"attempt {item['n']}"
        assert title(opened) == f"{one['o']} · {one['m']} · experiment {one['e']} · {last}"
        assert opened.find_element(By.CSS_SELECTOR, "dialog .why").text == item["why"]
    opened.get("about:blank")
    opened.get(page.as_uri() + address(*pictured))
    names = [name.text for name in opened.find_elements(By.CSS_SELECTOR, ".frame b")]
    assert names == ["Overview", "Gripper", "Wrist camera", "1 Detection", "2 Projection", "3 Overlap", "The truth"]
    assert opened.execute_script("return document.querySelector('.frame img').naturalWidth") == 480


def test_an_address_leads_to_a_part_under_every_method(opened: Chrome, page: Path) -> None:
    opened.get("about:blank")
    opened.get(f"{page.as_uri()}#handle/1/part-0")
    assert title(opened) == "handle · experiment 1 · part 0"
    methods = [name.text.partition(":")[0] for name in opened.find_elements(By.CSS_SELECTOR, "dialog .who > b")]
    assert methods == ["none", "maskval"]


@pytest.mark.parametrize(
    "wrong", ["#antenna/maskval/0/0", "#handle/maskval/99/0", "#handle/none/0/99", "#a/%E0%A4/1/2"]
)
def test_an_address_that_leads_nowhere_is_said(opened: Chrome, page: Path, wrong: str) -> None:
    opened.get("about:blank")
    opened.get(page.as_uri() + wrong)
    assert not is_open(opened)
    assert opened.find_element(By.ID, "message").text.startswith("This page has nothing at #")


def test_enter_opens_a_row_and_escape_closes_it(opened: Chrome) -> None:
    first, second = opened.find_elements(By.CSS_SELECTOR, "#list tbody tr")[:2]
    first.send_keys(Keys.ARROW_DOWN)
    assert opened.switch_to.active_element == second
    second.send_keys(Keys.ENTER)
    assert is_open(opened)
    assert opened.execute_script("return location.hash") == second.get_attribute("data-address")
    opened.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not is_open(opened)
    assert opened.execute_script("return location.hash") == ""
    assert opened.switch_to.active_element == second


@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_the_page_is_no_wider_than_its_window_and_says_nothing_on_the_console(
    opened: Chrome, items: list[tuple[Row, Row]], width: int
) -> None:
    size = {"width": width, "height": 844, "deviceScaleFactor": 1, "mobile": width < 500}
    opened.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        assert opened.execute_script("return document.documentElement.scrollWidth") <= width
        for one, item in items:
            opened.execute_script("location.hash = arguments[0]", address(one, item))
            opened.execute_script("follow()")
            assert opened.execute_script("return document.querySelector('dialog').scrollWidth") <= width
    finally:
        opened.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert opened.get_log("browser") == []
