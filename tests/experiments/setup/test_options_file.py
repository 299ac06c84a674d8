"""Options from a file, and the file that every run writes."""

import tomllib
from pathlib import Path

import pytest

from experiments.cli import COMMANDS, options, parse
from experiments.commands.config import Compare, Run
from experiments.errors import UsageError
from experiments.setup.actors import Actors
from experiments.setup.options_file import with_options_file, write_manifest
from sim.model.conditions import Conditions
from tests.experiments.command import command

CONFIG = Compare(
    parts=3,
    seed=7,
    actors=Actors(gap="fitted", time_limit=12.5),
    speed="fast",
    fresh_look=False,
    conditions=Conditions(hand_eye_error_mm=(0.0, -1.5, 2e-5), clutter="close"),
    objects=("handle",),
    methods=("maskval", "my_method:Distance"),
    policy=(),
    experiments=4,
    u_grasp=("maskval=0.25",),
    until=("ap(maskval) >= 0.9",),
    jobs=2,
    out=Path("some/where"),
)


def written(folder: Path, text: str) -> list[str]:
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    return ["--config", str(folder / "mine.toml")]


def test_a_run_is_repeated_with_the_file_that_it_wrote(tmp_path: Path) -> None:
    write_manifest(tmp_path, "compare", CONFIG)
    again = parse(["compare", "--config", str(tmp_path / "config.toml"), "--jobs", "2", "--out", "some/where"])
    assert again == CONFIG


def test_the_file_leaves_out_where_to_run_and_what_is_not_set(tmp_path: Path) -> None:
    write_manifest(tmp_path, "compare", CONFIG, skip=("until",), seed=7)
    table = tomllib.loads((tmp_path / "config.toml").read_text(encoding="utf-8"))
    assert not {"jobs", "out", "until", "ray", "shard", "recorded", "actors", "conditions"} & set(table)
    assert (table["seed"], table["u-grasp"], table["fresh-look"]) == (7, ["maskval=0.25"], False)


def test_the_command_line_takes_precedence_whatever_the_name_of_its_option(tmp_path: Path) -> None:
    file = written(tmp_path, 'seed = 3\nobject = "handle"\nu-grasp = 0.5\nfresh-look = false\nfriction = 2\n')
    assert parse(["run", *file]) == Run(
        seed=3, object="handle", u_grasp=0.5, fresh_look=False, conditions=Conditions(friction=2.0)
    )
    assert parse(["run", "--seed=4", "--objects", "antenna", *file, "--fresh_look"]) == Run(
        seed=4, object="antenna", u_grasp=0.5, fresh_look=True, conditions=Conditions(friction=2.0)
    )


def test_the_file_may_be_named_with_an_equals_sign_and_use_underscores(tmp_path: Path) -> None:
    (name,) = written(tmp_path, "mdd_mm = [1, 2.5]\nfigure = true")[1:]
    config = parse(["tolerance", f"--config={name}"])
    assert (config.mdd_mm, config.figure) == ((1.0, 2.5), True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sed = 3", "unknown key 'sed': expected one of parts, seed, .*did you mean seed?"),
        ("no-fresh-look = true", "unknown key 'no-fresh-look'"),
        ("jbos = 1", "unknown key 'jbos'"),
        ("[conditions]\nfriction = 2", "unknown key 'conditions'"),
        ("[seed]\nis = 3", r"seed: expected numbers or texts, got \{'is': 3\}"),
        ("seed = [[1]]", r"seed: expected numbers or texts, got \[1\]"),
        ("seed = 2026-01-01", "seed: expected numbers or texts, got datetime.date"),
        ("object = '--seed'", "object: expected numbers or texts, got '--seed'"),
        ("seed = 3\nseed = 4", "no TOML of options: Cannot overwrite a value"),
        ("seed = 3\nfresh_look = true\nfresh-look = true", "expected --fresh-look once, got it twice"),
        ("seed =", "no TOML of options: Invalid value"),
        ("x = " + "[" * 5000, "no TOML of options"),
        ("seed = 1.5", "--seed: expected a whole number such as 12, got '1.5'"),
        ("seed = true", "--seed"),
        ("seed = ''", "expected a value after '--seed', got an empty text"),
        ("parts = 9", "expected --parts in 1..8"),
        ("object = 'antena'", "unknown object 'antena'.*did you mean antenna?"),
        (f"seed = {'9' * 5000}", "no TOML of options|expected numbers or texts"),
    ],
)
def test_a_file_of_something_else_is_refused_in_one_line(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, text: str, words: str
) -> None:
    told = command(capsys, "run", *written(tmp_path, text))
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert told.err.startswith("graspcell: error: ")
    with pytest.raises(AssertionError, match=words):
        raise AssertionError(told.err)


def test_a_file_that_is_missing_or_not_named_is_refused() -> None:
    valid = options(COMMANDS["run"].config)
    for arguments in (["run", "--config"], ["run", "--config="], ["run", "--config", "--seed", "3"]):
        with pytest.raises(UsageError, match=r"expected --config FILE.toml"):
            with_options_file(arguments, valid)
    with pytest.raises(UsageError, match=r"--config: no.toml does not exist"):
        with_options_file(["run", "--config", "no.toml"], valid)


@pytest.mark.parametrize("name", COMMANDS)
def test_what_no_file_is_named_for_stays_as_it_was_typed(name: str) -> None:
    assert with_options_file([name, "--seed", "3"], ["--seed"]) == [name, "--seed", "3"]
