"""What an argument of the command line must be, before a command looks at what it means."""

from collections.abc import Callable, Sequence
from dataclasses import MISSING, fields
from typing import Any, get_args, get_type_hints

from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from experiments.errors import UsageError
from experiments.setup.names import NAMES_IN_BOTH_NUMBERS, option_name
from maskval.inputs.spelling import nearest, number, shown, whole_number

_MOST_NAME = 255  # bytes, of Linux's file systems


def check_arguments(arguments: Sequence[str]) -> None:
    """Looks at the arguments as text.

    Raises:
        UsageError: one is empty, too long, or no text that files can hold, or an option is given twice.
    """
    seen: dict[str, str] = {}
    for index, argument in enumerate(arguments):
        after = f" after {shown(arguments[index - 1])}" if index else ""
        if not argument:
            raise UsageError(f"expected a value{after}, got an empty text")
        if "\0" in argument or not _is_utf8(argument):
            raise UsageError(f"expected UTF-8 text without NUL{after}, got {shown(argument)}")
        if _is_long(argument):
            raise UsageError(f"expected names of at most {_MOST_NAME} bytes{after}, got {shown(argument)}")
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


def check_lists(config: object, arguments: Sequence[str]) -> None:
    """Raises UsageError if a list among a command's options was given without a value, or repeats one."""
    kinds, given = get_type_hints(type(config)), {option_name(argument) for argument in arguments}
    for field in fields(config):  # type: ignore[arg-type]  # a dataclass
        if get_args(kinds[field.name])[1:] != (...,) or field.default is MISSING:  # a command looks at its positions
            continue
        option, values = f"--{field.name.replace('_', '-')}", getattr(config, field.name)
        if option_name(option) in given and not values:
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
    """The rules by which tyro reads numbers."""
    registry = ConstructorRegistry()
    for kind, metavar, read in ((int, "INT", whole_number), (float, "FLOAT", number)):
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


def _is_long(argument: str) -> bool:
    """Whether a name in it is too long for a file; what has blanks is no name, but a question or a condition."""
    return len(argument.split()) == 1 and any(len(name.encode()) > _MOST_NAME for name in argument.split("/"))


def _is_utf8(text: str) -> bool:
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:  # of a lone surrogate
        return False
    return True


def _other(first: str, argument: str) -> str:
    """How the option was spelled the first time, where that was otherwise."""
    return "" if first == argument.partition("=")[0] else f", as {first} too"
