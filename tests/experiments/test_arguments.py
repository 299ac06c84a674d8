"""Wrong and odd arguments of the command line: one line each, before anything runs. All of it in one process."""

import io
import os
import sys
from pathlib import Path

import pytest

from experiments.arguments import check_arguments, with_own_names
from experiments.cli import COMMANDS, options, parse
from experiments.errors import UsageError
from experiments.output import print_on_any_terminal
from experiments.setup.checks import most_jobs
from tests.experiments.command import command

COMPARE = ("compare", "--methods", "maskval")
ODD_NUMBERS = ("1_000", "١٢", "１２", " 5", "5 ", "5.0", "1e3", "0x10", "five", "1,5", "--", "²", "1_", "9" * 200 + "_")
ODD_SHARES = ("0_1", "٠", "0,5", " 0.5", "half", "½", "1_0.0")
LONG = "x" * 300

ROWS: list[tuple[tuple[str, ...], str]] = []
ROWS += [
    ((*command_line, odd), "expected a whole number such as 12, got ")
    for command_line in (("run", "--seed"), (*COMPARE, "--experiments"), ("dataset", "--images"), ("gap", "--draws"))
    for odd in ODD_NUMBERS
    if odd != "--"
]
ROWS += [(("run", "--friction", odd), "expected a number such as 0.12, got ") for odd in ODD_SHARES]
ROWS += [
    ((*COMPARE, "--u-grasp", f"maskval={odd}"), "expected --u-grasp maskval=U with U in [0, 1]") for odd in ODD_SHARES
]
ROWS += [
    ((*COMPARE, "--shard", odd), "expected --shard I/N") for odd in ("١/٢", "1/0", "2/1", "0/1", "1", "/", "1/9999999")
]
ROWS += [
    ((job, "--jobs", str(most_jobs() + 1)), f"and at most {most_jobs()}, got {most_jobs() + 1}")
    for job in ("compare", "tolerance", "dataset", "calibrate", "gap", "predict", "render-dataset", "bench")
]
ROWS += [
    ((job, option, "2000000000"), f"expected {option} of at least ")
    for job, option in (
        ("compare", "--experiments"),
        ("tolerance", "--trials"),
        ("dataset", "--images"),
        ("dataset", "--resamples"),
        ("calibrate", "--rounds"),
        ("gap", "--draws"),
        ("predict", "--worlds"),
        ("picture", "--after"),
    )
]
ROWS += [
    (arguments, f"expected {arguments[-2]} once, got it twice")
    for arguments in (
        ("run", "--seed", "1", "--seed", "1"),
        ("run", "--seed=1", "--seed", "2"),
        ("run", "--u-grasp", "0.1", "--u_grasp", "0.2"),
        (*COMPARE, "--methods", "none"),
        (*COMPARE, "--objects", "antenna", "--object", "handle"),
        ("export", "somewhere", "--policy", "fuse", "--policies", "always"),
        ("run", "--no-fresh-look", "--fresh-look", "--no-fresh-look", "--fresh-look", "x"),
    )[:-1]
]
ROWS += [
    (("run", "--fresh-look", "--no-fresh-look"), "expected --no-fresh-look once, got it twice, as --fresh-look too"),
    ((*COMPARE, "--u-grasp", "maskval=0.1", "maskval=0.2"), "expected --u-grasp maskval=U once, got it twice"),
    ((*COMPARE, "--until", "ap(maskval) >= ٠"), "expected a number or ap(METHOD)"),
    (("run", "--time-limit", "1e300"), "expected --time-limit above 0 s and at most 86400 s"),
]
PATHS = (
    ("compare", "--out"),
    ("compare", "--thresholds"),
    ("compare", "--objects"),
    ("run", "--out"),
    ("run", "--gap"),
    ("run", "--object"),
    ("run", "--recorded"),
    ("run", "--estimator"),
    ("picture", "--out"),
    ("video", "--out"),
    ("merge",),
    ("query",),
    ("plan",),
    ("export",),
    ("part",),
    ("calibrate", "--targets"),
)
ROWS += [((*path, ""), f"expected a value after {path[-1]!r}, got an empty text") for path in PATHS]
ROWS += [((*path, "a\0.toml"), "expected UTF-8 text without NUL") for path in PATHS]
ROWS += [((*path, "a\udcff.toml"), "expected UTF-8 text without NUL") for path in PATHS]
ROWS += [((*path, LONG), "255 bytes") for path in PATHS]
ROWS += [
    (("run", option, name), f"did you mean {meant}?")
    for option, name, meant in (
        ("--object", "antena", "antenna"),
        ("--object", "handel", "handle"),
        ("--method", "maskvall", "maskval"),
        ("--policy", "treshold", "threshold"),
        ("--estimator", "nosy", "noisy"),
        ("--thresholds", "derive", "derived"),
        ("--speed", "moderat", "moderate"),
    )
]
ROWS += [(("picture", "--state", "serch"), "did you mean search?"), (("compar",), "did you mean compare?")]
ROWS += [(("run", "--sed", "1"), "did you mean --seed?"), (("tolerance", "--trails", "1"), "did you mean --trials?")]
ROWS += [
    ((job, option), f"expected at least one value for {option}, got none")
    for job, option in (
        ("compare", "--objects"),
        ("compare", "--methods"),
        ("tolerance", "--objects"),
        ("tolerance", "--mdd-mm"),
        ("dataset", "--objects"),
        ("dataset", "--methods"),
        ("predict", "--objects"),
        ("predict", "--variants"),
        ("bench", "--objects"),
        ("video", "--methods"),
    )
]
ROWS += [
    (("tolerance", "--mdd-mm", "5", "10", "5"), "expected different values for --mdd-mm, got 5.0 10.0 5.0"),
    (("predict", "--methods", "none", "none"), "expected different values for --methods, got none none"),
    (("run", "--objects", "antenna", "handle"), "handle"),
    (("picture", "--size", "1_0", "10"), "--size"),
]


