"""The benchmark's figures as tables for the docs: `python -m benchmarks.table benchmarks/results/silhouettes.json`."""

import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.peers import OURS

JOBS = {
    "mask": "µs per mask",
    "depth": "µs per depth image",
    "task": "µs per task: 8 poses × 8 masks, IoU and v",
}


def tables(figures: dict[str, Any]) -> str:
    """All tables, as Markdown."""
    parts = [_machine(figures), *(_job(figures, job) for job in JOBS), _floor(figures), *_scaling(figures)]
    return "\n\n".join(parts)


def _machine(figures: dict[str, Any]) -> str:
    load = figures["load_average_1_min"]
    sizes = ", ".join(f"{name} {count:,}" for name, count in figures["triangles"].items())
    missing = "; ".join(f"{name}: {why}" for name, why in figures["missing"].items())
    wrong = ", ".join(f"{name} {_wrong(pixels):.2g} %" for name, pixels in figures["pixels"].items())
    return (
        f"{figures['machine']['cores']} cores, {figures['rounds']} rounds, load average {load['before']:.1f} before "
        f"and {load['after_rounds']:.1f} after. Triangles: {sizes}. Missing: {missing or 'nothing'}. "
        f"Pixels that differ from the exact silhouette: {wrong}."
    )


def _wrong(pixels: dict[str, dict[str, int]]) -> float:
    return 100 * sum(case["wrong"] for case in pixels.values()) / sum(case["of"] for case in pixels.values())


def _job(figures: dict[str, Any], job: str) -> str:
    cases = {case.removesuffix(f" | {job}"): found for case, found in figures["jobs"].items() if case.endswith(job)}
    names = list(next(iter(cases.values())))
    rows = [[name] for name in names]
    for found in cases.values():
        for row, name in zip(rows, names, strict=True):
            row.append(_cell(found[name], ours=name == OURS))
    header = [f"{JOBS[job]} (× ours)", *(case.replace(" | ", ", ") for case in cases)]
    return _markdown(header, rows)


def _cell(found: dict[str, Any], *, ours: bool) -> str:
    return f"**{_number(found['us'])}**" if ours else f"{_number(found['us'])} ({_number(found['times_ours'])}×)"


def _floor(figures: dict[str, Any]) -> str:
    rows = [
        [
            case.replace(" | ", ", "),
            _number(found["read_masks_us"]),
            _number(found["task_us"]),
            _number(found["ours_us"]),
            f"{found['ours_us'] / found['task_us']:.1f}",
        ]
        for case, found in figures["floor"].items()
    ]
    return _markdown(["task, µs", "reading the 8 masks", "estimated floor", "ours", "ours / floor"], rows)


def _scaling(figures: dict[str, Any]) -> list[str]:
    heads = {
        "triangles": ["triangles", "IoU, Numba, µs", "IoU, NumPy, µs", "depth (crop), µs", "`Mesh(...)`, ms"],
        "poses": ["poses in a call (8 masks)", "µs per pose"],
        "masks": ["masks in a call (32 poses)", "µs per pose"],
        "pixels": ["pixels of the silhouette", "IoU, µs", "depth (crop), µs"],
    }
    return [
        _markdown(head, [[_number(value) for value in row.values()] for row in figures["scaling"][what]])
        for what, head in heads.items()
    ]


def _number(value: float) -> str:
    return f"{value:.1f}" if isinstance(value, float) and value < 20 else f"{value:,.0f}"


def _markdown(header: list[str], rows: list[list[str]]) -> str:
    rule = ["---", *["---:"] * (len(header) - 1)]
    return "\n".join("| " + " | ".join(row) + " |" for row in (header, rule, *rows))


if __name__ == "__main__":
    print(tables(json.loads(Path(sys.argv[1]).read_text())))
