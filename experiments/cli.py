"""The command `graspcell`: parses arguments, runs a job, and says in one line what went wrong."""

import contextlib
import dataclasses
import functools
import importlib
import io
import operator
import os
import re
import sys
import traceback
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated, Any, NamedTuple

import tyro

from experiments.arguments import check_arguments, check_lists, nearest_option, spellings, with_own_names
from experiments.calibration.config import Calibrate
from experiments.commands.bench_config import Bench
from experiments.commands.config import Compare, Run
from experiments.commands.doctor import Doctor
from experiments.commands.merge import Merge
from experiments.commands.picture_config import Picture
from experiments.commands.tolerance_config import Tolerance
from experiments.dataset.config import Dataset
from experiments.dataset.rules import Rules
from experiments.errors import UsageError
from experiments.exporting.config import Export
from experiments.failure import explained
from experiments.output import print_on_any_terminal
from experiments.part.config import MakePart
from experiments.prediction.config import FitGap, Predict
from experiments.reading.config import Query
from experiments.reading.plan import Plan
from experiments.rendering.config import RenderDataset
from experiments.reporting.config import Report
from experiments.setup.actors import Actors
from experiments.setup.options_file import OPTION, with_options_file
from experiments.training.config import Train
from experiments.uq.config import Uq
from experiments.video.config import Video
from maskval.inputs.spelling import nearest
from sim.model.conditions import Conditions

_CLOSED_PIPE = 141  # the exit code that shells give a program that SIGPIPE ends
_USAGE = "Argument help"  # what tyro's explanation of an option begins with
_ASIDES = ("For full", _USAGE, "Perhaps you meant")  # they fill a screen, not a line
_PLACE = re.compile(r"^Error parsing (?!--)\S+: ")  # tyro's, before the message of a record that refuses a value
# Of a number that may also be left out, tyro tells every type that it has tried.
_TYPES = re.compile(r"no type matching .*(expected a (?:whole )?number such as [\d.]+, got '[^']*')")
_GROUPS: dict[str, type[Any]] = {"conditions": Conditions, "actors": Actors, "rules": Rules}  # by the field
_DESCRIPTION = (
    "Closed-loop grasp experiments in simulation that tell which 6D-pose uncertainty can be trusted. "
    "`graspcell COMMAND --help` explains a command; `graspcell --version` says which one this is; --debug, anywhere, "
    "shows where an error comes from; `graspcell COMMAND --config FILE.toml` takes options from a file, as every run "
    "writes one beside its results."
)


class Command(NamedTuple):
    """A command: its options, what does the job, and whether that needs the engine."""

    config: type[Any]
    job: str
    engine: bool = True


COMMANDS = {
    "compare": Command(Compare, "experiments.commands.compare:compare"),
    "merge": Command(Merge, "experiments.commands.merge:merge"),
    "plan": Command(Plan, "experiments.reading.plan:plan", engine=False),
    "query": Command(Query, "experiments.reading.query:query", engine=False),
    "report": Command(Report, "experiments.reporting.command:report"),
    "export": Command(Export, "experiments.exporting.command:export"),
    "run": Command(Run, "experiments.commands.run:run"),
    "picture": Command(Picture, "experiments.commands.picture:picture"),
    "video": Command(Video, "experiments.video.command:video"),
    "tolerance": Command(Tolerance, "experiments.commands.tolerance:tolerance"),
    "dataset": Command(Dataset, "experiments.dataset.command:dataset", engine=False),
    "calibrate": Command(Calibrate, "experiments.calibration.command:calibrate", engine=False),
    "gap": Command(FitGap, "experiments.prediction.gap_command:gap"),
    "predict": Command(Predict, "experiments.prediction.command:predict"),
    "render-dataset": Command(RenderDataset, "experiments.rendering.command:render_dataset"),
    "train": Command(Train, "experiments.training.command:train"),
    "uq": Command(Uq, "experiments.uq.command:uq", engine=False),
    "part": Command(MakePart, "experiments.part.command:part"),
    "bench": Command(Bench, "experiments.commands.bench:bench"),
    "doctor": Command(Doctor, "experiments.commands.doctor:doctor", engine=False),
}
_CHOICES = [Annotated[command.config, tyro.conf.subcommand(name)] for name, command in COMMANDS.items()]
_COMMAND: Any = functools.reduce(operator.or_, _CHOICES)


