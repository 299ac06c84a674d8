"""Libraries that are installed by an extra only: loaded when they are needed, and named where they are missing."""

from importlib import import_module
from typing import Any

from experiments.errors import UsageError


def load_viser() -> Any:
    """The module `viser`.

    Raises:
        UsageError: it is not installed.
    """
    return _load("viser", "the view in a browser needs viser", "view")


def load_rerun() -> Any:
    """The module `rerun`.

    Raises:
        UsageError: it is not installed.
    """
    rerun = _load("rerun", "recordings need rerun-sdk", "rerun")
    rerun.set_strict_mode(True)  # what cannot be logged is an error, not a warning
    return rerun


def _load(module: str, what: str, extra: str) -> Any:
    try:
        return import_module(module)
    except ImportError:
        raise UsageError(f"{what}; expected the extra: pip install 'graspcell[{extra}]'") from None
