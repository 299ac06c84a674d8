"""What `graspcell uq` found, as CSV or JSON."""

import dataclasses
import json
import math
from collections.abc import Sequence
from typing import Any

from maskval import UNMATCHED, Summary, bop

_COLUMNS = ("scene_id", "im_id", "obj_id", "score", "mask", "c", "v", "u")


def csv_of(judged: Sequence[bop.JudgedPose]) -> str:
    """A header and a line for each pose; nothing stands for no mask."""
    lines = [",".join(_COLUMNS)]
    for pose in judged:
        result, mask = pose.result, "" if pose.mask == UNMATCHED else str(pose.mask)
        ids = f"{result.scene_id},{result.im_id},{result.obj_id},{result.score:g}"
        lines.append(f"{ids},{mask},{pose.c:.6f},{pose.v:.6f},{pose.u:.6f}")
    return "\n".join(lines) + "\n"


def json_of(judged: Sequence[bop.JudgedPose], summary: Summary | None, warnings: Sequence[str]) -> str:
    """The poses, the warnings and the summary; null stands for no mask, and for what is undefined."""
    poses = [
        {
            **{name: getattr(pose.result, name) for name in _COLUMNS[:4]},
            "mask": None if pose.mask == UNMATCHED else pose.mask,
            **{name: round(getattr(pose, name), 6) for name in _COLUMNS[5:]},
        }
        for pose in judged
    ]
    whole = {"poses": poses, "warnings": list(warnings), "summary": _plain(summary)}
    return json.dumps(whole, indent=1, allow_nan=False) + "\n"


def _plain(value: Any) -> Any:
    """The value as JSON can hold it."""
    if dataclasses.is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return {name: _plain(member) for name, member in zip(value._fields, value, strict=True)}
    if isinstance(value, tuple):
        return [_plain(member) for member in value]
    return 1.0 if value == math.inf else value  # the u_T that keeps all poses; no u is greater than 1
