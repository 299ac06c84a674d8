"""One finished experiment as a file: compressed JSON, whose content no clock and no machine goes into."""

# ruff: noqa: PLC0415  # the engine is loaded to run an experiment: reading units does not wait for it

import gzip
import hashlib
import json
import re
import traceback
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from cell.records import Tally
from experiments.errors import UsageError
from experiments.results.first_attempts import FirstAttempts
from experiments.units.identity import Description, canonical, describe, unit_name
from maskval import InvalidFileError
from maskval.inputs.files import MOST_RESULTS, read_input
from sim.errors import GraphicsError, SimError

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentResult, ExperimentSpec

_UNSAFE = re.compile(r"[^A-Za-z0-9._-]")  # of a name, in a folder's name


@dataclass(frozen=True, slots=True, eq=False)
class Unit:
    """An experiment that has ended.

    Attributes:
        description: what decided it, see `describe`.
        count: what it came to; None if it failed.
        first: its first attempts; None if it failed.
        failure: why it has no result; None if it has one.
        trace: where the failure was raised; None if it has a result.
        tables: the rows of its logs.
    """

    description: Description
    count: Tally | None
    first: FirstAttempts | None
    failure: str | None
    trace: str | None
    tables: Mapping[str, list[dict[str, Any]]]

    @property
    def place(self) -> str:
        """Where it lies in the folder of units: folder/name, without an ending."""
        return place(self.description)

    def to_bytes(self) -> bytes:
        """Its canonical JSON, compressed."""
        content = {
            "description": self.description,
            "count": None if self.count is None else asdict(self.count),
            "first": None if self.first is None else asdict(self.first),
            "failure": self.failure,
            "trace": self.trace,
            "tables": self.tables,
        }
        return gzip.compress(canonical(content), compresslevel=6, mtime=0)

    @classmethod
    def from_bytes(cls, packed: bytes, source: str) -> Self:
        """The unit in a file's bytes.

        Raises:
            UsageError: they are not a unit's, or the file was changed.
        """
        try:
            content = json.loads(unpacked(packed))
            count, first = content["count"], content["first"]
            return cls(
                description=content["description"],
                count=None if count is None else Tally(**count),
                first=None if first is None else FirstAttempts(**first),
                failure=content["failure"],
                trace=content["trace"],
                tables=content["tables"],
            )
        except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
            raise UsageError(
                f"{source} is damaged ({type(error).__name__}: {error}): delete it, and the same command makes it anew"
            ) from error


def place(description: Description) -> str:
    """Where a unit lies: a folder for its cell of the table, and its number and hash."""
    cell = ".".join(_UNSAFE.sub("_", description["of"][name])[:40] for name in ("object", "method", "policy"))
    return f"{cell}/{description['experiment']:06}-{unit_name(description)}"


def read_packed(file: Path) -> bytes:
    """The bytes of a unit's file.

    Raises:
        FileNotFoundError: it is not there any more: a retried experiment replaces the one that failed.
        UsageError: it is no regular file, too large, or cannot be read.
    """
    try:
        return read_input(file, MOST_RESULTS)
    except InvalidFileError as error:
        if isinstance(error.__cause__, FileNotFoundError):
            raise error.__cause__ from None
        raise UsageError(str(error)) from error


def unpacked(packed: bytes) -> bytes:
    """A unit's JSON, whether it is compressed or not."""
    return gzip.decompress(packed) if packed[:2] == b"\x1f\x8b" else packed


def content_digest(packed: bytes) -> str:
    """A digest of a unit's content, whatever compressed it."""
    return hashlib.sha256(unpacked(packed)).hexdigest()[:16]


def run_unit(spec: "ExperimentSpec") -> tuple[str, bool, bytes]:
    """Runs an experiment; returns its unit's place, whether it has a result, and the unit's bytes.

    Raises:
        SimError: the cell cannot be set up, which concerns every experiment.
    """
    from experiments.setup.experiment import run_experiment

    try:
        unit = unit_of(run_experiment(spec))
    except (SimError, GraphicsError, UsageError):
        raise
    except Exception as error:
        unit = failed_unit(spec, f"unexpected {type(error).__name__}: {error}", traceback.format_exc())
    return unit.place, unit.failure is None, unit.to_bytes()


def unit_of(result: "ExperimentResult") -> Unit:
    """The unit of an experiment that ran to its end."""
    return Unit(describe(result.spec), result.count, result.first, result.failure, result.trace, result.tables)


def failed_unit(spec: "ExperimentSpec", failure: str, trace: str | None = None) -> Unit:
    """The unit of an experiment that ended without a result and without logs."""
    description = describe(spec)
    row = {**description["of"], "experiment": spec.experiment}
    row |= {"seed": spec.seed, "estimator": spec.estimator, "failure": failure}
    return Unit(description, None, None, failure, trace, {"experiments": [row]})
