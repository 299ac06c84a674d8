"""The command `graspcell`: parses arguments, runs a job, and says in one line what went wrong."""

import contextlib
import dataclasses
import importlib
import io
import re
import sys
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from typing import Annotated, Any

import tyro

from experiments.calibration.config import Calibrate
from experiments.commands.config import Compare, Picture, Run, Tolerance
from experiments.commands.uq import Uq, uq
from experiments.dataset.config import Dataset
from experiments.dataset.rules import Rules
from experiments.errors import ExperimentsFailedError, UsageError
from experiments.prediction.config import FitGap, Predict
from experiments.rendering.config import RenderDataset
from experiments.setup.actors import Actors
from sim.errors import GraphicsError
from sim.model.conditions import Conditions

USAGE = 2  # exit code of a wrong argument, or of a machine without OpenGL
_GL_PACKAGES = (
    "libegl1 libgl1 libosmesa6"  # sim.model.renderer names them too, but cannot be asked where they are missing
)

_USAGE = "Argument help"  # what tyro's explanation of an option begins with
_ASIDES = ("For full", _USAGE, "Perhaps you meant")  # they fill a screen, not a line
_PLACE = re.compile(r"^Error parsing (?!--)\S+: ")  # tyro's, before the message of a record that refuses a value
_GROUPS: dict[str, type[Any]] = {"conditions": Conditions, "actors": Actors, "rules": Rules}  # by the field
_DESCRIPTION = (
    "Closed-loop grasp experiments in simulation that tell which 6D-pose uncertainty can be trusted. "
    "`graspcell COMMAND --help` explains a command."
)


def _compare(config: Compare) -> int:
    _load_engine()
    from experiments.commands.compare import compare  # noqa: PLC0415  # the engine is loaded when it is needed

    return compare(config)


def _run(config: Run) -> int:
    _load_engine()
    from experiments.commands.run import run  # noqa: PLC0415

    return run(config)


def _picture(config: Picture) -> int:
    _load_engine()
    from experiments.commands.picture import picture  # noqa: PLC0415

    return picture(config)


def _tolerance(config: Tolerance) -> int:
    _load_engine()
    from experiments.commands.tolerance import tolerance  # noqa: PLC0415

    return tolerance(config)


def _dataset(config: Dataset) -> int:
    from experiments.dataset.command import dataset  # noqa: PLC0415

    return dataset(config)


def _calibrate(config: Calibrate) -> int:
    from experiments.calibration.command import calibrate  # noqa: PLC0415

    return calibrate(config)


def _gap(config: FitGap) -> int:
    _load_engine()
    from experiments.prediction.gap_command import gap  # noqa: PLC0415

    return gap(config)


def _predict(config: Predict) -> int:
    _load_engine()
    from experiments.prediction.command import predict  # noqa: PLC0415

    return predict(config)


def _render_dataset(config: RenderDataset) -> int:
    _load_engine()
    from experiments.rendering.command import render_dataset  # noqa: PLC0415

    return render_dataset(config)


_COMMAND: Any = (
    Annotated[Compare, tyro.conf.subcommand("compare")]
    | Annotated[Run, tyro.conf.subcommand("run")]
    | Annotated[Picture, tyro.conf.subcommand("picture")]
    | Annotated[Tolerance, tyro.conf.subcommand("tolerance")]
    | Annotated[Dataset, tyro.conf.subcommand("dataset")]
    | Annotated[Calibrate, tyro.conf.subcommand("calibrate")]
    | Annotated[FitGap, tyro.conf.subcommand("gap")]
    | Annotated[Predict, tyro.conf.subcommand("predict")]
    | Annotated[RenderDataset, tyro.conf.subcommand("render-dataset")]
    | Annotated[Uq, tyro.conf.subcommand("uq")]
)
COMMANDS: dict[str, tuple[type[Any], Callable[[Any], int]]] = {
    "compare": (Compare, _compare),
    "run": (Run, _run),
    "picture": (Picture, _picture),
    "tolerance": (Tolerance, _tolerance),
    "dataset": (Dataset, _dataset),
    "calibrate": (Calibrate, _calibrate),
    "gap": (FitGap, _gap),
    "predict": (Predict, _predict),
    "render-dataset": (RenderDataset, _render_dataset),
    "uq": (Uq, uq),
}


def main(arguments: Sequence[str] | None = None) -> None:
    """The entry point; always leaves by SystemExit."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    try:
        config = parse(given)
        if not isinstance(config, Uq | Dataset | Calibrate):  # they need no physics
            _load_engine()
        jobs = dict(COMMANDS.values())
        code = jobs[type(config)](config)
    except (UsageError, GraphicsError) as error:
        _fail(str(error), USAGE)
    except ExperimentsFailedError as error:
        _fail(str(error), 1)
    except BrokenProcessPool:
        _fail("a worker process died (out of memory?)", 1)
    except KeyboardInterrupt:
        _fail("interrupted", 130)
    sys.exit(code)


def parse(arguments: Sequence[str]) -> Any:
    """The configuration that the arguments ask for.

    Raises:
        UsageError: they ask for something that does not exist; the message names what is valid.
        SystemExit: they ask for help.
    """
    told = io.StringIO()
    try:
        with contextlib.redirect_stderr(told):
            return tyro.cli(_COMMAND, prog="graspcell", description=_DESCRIPTION, args=list(arguments))
    except SystemExit as stop:
        if stop.code in (0, None):
            raise
        raise UsageError(_one_line(told.getvalue(), arguments)) from None


def _load_engine() -> None:
    """Imports MuJoCo, which without an OpenGL library fails with whatever its bindings stumble over.

    Raises:
        UsageError: the library is missing; the message names the packages to install.
    """
    try:
        importlib.import_module("sim.model.renderer")
    except (AttributeError, OSError, RuntimeError) as error:
        raise UsageError(
            f"no off-screen OpenGL ({type(error).__name__}: {error}); expected EGL or OSMesa: "
            f"apt-get install {_GL_PACKAGES}, then set MUJOCO_GL to egl or osmesa"
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
    message = "; ".join(kept) or "the arguments are not understood"
    command = arguments[0] if arguments else ""
    if "nrecognized" in message and command in COMMANDS:
        message += f"; valid options of {command}: {', '.join(options(COMMANDS[command][0]))}"
    return message


def options(config: type[Any]) -> list[str]:
    """The options of a command; those of its groups stand among the others."""
    names: list[str] = []
    for field in dataclasses.fields(config):
        group = dataclasses.fields(_GROUPS[field.name]) if field.name in _GROUPS else (field,)
        names += (f"--{member.name.replace('_', '-')}" for member in group)
    return names


def _fail(message: str, code: int) -> None:
    print(f"graspcell: error: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
