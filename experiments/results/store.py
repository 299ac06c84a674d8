"""The logs: typed Parquet tables with units, one row per frame, estimate, decision, attempt, slot and experiment."""

from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pyarrow as pa
import pyarrow.parquet as pq

from experiments.results.files import Aside

SCHEMA = 1  # the version of the columns; it counts up with every change of them
UNITS = b"units"  # the key of the tables' metadata that says which units they were made from
_ROWS_AT_ONCE = 10_000  # of a table: thousands of experiments then make few row groups, and memory stays flat
_TABLES_AT_ONCE = 200  # that wait for it, before they are joined: each takes some 10 kB, however few its rows

Row = Mapping[str, Any]
Tables = Mapping[str, Iterable[Row]]

_KEY = (
    ("object", pa.string(), "name of the part"),
    ("method", pa.string(), "name of the method"),
    ("policy", pa.string(), "name of the policy, or package.module:Class"),
    ("experiment", pa.int32(), "number of the experiment; equal numbers met equal parts in equal poses"),
)
_POSE = pa.list_(pa.float64(), 7)
_POSE_UNIT = "x, y, z in m, then quaternion w, x, y, z"

_COLUMNS: dict[str, tuple[tuple[str, pa.DataType, str], ...]] = {
    "experiments": (
        *_KEY,
        ("seed", pa.int64(), "root seed"),
        ("estimator", pa.string(), "noisy, oracle, replay, or package.module:Class"),
        ("failure", pa.string(), "why the experiment has no result; null if it has one"),
        ("parts", pa.int32(), "parts on the belt at the start"),
        ("tp", pa.int32(), "parts placed"),
        ("fp", pa.int32(), "failed attempts"),
        ("fn", pa.int32(), "parts left on the belt"),
        ("void", pa.int32(), "attempts that closed on nothing and touched nothing"),
        ("unreachable", pa.int32(), "poses that no grasp reaches"),
        ("timeouts", pa.int32(), "slots that ran out"),
        ("duration_s", pa.float64(), "s of the cell's clock"),
    ),
    "slots": (
        *_KEY,
        ("slot", pa.int32(), "number of the part's time slot"),
        ("start_s", pa.float64(), "s"),
        ("end_s", pa.float64(), "s"),
        ("outcome", pa.string(), "what ended it; null for a time-out"),
    ),
    "transitions": (
        *_KEY,
        ("time_s", pa.float64(), "s"),
        ("source", pa.string(), "state before"),
        ("target", pa.string(), "state after"),
        ("reason", pa.string(), "why"),
    ),
    "frames": (
        *_KEY,
        ("frame", pa.int32(), "number of the frame in its experiment"),
        ("time_s", pa.float64(), "s"),
        ("refining", pa.bool_(), "whether it was a second look"),
        ("X_BC", _POSE, f"camera in the robot's base as the robot believes it: {_POSE_UNIT}"),
        (
            "inference_s",
            pa.float64(),
            "s that detector and pose networks took; null if one of them or the method failed",
        ),
        ("detections", pa.int32(), "how many; null if detector, estimators or method failed"),
        ("failure", pa.string(), "why nothing was decided upon it; null if something was"),
    ),
    "estimates": (
        *_KEY,
        ("frame", pa.int32(), "number of the frame"),
        ("detection", pa.int32(), "number in the frame, best score first"),
        ("score", pa.float64(), "the detector's, in [0, 1]"),
        ("mask_rle", pa.list_(pa.uint32()), "COCO's uncompressed counts, column by column, beginning with zeros"),
        ("u", pa.float64(), "the method's uncertainty, in [0, 1]"),
        ("X_CO_est", _POSE, f"first estimator: {_POSE_UNIT}"),
        ("X_CO_est_2", _POSE, f"second estimator, null if the method needs none: {_POSE_UNIT}"),
        ("true_part", pa.int32(), "TRUTH: the part that most of the mask's pixels show; null for a false detection"),
        ("true_visibility", pa.float64(), "TRUTH: visible share of the part's silhouette, in [0, 1]"),
        (
            "true_mdd_m",
            pa.float64(),
            "TRUTH: maximum distance error of the first pose, least over symmetries, m",
        ),
        ("true_mdd_2_m", pa.float64(), "TRUTH: the same of the second estimator's, m"),
    ),
    "decisions": (
        *_KEY,
        ("decision", pa.int32(), "number of the decision"),
        ("slot", pa.int32(), "number of the slot"),
        ("frame", pa.int32(), "the frame decided upon"),
        ("action", pa.string(), "grasp, refine or search"),
        ("detection", pa.int32(), "the detection that it is about; null if there was none"),
        (
            "u",
            pa.float64(),
            "the uncertainty decided upon: the detection's own, or what the policy made of several views",
        ),
        ("threshold", pa.float64(), "the bound that it met, or, to search on, missed; null if there was none"),
        ("X_BO_est", _POSE, f"to grasp, the pose to act upon; null for the detection's own: {_POSE_UNIT}"),
        ("X_BC", _POSE, f"to refine, the view to take; null for the one straight above the part: {_POSE_UNIT}"),
    ),
    "attempts": (
        *_KEY,
        ("attempt", pa.int32(), "number of the attempt"),
        ("slot", pa.int32(), "number of the slot"),
        ("decision", pa.int32(), "the decision that caused it"),
        ("frame", pa.int32(), "the frame decided upon"),
        ("detection", pa.int32(), "the detection in that frame"),
        ("u", pa.float64(), "the uncertainty decided upon"),
        ("threshold", pa.float64(), "the bound that it met; null if there was none"),
        ("X_BO_est", _POSE, f"the pose acted upon, of the part in the robot's base: {_POSE_UNIT}"),
        ("grasp", pa.string(), "name of the grasp; null if none is within reach"),
        ("container_slot", pa.int32(), "where the part was to go"),
        ("start_s", pa.float64(), "s"),
        ("end_s", pa.float64(), "s"),
        ("last_state", pa.string(), "how far it came"),
        ("contact_with", pa.string(), "what stopped it; null if nothing"),
        ("contact_force_N", pa.float64(), "N"),
        ("contact_time_s", pa.float64(), "s"),
        ("outcome", pa.string(), "what it came to"),
    ),
}

