"""The code of the library's pages runs as it stands there, block after block."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from experiments.cli import main
from maskval import Camera, Mesh, Pose, mdd, silhouette
from tests.fakes import moviepy
from tests.maskval import bop_dataset, shapes

DOCS = Path(__file__).parents[2] / "docs"
# The blocks that each page has: one that is not found is not run.
PAGES = {
    "first-run.md": 4,
    "maskval.md": 7,
    "conventions.md": 4,
    "uq-methods.md": 3,
    "datasets.md": 2,
    "gym.md": 5,
    "statistics.md": 3,
    "run-thousands.md": 4,
    "report.md": 1,
    "see-it.md": 1,
}
# Those of the other pages run in tests/docs/test_add_your_own.py, tests/experiments/reading/test_questions.py and
# tests/experiments/part/test_command.py.
ELSEWHERE = {"add-your-own.md", "query.md", "logs.md", "cell.md"}
SHOWN = ("text", "make")  # what needs other programs: see test_run_thousands.py
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def example_data() -> dict[str, object]:
    """What a reader of `docs/maskval.md` brings along."""
    camera = Camera(600.0, 600.0, 320.0, 240.0, 640, 480)
    vertices, faces = shapes.star()
    mesh = Mesh(vertices, faces)
    truths = [Pose.from_translation((0.15 * k - 0.2, 0, 0.6)) for k in range(3)]
    poses = [X @ Pose.from_translation((0.008 * k, 0, 0)) for k, X in enumerate(truths)]
    masks = np.array([silhouette(mesh, X, camera).mask for X in reversed(truths)])
    return {
        "vertices": vertices,
        "faces": faces,
        "K": camera.K,
        "poses": poses,
        "masks": masks,
        "errors_m": np.array([[mdd(X, truth, vertices) for truth in truths] for X in poses]),
        "visibility": np.ones(3),
    }


def test_every_page_with_code_is_run() -> None:
    with_code = {
        path.name for path in DOCS.rglob("*.md") if re.search(r"^```(python|sh)$", path.read_text(), re.MULTILINE)
    }
    assert with_code == {*PAGES, *ELSEWHERE}


@pytest.mark.parametrize("page", sorted(DOCS.rglob("*.md")), ids=lambda page: page.name)
def test_no_page_has_indented_code_which_would_not_be_run(page: Path) -> None:
    prose = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    assert re.findall(r"\n\n {4,}\S.*", prose) == []


@pytest.mark.parametrize(("page", "count"), PAGES.items())
def test_the_code_of_a_page_runs(page, count, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    bop_dataset.write(tmp_path / "dataset")
    blocks = [block for block in BLOCK.findall((DOCS / page).read_text()) if block[0] not in SHOWN]
    assert len(blocks) == count
    moviepy.install(monkeypatch)
    names = {"__name__": "__main__"} | (example_data() if page == "maskval.md" else {})
    for language, code in blocks:
        if language == "python":
            exec(compile(code, page, "exec"), names)
        else:
            assert language == "sh"
            for line in code.splitlines():
                command, *arguments = shlex.split(line)
                assert command == "graspcell"
                with pytest.raises(SystemExit) as end:
                    main(arguments)
                assert end.value.code == 0
    if page == "maskval.md":
        assert names["found"].masks.tolist() == [2, 1, 0]
        assert len(names["trusted"]) == 2
        told = capsys.readouterr()
        assert (told.out.count("Spearman"), told.err.count("Spearman")) == (2, 2)
        assert (tmp_path / "pictures" / "worst.png").exists()
        assert names["drawn"].any()


def test_the_page_shows_a_use_in_five_lines() -> None:
    _, code = BLOCK.findall((DOCS / "maskval.md").read_text())[0]
    assert len([line for line in code.splitlines() if line]) == 5
