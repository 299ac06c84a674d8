"""What is printed where the output is not UTF-8: the nearest ASCII, instead of an error after the run."""

import codecs
import io
import sys
import unicodedata

_HANDLER = "graspcell.nearest"
_ASCII = {"×": "x", "≤": "<=", "≥": ">=", "≈": "~", "→": "->", "–": "-", "—": "-", "−": "-", "±": "+/-", "…": "..."}
_ASCII |= {"·": "*", "°": " deg", "σ": "sigma", "µ": "u", "│": "|", "─": "-", "█": "#", "’": "'"}


def print_on_any_terminal() -> None:
    """Has both outputs of this process write what their encoding lacks in ASCII."""
    codecs.register_error(_HANDLER, _nearest)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=_HANDLER)


def _nearest(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_ascii, error.object[error.start : error.end])), error.end


def _ascii(character: str) -> str:
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()  # é: e, ²: 2
    return _ASCII.get(character) or plain or "?"