@pytest.mark.parametrize(("arguments", "words"), ROWS, ids=[f"{at}" for at in range(len(ROWS))])
def test_an_odd_argument_ends_with_one_line_and_code_2(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    words: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    told = command(capsys, *arguments)
    assert (told.code, told.out, told.err.count("\n")) == (2, "", 1)
    assert told.err.startswith("graspcell: error: ")
    assert "unexpected" not in told.err
    assert words.replace(" ", "") in told.err.replace(" ", "")  # tyro breaks long lines inside of words
    assert not any(tmp_path.iterdir())


def test_the_table_of_odd_arguments_is_long() -> None:
    assert len(ROWS) > 180


def test_an_option_has_its_name_of_either_number() -> None:
    run, compare = (options(COMMANDS[job].config) for job in ("run", "compare"))
    assert with_own_names(["run", "--objects", "handle", "--methods=none"], run) == [
        "run",
        "--object",
        "handle",
        "--method=none",
    ]
    assert with_own_names(["compare", "--object", "handle", "--policies"], compare) == [
        "compare",
        "--objects",
        "handle",
        "--policy",
    ]
    assert parse(["run", "--objects", "handle"]).object == "handle"
    assert parse(["compare", "--object", "handle", "--method", "none"]).objects == ("handle",)


def test_values_may_repeat_what_options_may_not() -> None:
    check_arguments(
        ["compare", "--seed", "-1", "--jobs", "-1", "--hand-eye-error-mm", "0", "0", "0", "--", "--seed"][:9]
    )
    with pytest.raises(UsageError, match="expected --seed once"):
        check_arguments(["run", "--seed", "1", "--seed", "1"])


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_what_an_output_cannot_write_is_written_in_ascii(monkeypatch: pytest.MonkeyPatch, encoding: str) -> None:
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding=encoding))
    print_on_any_terminal()
    print("u ≤ 0.5 → 90 % × é … 漢", flush=True)
    text = written.getvalue().decode(encoding)
    if encoding == "utf-8":
        assert text == f"u ≤ 0.5 → 90 % × é … 漢{os.linesep}"
    else:
        shown = "× é" if encoding == "latin-1" else "x e"
        assert text == f"u <= 0.5 -> 90 % {shown} ... ?{os.linesep}"
