"""Plug-ins: methods, policies and estimators that are written elsewhere and named as `package.module:Class`."""

import importlib
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any, TypeVar

from cell.guards import TIME_LIMIT, describe_error, guarded_call
from experiments.errors import UsageError
from maskval.inputs.spelling import nearest

T = TypeVar("T")


def chosen(option: str, name: str, known: Mapping[str, T]) -> T | Callable[..., Any]:
    """The entry of a dict with this name; for another name with a colon, the object that it refers to.

    Args:
        option: the option of the command line, for the message: --policy.
        name: a key of `known`, or `package.module:Class`.
        known: the names that exist already; they take precedence.

    Raises:
        UsageError: neither exists.
    """
    if name in known:
        return known[name]
    if ":" not in name:
        what, valid = option.removeprefix("--"), f"{', '.join(known)}, or your own as package.module:Class"
        raise UsageError(f"unknown {what} {name!r}: expected one of {valid}{nearest(name, known)}")
    return load_object(name)


def load_object(reference: str) -> Callable[..., Any]:
    """The class or function that `package.module:Name` refers to, installed or in the current folder.

    Raises:
        UsageError: there is no such module, importing it fails, or it has no class or function of this name.
    """
    module_name, _, name = reference.partition(":")
    if not (name.isidentifier() and all(part.isidentifier() for part in module_name.split("."))):
        raise UsageError(f"expected package.module:Class, got {reference!r}")
    module = _import(module_name, reference)
    if not hasattr(module, name):
        own = [key for key, value in vars(module).items() if getattr(value, "__module__", None) == module_name]
        raise UsageError(f"{reference}: {module_name} has no {name}; it has {', '.join(own) or 'nothing of its own'}")
    found = getattr(module, name)
    if not callable(found):
        raise UsageError(f"{reference}: expected a class, or a function that makes an object, got {found!r}")
    return found  # type: ignore[no-any-return]


def make_object(
    reference: str,
    factory: Callable[..., Any],
    members: Sequence[str],
    *arguments: object,
    time_limit: float = TIME_LIMIT,
) -> Any:
    """What a factory makes of the arguments, if it has the members that a protocol requires.

    Args:
        reference: the factory's name, for the message.
        factory: a class or function, see `load_object`.
        members: names of the attributes and methods that the object must have.
        arguments: what the factory is called with.
        time_limit: s of the wall clock that making it may take.

    Raises:
        UsageError: the factory raises or takes too long, or members are missing.
    """
    given = ", ".join(type(argument).__name__ for argument in arguments)
    made = guarded_call(
        lambda: factory(*arguments),
        time_limit,
        lambda what: UsageError(f"{reference}: called with ({given}), it {what}"),
    )
    check_members(reference, made, members)
    return made


def check_members(what: str, made: object, members: Sequence[str]) -> None:
    """Raises UsageError unless an object has all members that a protocol requires; `what` names it in the message."""
    lacks = [member for member in members if not hasattr(made, member)]
    if lacks:
        raise UsageError(
            f"{what}: expected an object with {', '.join(members)}; {type(made).__name__} lacks {', '.join(lacks)}"
        )


def _import(name: str, reference: str) -> ModuleType:
    here = os.getcwd()
    if here not in sys.path:
        sys.path.append(here)  # at the end: a file that happens to lie here never replaces an installed module
    importlib.invalidate_caches()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and f"{name}.".startswith(f"{error.name}."):
            raise UsageError(f"{reference}: no module {error.name}, neither installed nor in {here}") from error
        raise UsageError(f"{reference}: importing {name} raised {describe_error(error)}") from error
    except SyntaxError as error:  # it names its place itself
        raise UsageError(f"{reference}: importing {name} raised SyntaxError: {error}") from error
    except (Exception, SystemExit) as error:
        raise UsageError(f"{reference}: importing {name} raised {describe_error(error)}") from error
