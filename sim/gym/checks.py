"""Checks of what a user gives the learning environments: each wrong value is one line with its name and its range."""

from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

from maskval.inputs.spelling import is_finite, nearest, shown
from sim.errors import EnvOptionError


def check_whole(name: str, value: Any, least: int, most: int) -> None:
    """Raises EnvOptionError unless the value is a whole number within these bounds."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not least <= int(value) <= most:
        raise EnvOptionError(f"expected {name} of {least} to {most}, got {shown(value)}")


def check_number(name: str, value: Any, above: float, most: float) -> None:
    """Raises EnvOptionError unless the value is a finite number above one bound and up to another."""
    if not is_finite(value) or not above < value <= most:
        raise EnvOptionError(f"expected {name} above {above:g} and at most {most:g}, got {shown(value)}")


def check_kind(name: str, value: Any, kind: type[Any]) -> None:
    """Raises EnvOptionError unless the value is of this kind."""
    if not isinstance(value, kind):
        raise EnvOptionError(f"expected {name} to be {_article(kind)}, got {shown(value)}")


def check_names(name: str, value: Any, valid: Iterable[str]) -> None:
    """Raises EnvOptionError unless the value is a tuple or list of different names among the valid ones."""
    if not isinstance(value, tuple | list):
        raise EnvOptionError(f"expected {name} to be a tuple of names, got {shown(value)}")
    for one in value:
        check_name(name, one, valid)
    if len(set(value)) < len(value):
        raise EnvOptionError(f"expected different names for {name}, got {shown(value)}")


def check_name(name: str, value: Any, valid: Iterable[str]) -> None:
    """Raises EnvOptionError unless the value is one of the valid names."""
    known = list(valid)
    if not isinstance(value, str) or value not in known:
        hint = nearest(value, known) if isinstance(value, str) else ""
        raise EnvOptionError(f"unknown {name} {shown(value)}: expected {', '.join(known)}{hint}")


def check_keys(what: str, given: Any, valid: Iterable[str]) -> None:
    """Raises EnvOptionError unless these are a mapping's keys, if it is one, all of them valid."""
    known = list(valid)
    if not isinstance(given, Mapping):
        raise EnvOptionError(f"expected {what} to be a dict, got {shown(given)}")
    for key in given:
        if key not in known:
            hint = nearest(key, known) if isinstance(key, str) else ""
            raise EnvOptionError(f"unknown {what} {key}: expected {', '.join(known)}{hint}")


def _article(kind: type[Any]) -> str:
    name = kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"
    return f"{'an' if name[0] in 'aeio' else 'a'} {name}"
