"""What `compare --ray` refuses before a cluster is needed, and what travels to its nodes."""

import socket
import sys
from pathlib import Path

import pytest

from experiments.errors import UsageError
from experiments.units.ray_cluster import modules_of, on_ray
from tests.experiments.comparisons import compared, spec
from tests.experiments.own import folder_with

ONE = ("--objects", "antenna", "--methods", "none", "--experiments", 1)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


def test_without_ray_one_line_says_how_to_get_it(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)  # as if it was not installed
    told = compared(capsys, tmp_path / "out", *ONE, "--ray", "local")
    assert told.code == 2
    (line,) = [line for line in told.err.splitlines() if line]
    assert line.startswith("graspcell: error: --ray needs Ray")
    assert line.endswith("pip install 'graspcell[ray]'")


@pytest.mark.parametrize("address", ["", "locale", "head", "head:", ":6379", "head:port", "ray://head:10001"])
def test_an_address_of_another_form_is_refused_with_the_forms_that_are_valid(address: str) -> None:
    with pytest.raises(UsageError, match=r"expected --ray local, auto, or HOST:PORT .*, got "):
        next(on_ray(address, 1)([spec()]))


def test_an_address_where_nobody_answers_is_refused_with_the_address(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    address = f"127.0.0.1:{free_port()}"
    told = compared(capsys, tmp_path / "out", *ONE, "--ray", address)
    assert told.code == 2
    assert f"graspcell: error: no Ray cluster answers at {address} (" in told.err
    assert told.err.count("\n") <= 2  # the bar, which is overwritten, and the error
    assert not (tmp_path / "out" / "units").exists()


def test_plug_ins_travel_as_their_file_or_package_and_what_is_installed_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "__init__.py").touch()
    (tmp_path / "mine" / "rule.py").write_text("class Rule: ...\n")
    with folder_with(tmp_path, {"eyes": "class Eyes: ...\n"}, monkeypatch):
        sys.path.append(str(tmp_path))
        specs = [
            spec(policy="mine.rule:Rule"),
            spec(policy="mine.rule:Rule", estimator="eyes:Eyes"),
            spec(policy="tqdm:tqdm"),
            spec(policy="always"),
        ]
        assert modules_of(specs) == [str(tmp_path / "eyes.py"), str(tmp_path / "mine")]
        sys.modules.pop("mine", None)
