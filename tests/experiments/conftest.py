from pathlib import Path

import pytest

from experiments.cli import main


@pytest.fixture(scope="session")
def small_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of four experiments with two parts each: one attempt strikes the belt, one drops its part."""
    out = tmp_path_factory.mktemp("small") / "run"
    cell = ["--objects", "handle", "--gap", "fitted", "--parts", "2", "--seed", "5"]
    methods = ["--methods", "none", "maskval", "--experiments", "2"]
    with pytest.raises(SystemExit) as end:
        main(["compare", *cell, *methods, "--jobs", "1", "--out", str(out)])
    assert end.value.code == 0
    return out
