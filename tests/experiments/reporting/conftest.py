"""One small run's page, made once, and a browser that opens it."""

import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from experiments.cli import main

_DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)


def report(*arguments: object) -> int:
    """Runs `graspcell report`; returns the exit code."""
    with pytest.raises(SystemExit) as end:
        main(["report", *map(str, arguments), "--jobs", "1"])
    assert isinstance(end.value.code, int)
    return end.value.code


def data_of(page: Path) -> dict[str, Any]:
    """The data in a page."""
    (text,) = _DATA.findall(page.read_text(encoding="utf-8"))
    found: dict[str, Any] = json.loads(text)
    return found


@pytest.fixture(scope="session")
def page(small_run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of the small run, with pictures of some of its attempts."""
    out = tmp_path_factory.mktemp("page") / "page.html"
    assert report(small_run, "--out", out, "--pictures", 3) == 0
    return out


@pytest.fixture(scope="session")
def chromium() -> Iterator[webdriver.Chrome]:
    """Debian's Chromium, without a window."""
    binary, driver = shutil.which("chromium"), shutil.which("chromedriver")
    assert binary, "expected chromium, which `make browser` installs"
    assert driver, "expected chromedriver, which `make browser` installs"
    options = webdriver.ChromeOptions()
    options.binary_location = binary
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,900"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    browser = webdriver.Chrome(options=options, service=Service(driver))
    yield browser
    browser.quit()
