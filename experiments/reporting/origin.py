"""Where a run comes from, what it took, and the command that repeats it, as HTML."""

import json
from html import escape
from typing import Any

from experiments.errors import UsageError
from experiments.reporting.data.command_lines import repeat
from experiments.reporting.data.source import Source
from maskval import InvalidFileError
from maskval.inputs.files import read_input_text


def took(source: Source, *, named: bool) -> str:
    """One line for the top of the page.

    Args:
        source: the run.
        named: whether it says which run it is.
    """
    name = f"{source.name}: " if named else ""
    told = f"{name}{_hours(source)} of the cell's time, seed {_common(source)['seed']}, commit {_commit(source, 10)}."
    return f"<p>{escape(told)} Again: <code>{escape(_again(source))}</code></p>"


def origin(source: Source) -> str:
    """All that is known of it."""
    rows = (
        ("run", source.folder.path.resolve().name),
        ("commit", _commit(source)),
        ("versions", ", ".join(f"{name} {version}" for name, version in _common(source)["versions"].items())),
        ("platform", _manifest(source).get("platform") or "unknown: the run has no manifest.json yet"),
        ("seed", _common(source)["seed"]),
        ("experiments", f"{source.summary.completed} with a result, {len(source.summary.failures)} without"),
        ("time of the cell", _hours(source)),
        ("pictures", source.pictured),
    )
    listed = "".join(f"<dt>{escape(name)}</dt><dd>{escape(str(value))}</dd>" for name, value in rows)
    return f"<div><dl>{listed}</dl><p>The command that makes it again:</p><code>{escape(_again(source))}</code></div>"


def _again(source: Source) -> str:
    return repeat(source.folder.options, max(cell.experiments for cell in source.folder.asked))


def _common(source: Source) -> dict[str, Any]:
    found: dict[str, Any] = source.folder.asked[0].description["common"]
    return found


def _hours(source: Source) -> str:
    seconds = sum(one.count.duration for one in source.summary.experiments if one.count is not None)
    return f"{seconds / 3600:.1f} h" if seconds >= 3600 else f"{seconds / 60:.1f} min"


def _commit(source: Source, digits: int = 40) -> str:
    written = _manifest(source)
    dirty = " with changes" if written.get("dirty") else ""
    return f"{(written.get('commit') or 'unknown')[:digits]}{dirty}"


def _manifest(source: Source) -> dict[str, Any]:
    """What the run wrote of itself; nothing where there is no such file yet.

    Raises:
        UsageError: the file cannot be read, or is damaged.
    """
    file = source.folder.path / "manifest.json"
    if not file.exists():
        return {}
    try:
        found = json.loads(read_input_text(file))
    except InvalidFileError as error:
        raise UsageError(str(error)) from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file} is damaged: {error}: expected what compare writes") from error
    if not isinstance(found, dict):
        raise UsageError(f"{file} is damaged: expected a table, got {type(found).__name__}")
    return found
