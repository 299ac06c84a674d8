"""What the counts of a prediction come to.

`python -m experiments.prediction.summary FILE` rewrites a predict.json with everything that follows from its counts,
and prints its tables.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cell.records import Tally
from experiments.prediction.cells import PredictedCell, Rate, predict_cell
from experiments.prediction.joint import Joint, joint
from experiments.results.first_attempts import FirstAttempts
from experiments.results.paired import Paired, format_paired, pair
from experiments.results.paper import ROBOT_TABLE
from experiments.results.provenance import write_json
from experiments.setup.policies import policy_name
from maskval.inputs.files import read_input_text

_COLUMN = 27

Key = tuple[str, str]  # part and method


@dataclass(frozen=True, slots=True)
class Summary:
    """A variant's entry in predict.json.

    Attributes:
        cells: one per part and method.
        paired: the methods side by side; a world's experiments are the same with every one.
        joint: how far the paper's figures are from the cells that are predictions; see `experiments.prediction.joint`.
    """

    cells: list[PredictedCell]
    paired: list[Paired]
    joint: dict[str, Joint]


def summarise(
    counts: Mapping[Key, Sequence[Sequence[Tally]]],
    firsts: Mapping[Key, Sequence[Sequence[FirstAttempts]]],
    seed: int,
) -> Summary:
    """The cells of a variant and what they say together.

    Args:
        counts: Of each world's experiments, by part and method.
        firsts: First attempts of the same experiments, where they are known.
        seed: Root of the replicates' random numbers.
    """
    cells = [
        predict_cell(*key, worlds, ROBOT_TABLE.get(key), seed, firsts=firsts.get(key)) for key, worlds in counts.items()
    ]
    paired = [
        row
        for part in dict.fromkeys(part for part, _ in counts)
        for row in pair(
            part,
            {
                (method, policy_name(None, method)): worlds
                for (owner, method), worlds in counts.items()
                if owner == part
            },
        )
    ]
    return Summary(cells, paired, joint(cells, seed))


def reread(variant: Mapping[str, Any], seed: int = 0) -> Summary:
    """The summary of a variant's counts as they stand in a predict.json."""
    counts, firsts = {}, {}
    for cell in variant["cells"]:
        key = cell["object"], cell["method"]
        counts[key] = [[_count(*numbers) for numbers in world] for world in cell["counts"]]
        if cell.get("first_attempts") is not None:
            firsts[key] = [[FirstAttempts(*numbers) for numbers in world] for world in cell["first_attempts"]]
    return summarise(counts, firsts, seed)


def format_summary(name: str, summary: Summary) -> str:
    """A variant's table as text."""
    width = max(len(cell.method) for cell in summary.cells)
    lines = [
        f"{name}: mean [95 % of the means over 5 experiments] paper, in %; ! where the paper's lies outside",
        f"{'object':8} {'method':{width}} {'AP':>{_COLUMN}} {'AR':>{_COLUMN}}  first    TP   FP   on   FN  runs",
    ]
    for cell in summary.cells:
        first = "–" if cell.ap_first is None else f"{100 * cell.ap_first:.1f}"
        failed = "–" if cell.parts_failed is None else str(cell.parts_failed)
        lines.append(
            f"{cell.object:8} {cell.method:{width}} {_cell(cell.ap)} {_cell(cell.ar)} {first:>6} "
            f"{cell.tp:5} {cell.fp:4} {failed:>4} {cell.fn:4} {cell.experiments:5}"
        )
    if summary.joint:
        p = ", ".join(f"{part} {one.p:.2f}" for part, one in summary.joint.items())
        score = ", ".join(
            f"{part} {one.energy_score:.2f} ({one.random_energy_score:.2f})" for part, one in summary.joint.items()
        )
        lines += [
            f"without the row that the gap is fitted to, all figures jointly: p = {p}",
            f"energy score, low is good (of a random table): {score}",
        ]
    return "\n".join([*lines, format_paired(summary.paired)]) + "\n"


def _count(tp: int, fp: int, fn: int, timeouts: int) -> Tally:
    """A count of which nothing else matters here: every time slot is a TP, an FP or a time-out."""
    return Tally(parts=tp + fp + timeouts, tp=tp, fp=fp, fn=fn, void=0, unreachable=0, timeouts=timeouts, duration=0.0)


def _cell(rate: Rate) -> str:
    if rate.mean is None or rate.interval is None:
        return f"{'–':>{_COLUMN}}"
    low, high = rate.interval
    paper = "" if rate.paper is None else f" {100 * rate.paper:.1f}" + ("" if rate.agrees else " !")
    return f"{f'{100 * rate.mean:.1f} [{100 * low:.1f}, {100 * high:.1f}]{paper}':>{_COLUMN}}"


def main(file: Path) -> None:
    """Rewrites the file and prints its tables.

    Raises:
        SystemExit: the file cannot be read.
    """
    try:
        found = json.loads(read_input_text(file))
    except ValueError as error:
        raise SystemExit(f"error: {error}") from error
    for name, variant in found["variants"].items():
        found["variants"][name] = reread(variant)
        print(format_summary(name, found["variants"][name]))
    write_json(file, found)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
