"""What the pages and comments name exists: files, folders, and the places that links lead to."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").glob("*.md"))]
COMMENTED = [*sorted((ROOT / "sim" / "assets").rglob("*.toml")), *sorted((ROOT / "experiments").rglob("*.toml"))]
BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
PACKAGES = "maskval|cell|policies|sim|experiments|tests|benchmarks|docs|examples"
# A path of the repository: a folder with its slash, or a file with its ending.
NAMED = re.compile(rf"(?<![\w./-])((?:{PACKAGES})/(?:[\w.-]+/)*(?:[\w-]+\.(?:py|md|toml|json|png))?)")
# A module, or a class in one, as a page writes it: `sim.gym.options.Rewards`, `python -m experiments.learn`.
MODULE = re.compile(
    r"`(?:python -m )?((?:cell|policies|sim|experiments|benchmarks)(?:\.[a-z_]+)+(?:\.[A-Z]\w+)?)(?=[ `\n])"
)
TABLE = (".parquet", ".md", ".png")  # files, not modules
LINK = re.compile(r"\]\(([^)#\s]*)(#[^)\s]*)?\)")


def prose(page: Path) -> str:
    return BLOCK.sub("", page.read_text(encoding="utf-8"))


def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives a page's headings."""
    headings = re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)
    return {"#" + re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*PAGES, *COMMENTED], ids=lambda page: str(page.relative_to(ROOT)))
def test_every_path_that_a_page_names_exists(page: Path) -> None:
    names = NAMED.findall(prose(page))
    assert [name for name in names if not (ROOT / name).exists() and "NAME" not in name] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_of_a_page_leads_somewhere(page: Path) -> None:
    broken = []
    for name, anchor in LINK.findall(prose(page)):
        if name.startswith("http"):
            continue
        target = (page.parent / name).resolve() if name else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(name + anchor)
    assert broken == []


def test_every_module_that_a_page_names_exists() -> None:
    pages = [page for page in PAGES if page.name != "CHANGELOG.md"]  # it names those that were before
    named = {name for page in pages for name in MODULE.findall(prose(page)) if not name.endswith(TABLE)}
    assert len(named) > 5
    missing = []
    for name in sorted(named):
        parts = [part for part in name.split(".") if part.islower()]
        place = ROOT.joinpath(*parts)
        if not (place.is_dir() or place.with_suffix(".py").is_file()):
            missing.append(name)
    assert missing == []


def test_the_patterns_find_what_they_are_meant_to_find() -> None:
    text = "see `sim/model/parts.py`, [noise](../sim/assets/noise/handle.toml), sim/gym/ and cell/nowhere.py"
    assert NAMED.findall(text) == ["sim/model/parts.py", "sim/gym/", "cell/nowhere.py"]
    text = "`sim.gym.options.Rewards` and `python -m experiments.learn --steps 2`, but not sim.gym or `sim.gym:main`"
    assert MODULE.findall(text) == ["sim.gym.options.Rewards", "experiments.learn"]
