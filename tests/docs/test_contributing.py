import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def folders_of_the_house() -> list[str]:
    """The first column of the table in CONTRIBUTING.md, with `a/{b,c}/` written out."""
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    folders = []
    for entry in re.findall(r"^\| `(\S+/)` \|", page, re.MULTILINE):
        start, _, rest = entry.partition("{")
        folders += [f"{start}{name}/" for name in rest.removesuffix("}/").split(",")] if rest else [entry]
    return folders


def test_every_folder_of_the_packages_has_a_line_in_the_house_and_no_other() -> None:
    packages = ("maskval", "cell", "policies", "sim", "experiments")
    found = {f"{init.parent.relative_to(ROOT)}/" for name in packages for init in (ROOT / name).rglob("__init__.py")}
    assert len(found) > 15
    expected = found - {"sim/", "experiments/"}  # all that they hold stands in their folders
    assert set(folders_of_the_house()) - {"tests/"} == expected


def test_the_hooks_before_a_commit_are_local_and_run_make_check_alone() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    assert re.findall(r"repo: (.*)", hooks) == ["local"]
    assert re.findall(r"entry: (.*)", hooks) == ["make check"]


def test_the_newest_version_of_the_changelog_is_that_of_the_package() -> None:
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert (
        re.findall(r"^## (\d+\.\d+\.\d+)", changes, re.MULTILINE)[0]
        == re.findall(r"^version: (.*)$", citation, re.M)[0]
    )
