"""A command's options in a TOML file under their long names: written beside every result, read by --config."""

import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.errors import UsageError
from experiments.results.files import write_text
from experiments.results.provenance import config_as_json, manifest, write_json
from experiments.setup.names import option_name
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text
from maskval.inputs.spelling import nearest, shown

OPTION, NAME = "--config", "config.toml"
_ELSEWHERE = ("jobs", "out")  # where to run and to write, which a repetition chooses anew


def write_manifest(folder: Path, command: str, config: object, skip: Iterable[str] = (), **more: object) -> None:
    """Writes manifest.json, and config.toml, with which `graspcell COMMAND --config` repeats the run.

    Args:
        folder: where to.
        command: the name of the command.
        config: its options, a dataclass or as JSON has them.
        skip: names of fields that are no options.
        more: what else the manifest says.

    Raises:
        UsageError: they cannot be written.
    """
    write_json(folder / "manifest.json", {**manifest(config), **more})
    rows = _flat(config_as_json(config))
    lines = [
        f"{name.replace('_', '-')} = {_toml(value)}" for name, value in rows.items() if name not in {*skip, *_ELSEWHERE}
    ]
    note = f"# graspcell {command} {OPTION} {NAME} repeats this run; options on the command line take precedence."
    write_text(folder / NAME, "\n".join([note, *lines, ""]))


def with_options_file(arguments: Sequence[str], valid: Sequence[str]) -> list[str]:
    """The arguments, with the options of the file that --config names, if one does, and that they do not give.

    Args:
        arguments: of the command line, the command first.
        valid: the command's options.

    Raises:
        UsageError: there is no such file, or it has something else than options of the command.
    """
    at = next((index for index, one in enumerate(arguments) if one.partition("=")[0] == OPTION), None)
    if at is None:
        return list(arguments)
    _, told, name = arguments[at].partition("=")
    rest = [*arguments[:at], *arguments[at + (1 if told else 2) :]]
    if not told:
        name = arguments[at + 1] if at + 1 < len(arguments) else ""
    if not name or name.startswith("--"):
        raise UsageError(f"expected {OPTION} FILE.toml, a file of options, got none")
    given = {option_name(one) for one in rest if one.startswith("--")}
    for option, values in _read(Path(name), valid).items():
        rest += () if option_name(option) in given else (option, *values)
    return rest


def _read(file: Path, valid: Sequence[str]) -> dict[str, list[str]]:
    """The options of a file, each with its values as the command line has them."""
    try:
        table = tomllib.loads(read_input_text(file))
    except InvalidFileError as error:
        raise UsageError(f"{OPTION}: {error}") from error
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise UsageError(f"{OPTION} {file}: no TOML of options: {error}") from error
    known, seen = {option_name(option) for option in valid}, set[str]()
    found = {}
    for key, value in table.items():
        option = f"--{key.replace('_', '-')}"
        if option_name(option) not in known or option.startswith("--no-"):
            names = [one.removeprefix("--") for one in valid]
            raise UsageError(
                f"{OPTION} {file}: unknown key {key!r}: expected one of {', '.join(names)}{nearest(key, names)}"
            )
        if option_name(option) in seen:
            raise UsageError(f"{OPTION} {file}: expected {option} once, got it twice")
        seen.add(option_name(option))
        if value is False:
            found[f"--no-{option.removeprefix('--')}"] = list[str]()
        else:
            found[option] = [] if value is True else _values(f"{OPTION} {file}: {key}", value)
    return found


def _values(where: str, value: Any) -> list[str]:
    values = value if isinstance(value, list) else [value]
    for one in values:
        if isinstance(one, bool) or not isinstance(one, str | int | float) or str(one).startswith("--"):
            raise UsageError(f"{where}: expected numbers or texts, got {shown(one)}")
    return [str(one) for one in values]


def _flat(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options by name, with those of groups among the others; what is not set and lists without values are left out."""
    rows: dict[str, Any] = {}
    for name, value in options.items():
        if isinstance(value, Mapping):
            rows |= _flat(value)
        elif value is not None and value != []:
            rows[name] = value
    return rows


def _toml(value: Any) -> str:
    """JSON's texts, numbers, booleans and lists are TOML's too, but for the control character DEL."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
