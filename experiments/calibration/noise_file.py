"""A noise file with other values, its comments kept: each line is `key = value  # unit; meaning; source`."""

import re
from collections.abc import Mapping

_SECTION = re.compile(r"\[(?P<section>\w+)\]")
_LINE = re.compile(
    r"(?P<key>\w+) = (?P<value>[^#]*?)(?P<space>\s*)# (?P<unit>[^;]*); (?P<meaning>.*); (?P<source>[^;]*)$"
)
_COMMENT = 40  # the column at which comments begin


def rewrite(text: str, lines: Mapping[str, tuple[float, str]]) -> str:
    """The file with other values and sources.

    Args:
        text: A noise file.
        lines: Value and source by parameter, "section.key".

    Raises:
        KeyError: a parameter that the file has not.
    """
    left, section, rows = dict(lines), "", []
    for row in text.splitlines():
        if head := _SECTION.match(row):
            section = head["section"]
        found = _LINE.match(row)
        if found and (name := f"{section}.{found['key']}") in left:
            value, source = left.pop(name)
            code = f"{found['key']} = {value:.4g}"
            rows.append(f"{code:{_COMMENT}}# {found['unit']}; {found['meaning']}; {source}")
        else:
            rows.append(row)
    if left:
        raise KeyError(f"the noise file has no line for {', '.join(left)}")
    return "\n".join(rows) + "\n"
