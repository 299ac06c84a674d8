"""What happened in an experiment, attempt by attempt, as the page's JSON has it; short keys, since there are many."""

from collections.abc import Mapping, Sequence
from typing import Any

from cell.layout import default_camera
from cell.part import Part
from experiments.reporting.data.shapes import outline, projected
from experiments.reporting.data.words import kind_of, why_attempt, why_time_out
from experiments.units.summary import of
from experiments.units.unit import Unit
from maskval import Pose, mask_from_rle

Rows = dict[str, Any]
PHASES = ("search", "look", "refine", "grasp", "transfer", "wait")
_PHASE = {"search": 0, "look": 1, "decide": 1, "refine": 2, "approach": 3, "descend": 3, "close": 3, "lift": 3}
_PHASE |= {"transfer": 4, "insert": 4, "release": 4, "retreat": 4, "done": 5}


def experiment_of(unit: Unit, part: Part | None) -> Rows:
    """An experiment as the page has it.

    Args:
        unit: the experiment that has ended.
        part: the kind of part, to draw silhouettes of; none are drawn without it.
    """
    tables = unit.tables
    estimates: dict[tuple[int, int], Rows] = {
        (row["frame"], row["detection"]): row for row in tables.get("estimates", [])
    }
    decisions = tables.get("decisions", [])
    named = of(unit.description)
    items = [
        _attempt(row, estimates.get((row["frame"], row["detection"])), named[2]) for row in tables.get("attempts", [])
    ]
    items += _time_outs(tables, estimates)
    if part is not None:
        items = [{**item, **_drawn(item, estimates, part)} for item in items]
    return {
        "o": named[0],
        "m": named[1],
        "p": named[2],
        "e": unit.description["experiment"],
        "failure": unit.failure,
        "parts": unit.description["common"]["parts"],
        "noise": [[name, round(value, 3)] for name, value in unit.description["noise"]],
        "items": sorted(items, key=lambda item: (item["b"], item["n"] is None)),
        "slots": [
            [round(row["start_s"], 2), round(row["end_s"], 2), row["outcome"]] for row in tables.get("slots", [])
        ],
        "phases": _phases(tables.get("transitions", []), tables.get("slots", [])),
        "looks": _looks(tables.get("frames", []), decisions, tables.get("estimates", [])),
    }


def _attempt(row: Rows, estimate: Rows | None, policy: str) -> Rows:
    return {
        "n": row["attempt"],
        "s": row["slot"],
        "k": kind_of(row["outcome"]),
        "out": row["outcome"],
        "why": why_attempt(row, estimate, policy),
        "u": round(row["u"], 4),
        "th": _rounded(row["threshold"], 4),
        **_truth(estimate),
        "f": row["frame"],
        "d": row["detection"],
        "force": _rounded(row["contact_force_N"], 1),
        "touch": row["contact_with"],
        "hit": _rounded(row["contact_time_s"], 3),
        "state": row["last_state"],
        "grasp": row["grasp"],
        "b": round(row["start_s"], 2),
        "z": round(row["end_s"], 2),
    }


def _time_outs(tables: Mapping[str, list[Rows]], estimates: Mapping[tuple[int, int], Rows]) -> list[Rows]:
    """The slots in which nothing ended, each with the least uncertain detection that was refused in it."""
    found = []
    for slot in tables.get("slots", []):
        if slot["outcome"] is not None:
            continue
        decisions = [row for row in tables.get("decisions", []) if row["slot"] == slot["slot"]]
        refused = [
            (row, estimates[row["frame"], row["detection"]])
            for row in decisions
            if row["action"] == "search" and row["detection"] is not None
        ]
        tried = [row["outcome"] for row in tables.get("attempts", []) if row["slot"] == slot["slot"]]
        seconds = slot["end_s"] - slot["start_s"]
        row = {
            "n": None,
            "s": slot["slot"],
            "k": "time-out",
            "out": "time-out",
            "why": why_time_out(seconds, refused, len(decisions), tried),
            "b": round(slot["start_s"], 2),
            "z": round(slot["end_s"], 2),
        }
        if refused:
            decision, estimate = min(refused, key=lambda pair: pair[0]["u"])
            row |= {"u": round(decision["u"], 4), "th": _rounded(decision["threshold"], 4), **_truth(estimate)}
            row |= {"f": decision["frame"], "d": decision["detection"]}
        found.append(row)
    return found


def _truth(estimate: Rows | None) -> Rows:
    """The part that a detection shows, its error in mm and its visible share; None of a false detection."""
    if estimate is None or estimate["true_part"] is None:
        return {"part": None, "err": None, "vis": None}
    return {
        "part": estimate["true_part"],
        "err": round(1000 * estimate["true_mdd_m"], 2),
        "vis": round(estimate["true_visibility"], 3),
    }


def _drawn(item: Rows, estimates: Mapping[tuple[int, int], Rows], part: Part) -> Rows:
    """The outlines of a look: the mask decided upon, the model at its estimated pose, and the other masks."""
    estimate = estimates.get((item.get("f", -1), item.get("d", -1)))
    if estimate is None:
        return {}
    camera = default_camera()
    mask = mask_from_rle(estimate["mask_rle"], camera.height, camera.width)
    numbers = estimate["X_CO_est"]
    seen = projected(part, Pose.from_quaternion_wxyz(numbers[3:], numbers[:3]), mask, camera)
    others = [
        outline(mask_from_rle(row["mask_rle"], camera.height, camera.width))
        for (frame, detection), row in estimates.items()
        if frame == item["f"] and detection != item["d"]
    ]
    return {"c": round(seen.c, 4), "v": round(seen.v, 4), "mask": outline(mask), "model": seen.model, "others": others}


def _looks(frames: Sequence[Rows], decisions: Sequence[Rows], estimates: Sequence[Rows]) -> list[list[Any]]:
    """Every decision: frame, time, whether a second look, slot, action, detection, u, threshold, and what was seen.

    What was seen is a list of the true part, u, error in mm and visible share of each detection.
    """
    seen: dict[int, list[list[Any]]] = {}
    for row in estimates:
        truth = _truth(row)
        seen.setdefault(row["frame"], []).append([truth["part"], round(row["u"], 4), truth["err"], truth["vis"]])
    taken = {row["frame"]: row for row in frames}
    return [
        [
            row["frame"],
            round(taken[row["frame"]]["time_s"], 2),
            int(taken[row["frame"]]["refining"]),
            row["slot"],
            row["action"],
            row["detection"],
            _rounded(row["u"], 4),
            _rounded(row["threshold"], 4),
            seen.get(row["frame"], []),
        ]
        for row in decisions
    ]


def _phases(transitions: Sequence[Rows], slots: Sequence[Rows]) -> list[list[float]]:
    """When each phase began, s, and which of `PHASES` it is; equal ones in a row are one."""
    found: list[list[float]] = []
    for row in transitions:
        phase = _PHASE.get(row["target"], 0)
        if found and found[-1][0] == round(row["time_s"], 2):
            found.pop()
        if not found or found[-1][1] != phase:
            found.append([round(row["time_s"], 2), phase])
    return found


def _rounded(value: float | None, digits: int) -> float | None:
    return None if value is None else round(value, digits)