def main(arguments: Sequence[str] | None = None) -> None:
    """The entry point; always leaves by SystemExit."""
    print_on_any_terminal()
    typed = list(sys.argv[1:] if arguments is None else arguments)
    given = [argument for argument in typed if argument != "--debug"]
    try:
        code = _run(given)
        sys.stdout.flush()
    except BrokenPipeError:  # who read the output has seen enough, as `head` has
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what Python still has to write at its end
        code = _CLOSED_PIPE
    except (Exception, KeyboardInterrupt) as error:
        code = _failed(error, debug=given != typed)
    sys.exit(code)


def _run(arguments: Sequence[str]) -> int:
    """Does what the arguments ask for; returns the exit code."""
    if arguments == ["--version"]:
        print(f"graspcell {version('graspcell')}")
        return 0
    config = parse(arguments)
    command = next(one for one in COMMANDS.values() if one.config is type(config))
    if command.engine:
        _load_engine()
    module, _, name = command.job.partition(":")
    code: int = getattr(importlib.import_module(module), name)(config)
    return code


def _failed(error: BaseException, *, debug: bool) -> int:
    """Says in one line what went wrong, after the traceback if that is wanted; returns the exit code."""
    if debug:
        traceback.print_exception(error)
    message, code = explained(error)
    print(f"graspcell: error: {' '.join(message.split())}", file=sys.stderr)
    return code


def parse(arguments: Sequence[str]) -> Any:
    """The configuration that the arguments ask for.

    Raises:
        UsageError: they ask for something that does not exist; the message names what is valid.
        SystemExit: they ask for help.
    """
    check_arguments(arguments)
    kind, prog, rest = _COMMAND, "graspcell", list(arguments)
    if arguments and arguments[0] in COMMANDS:  # tyro then builds the options of one command only
        kind, prog = COMMANDS[arguments[0]].config, f"graspcell {arguments[0]}"
        valid = options(kind)
        rest = with_own_names(with_options_file(arguments, valid), valid)[1:]
        check_arguments(rest)  # those of the file too
    told = io.StringIO()
    try:
        with contextlib.redirect_stderr(told):
            description = _DESCRIPTION if kind is _COMMAND else None
            config = tyro.cli(kind, prog=prog, description=description, args=rest, registry=spellings())
    except SystemExit as stop:
        if stop.code in (0, None):
            raise
        raise UsageError(_one_line(told.getvalue(), arguments)) from None
    check_lists(config, rest)
    return config


def _load_engine() -> None:
    """Imports MuJoCo, which fails with whatever its bindings stumble over if MUJOCO_GL names an OpenGL that is missing.

    Raises:
        UsageError: it does.
    """
    try:
        importlib.import_module("sim.model.renderer")
    except (AttributeError, OSError, RuntimeError) as error:
        raise UsageError(
            f"no OpenGL of the kind that MUJOCO_GL names, {os.environ.get('MUJOCO_GL')!r} ({type(error).__name__}: "
            f"{error}); expected it unset, since only pictures need OpenGL; `graspcell doctor` says what pictures need"
        ) from error


def _one_line(told: str, arguments: Sequence[str]) -> str:
    """What tyro says in a box, in one line, with the valid options if there is a choice to make."""
    blocks: list[list[str]] = [[]]
    for line in told.splitlines()[1:]:  # the first has the title
        inside = line.strip().strip("│╭╮╰╯").strip()
        if set(inside) <= {"─", "-"}:  # the latter where the terminal is not UTF-8
            blocks.append([])
        else:
            blocks[-1].append(inside)
    kept = [_PLACE.sub("", " ".join(block)) for block in blocks if block and not block[0].startswith(_ASIDES)]
    kept = [text.removeprefix("Error parsing ") for text in kept]
    kept += (f"expected {block[1]}" for block in blocks if block and block[0].startswith(_USAGE))
    message = _TYPES.sub(r"\1", "; ".join(kept)) or "the arguments are not understood"
    command = arguments[0] if arguments else ""
    if "nrecognized" in message and command in COMMANDS:
        valid = options(COMMANDS[command].config)
        message += f"; valid options of {command}: {', '.join([*valid, OPTION])}"
        message += nearest_option(message, arguments, valid)
    elif "nrecognized" in message:
        message += nearest(command, COMMANDS)
    return message


def options(config: type[Any]) -> list[str]:
    """The options of a command; those of its groups stand among the others."""
    names: list[str] = []
    for field in dataclasses.fields(config):
        if tyro.conf.Positional in getattr(field.type, "__metadata__", ()):
            continue
        group = dataclasses.fields(_GROUPS[field.name]) if field.name in _GROUPS else (field,)
        names += (f"--{member.name.replace('_', '-')}" for member in group)
    return names


if __name__ == "__main__":
    main()
