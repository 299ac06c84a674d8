"""What an argument of the command line must be, before a command looks at what it means."""

import os
from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args, get_type_hints

from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from experiments.errors import UsageError
from experiments.setup.names import NAMES_IN_BOTH_NUMBERS, option_name
from maskval.spelling import nearest, number, shown, whole_number

_MOST_NAME, _MOST_PATH = 255, 4095  # bytes, of Linux's file systems


def check_arguments(arguments: Sequence[str]) -> None:
    """Looks at the arguments as text.

    Raises:
        UsageError: one is empty or no text that files can hold, or an option is given twice.
    """
    seen: dict[str, str] = {}
    for index, argument in enumerate(arguments):
        after = f" after {shown(arguments[index - 1])}" if index else ""
        if not argument:
            raise UsageError(f"expected a value{after}, got an empty text")
        if "\0" in argument or not _is_utf8(argument):
            raise UsageError(f"expected UTF-8 text without NUL{after}, got {shown(argument)}")
        if argument.startswith("--") and argument != "--":
            name = option_name(argument)
            if name in seen:
                raise UsageError(
                    f"expected {argument.partition('=')[0]} once, got it twice{_other(seen[name], argument)}"
                )
            seen[name] = argument.partition("=")[0]


def with_own_names(arguments: Sequence[str], valid: Sequence[str]) -> list[str]:
    """The arguments, with a command's own name of what another calls --object, --objects, --methods, --policies."""
    own = {option_name(option): option for option in valid}
    found = []
    for argument in arguments:
        name, equals, value = argument.partition("=")
        if name in NAMES_IN_BOTH_NUMBERS:
            name = own.get(option_name(name), name)
        found.append(f"{name}{equals}{value}")
    return found


def check_lists(config: object) -> None:
    """Raises UsageError if a list among a command's options is empty where its default is not, or repeats a value."""
    kinds = get_type_hints(type(config))
    for field in fields(config):  # type: ignore[arg-type]  # a dataclass
        if get_args(kinds[field.name])[1:] != (...,):
            continue
        option, values = f"--{field.name.replace('_', '-')}", getattr(config, field.name)
        if field.default and not values:
            raise UsageError(f"expected at least one value for {option}, got none")
        if len(set(values)) < len(values):
            raise UsageError(f"expected different values for {option}, got {' '.join(map(str, values))}")


def nearest_option(message: str, arguments: Sequence[str], valid: Sequence[str]) -> str:
    """A question after the option that was probably meant, of the first argument that the message finds unknown."""
    for argument in arguments:
        name = argument.partition("=")[0]
        if name.startswith("--") and name in message and name not in valid:
            return nearest(name, valid)
    return ""


def spellings() -> ConstructorRegistry:
    """The rules by which tyro reads numbers and paths."""
    registry = ConstructorRegistry()
    for kind, metavar, read in ((int, "INT", whole_number), (float, "FLOAT", number), (Path, "PATH", _path)):
        registry.primitive_rule(_rule(kind, metavar, read))
    return registry


def _rule(
    kind: type[Any], metavar: str, read: Callable[[str], Any]
) -> Callable[[PrimitiveTypeInfo], PrimitiveConstructorSpec[Any] | None]:
    kinds = (int, float) if kind is float else (kind,)

    def rule(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec[Any] | None:
        if info.type is not kind:
            return None
        return PrimitiveConstructorSpec(
            nargs=1,
            metavar=metavar,
            instance_from_str=lambda arguments: read(arguments[0]),
            is_instance=lambda value: isinstance(value, kinds) and not isinstance(value, bool),
            str_from_instance=lambda value: [str(value)],
        )

    return rule


def _path(text: str) -> Path:
    path = Path(text)
    if len(os.fsencode(text)) > _MOST_PATH or any(len(os.fsencode(part)) > _MOST_NAME for part in path.parts):
        raise ValueError(f"expected names of at most {_MOST_NAME} bytes, got {shown(text)}")
    return path


def _is_utf8(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:  # of a lone surrogate
        return False
    return True


def _other(first: str, argument: str) -> str:
    """How the option was spelled the first time, where that was otherwise."""
    return "" if first == argument.partition("=")[0] else f", as {first} too"