SCHEMAS = {
    name: pa.schema(
        [pa.field(column, kind, metadata={"meaning": meaning}) for column, kind, meaning in columns],
        metadata={"graspcell": version("graspcell"), "schema": str(SCHEMA)},
    )
    for name, columns in _COLUMNS.items()
}


class LogWriter:
    """Writes one Parquet file per table into a folder; a context manager, so that what was written is always whole.

    The files grow aside and take their names at the end; an error before the first row leaves earlier logs untouched.

    Args:
        folder: where they go.
        units: which units they are made from, as the tables' metadata are to say; None if from none.
    """

    def __init__(self, folder: Path, units: str | None = None) -> None:
        made_from = {} if units is None else {UNITS: units.encode()}
        self._asides = [Aside(folder / f"{name}.parquet") for name in SCHEMAS]
        self._writers = {
            name: pq.ParquetWriter(aside.file, schema.with_metadata({**schema.metadata, **made_from}))
            for aside, (name, schema) in zip(self._asides, SCHEMAS.items(), strict=True)
        }
        self._empty = True
        self._waiting: dict[str, list[pa.Table]] = {name: [] for name in SCHEMAS}

    def write(self, tables: Tables) -> None:
        """Appends the rows of one experiment.

        Raises:
            KeyError: a table that is unknown or missing.
        """
        unknown = set(tables) ^ set(SCHEMAS)
        if unknown:
            raise KeyError(f"expected rows for exactly {', '.join(SCHEMAS)}; wrong: {', '.join(sorted(unknown))}")
        self._empty = False
        for name, rows in tables.items():
            waiting = self._waiting[name]
            waiting.append(pa.Table.from_pylist(list(rows), schema=SCHEMAS[name]))
            if len(waiting) >= _TABLES_AT_ONCE:
                waiting[:] = [pa.concat_tables(waiting).combine_chunks()]
            if sum(map(len, waiting)) >= _ROWS_AT_ONCE:
                self._write(name)

    def _write(self, name: str) -> None:
        """Writes the rows of a table that wait, as one row group."""
        if waiting := self._waiting[name]:
            self._writers[name].write_table(pa.concat_tables(waiting))
            waiting.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        try:
            for name, writer in self._writers.items():
                self._write(name)
                writer.close()
            if error is None or not self._empty:
                for aside in self._asides:
                    aside.keep()
        finally:
            for aside in self._asides:
                aside.drop()
