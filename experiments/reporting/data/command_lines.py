"""The commands that repeat a run and show an attempt again, written with the options that are not the defaults."""

import shlex
from collections.abc import Iterator
from dataclasses import asdict, fields
from typing import Any

from experiments.commands.config import CellOptions, Compare
from experiments.results.provenance import config_as_json

Options = dict[str, Any]


def repeat(options: Options, experiments: int) -> str:
    """The command that makes a run again: from the options in its run.json.

    Args:
        options: of the command that asked last, as JSON has them.
        experiments: how many there are of each cell.
    """
    return shlex.join(["graspcell", "compare", *_changed({**options, "experiments": experiments}, asdict(Compare()))])


def replay(options: Options, of: dict[str, str], experiment: int, attempt: int | None, *, own_policy: bool) -> str:
    """The command that makes a video of an attempt, or of an experiment.

    Args:
        options: of the run, as JSON has them.
        of: names of object, method and policy.
        experiment: its number.
        attempt: its number; None for the whole experiment.
        own_policy: whether the policy is the method's own.
    """
    common = {field.name: options[field.name] for field in fields(CellOptions) if field.name in options}
    chosen = ["--object", object_of(options, of["object"]), "--methods", of["method"]]
    chosen += [] if own_policy else ["--policy", of["policy"]]
    chosen += ["--experiment", str(experiment)]
    chosen += [] if attempt is None else ["--attempt", str(attempt)]
    thresholds = [option for option in options.get("u_grasp", ()) if option.rpartition("=")[0] == of["method"]]
    chosen += ["--u-grasp", *thresholds] if thresholds else []
    return shlex.join(["graspcell", "video", *chosen, *_changed(common, asdict(CellOptions()))])


def object_of(options: Options, name: str) -> str:
    """How the command line names a part: by its name, or by the file of a part of one's own."""
    return next((str(one) for one in options.get("objects", ()) if str(one).endswith(f"{name}.toml")), name)


def changes(options: Options, others: Options) -> list[str]:
    """The options in which one run differs from another, as the command line spells them."""
    return list(_changed(options, others))


def _changed(options: Options, defaults: Options) -> Iterator[str]:
    """`--name value` of every option that is not its default; those of a group stand among the others."""
    plain = config_as_json(defaults)
    for name, value in options.items():
        default = plain.get(name)
        if isinstance(value, dict):
            yield from _changed(value, default or {})
        elif value != default:
            yield from _spelled(f"--{name.replace('_', '-')}", value)


def _spelled(option: str, value: Any) -> Iterator[str]:
    if isinstance(value, bool):
        yield option if value else f"--no-{option.removeprefix('--')}"
        return
    if value is None or value == []:
        return
    yield option
    yield from map(_text, value if isinstance(value, list) else [value])


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
