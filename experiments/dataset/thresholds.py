"""The thresholds that a judged set gives, as the file that `compare --thresholds` takes."""

import json
import re
from collections.abc import Sequence

from experiments.dataset.score import Scored
from experiments.setup.methods import NEEDS_NO_THRESHOLD
from experiments.setup.thresholds import load_thresholds

_RULE = """\
# u_t,g by object and method: the largest u at which the poses kept have AP >= 0.99 at e_t = 15 mm, on generated test
# images. The refinement threshold u_t,r is the paper's. Written by
#     {command}"""
_LEAST_ERROR = """\
# No u of these reaches the AP. So that they can be compared, theirs sorts right and wrong poses with the fewest errors:
# wrong ones kept and right ones not kept count alike. `graspcell compare` says so."""


def thresholds_toml(sets: Sequence[Scored], command: str) -> str:
    """The thresholds of all methods that act upon one, by one rule; a method without a right pose has none.

    Args:
        sets: The parts' figures.
        command: What was typed to get them.
    """
    lines = [_RULE.format(command=command), "", f"refine = {load_thresholds('paper').refine!r}", "", "[grasp]"]
    others = []
    for one in sets:
        acting = [method for method in one.methods if method not in NEEDS_NO_THRESHOLD]
        reached = {method: one.methods[method]["u_tg"].value for method in acting}
        lines += ["", f"[grasp.{_key(one.object)}]", *_rows(reached)]
        missed = _rows({method: one.least_error_u[method] for method, u in reached.items() if u is None})
        others += ["", f"[least_error.{_key(one.object)}]", *missed] if missed else []
    lines += ["", _LEAST_ERROR, "[least_error]", *others] if others else []
    lines += ["", "# Where Ensemble-ADD's scale begins: the set's least disagreement of both estimators, in metres."]
    least = {one.object: one.least_disagreement_m for one in sets}
    return "\n".join([*lines, "[ensemble_add_minimum_m]", *_rows(least)]) + "\n"


def _rows(values: dict[str, float | None]) -> list[str]:
    return [f"{_key(name)} = {value!r}" for name, value in values.items() if value is not None]


def _key(name: str) -> str:
    """A TOML key, in quotes where it must be."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name)
