"""Why an attempt ended as it did, and what a table says, in plain sentences."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from cell.interfaces import Outcome
from experiments.results.paired import Paired
from experiments.results.table import Cell
from maskval.evaluation.summary import ERROR_THRESHOLD_M

Row = Mapping[str, Any]
_PARTLY = 0.85  # visible share below which it is said: the paper's θ_v
_DOING = {"approach": "on the way above the part", "descend": "on the way down", "close": "while it closed"}
_DOING |= {"lift": "while it lifted the part", "transfer": "on the way to the container"}
_DOING |= {"insert": "while the part went into its slot", "retreat": "on the way back"}
_HAPPENED = {
    Outcome.PLACED: "Placed in its slot.",
    Outcome.COLLISION_PART: "The gripper struck a part{force} {state}.",
    Outcome.COLLISION_BELT: "The gripper struck the belt{force} {state}.",
    Outcome.COLLISION_CONTAINER: "The container was struck{force} {state}.",
    Outcome.COLLISION_ROBOT: "The robot struck itself{force} {state}.",
    Outcome.DROPPED: "The part slipped out of the jaws {state}.",
    Outcome.MISPLACED: "The part did not lie in its slot at the end.",
    Outcome.VOID: "The jaws closed on nothing and touched nothing; it cost only time.",
    Outcome.UNREACHABLE: "No grasp of the estimated pose is within reach; it cost only time.",
}


def why_attempt(attempt: Row, estimate: Row | None, policy: str) -> str:
    """What happened in an attempt, how wrong its pose was, and why it was made: two or three sentences.

    Args:
        attempt: its row of the logs.
        estimate: the row of the detection that it was made for, if the logs have it.
        policy: what decided.
    """
    return " ".join((_happened(attempt), _pose(attempt, estimate), _judged(attempt, estimate, policy)))


def kind_of(outcome: str | None) -> str:
    """What an outcome counts as: placed, failed, cost (only time was lost) or time-out."""
    if outcome is None:
        return "time-out"
    verdict = Outcome(outcome)
    return "placed" if verdict.is_true_positive else "failed" if verdict.is_false_positive else "cost"


def is_wrong(estimate: Row | None) -> bool:
    """Whether a pose is off by more than the paper's e_t, or shows no part."""
    error = None if estimate is None else estimate.get("true_mdd_m")
    return error is None or error > ERROR_THRESHOLD_M


def why_time_out(seconds: float, refused: Sequence[tuple[Row, Row]], looks: int, tried: Sequence[str]) -> str:
    """Why a part's time ran out.

    Args:
        seconds: how long the slot was.
        refused: of the looks in it at which a detection was refused, the decision and its estimate.
        looks: how many there were.
        tried: outcomes of the attempts in the slot, none of which ended it.
    """
    told = [f"The {seconds:.0f} s of this part ran out after {looks} look{'s' * (looks != 1)}."]
    if tried:
        what = " and ".join(dict.fromkeys(tried))
        told.append(f"{len(tried)} attempt{'s' * (len(tried) > 1)} in it came to nothing ({what}).")
    if refused:
        decision, estimate = min(refused, key=lambda pair: pair[0]["u"])
        threshold = decision["threshold"]
        above = "" if threshold is None else f", above the threshold {threshold:.2f}"
        told.append(f"The least u that was refused is {decision['u']:.2f}{above}.")
        if estimate["true_part"] is None:
            told.append("That detection shows no part: rightly refused.")
        elif is_wrong(estimate):
            told.append(f"Its pose was {_mm(estimate)} off{_partly(estimate)}: rightly refused.")
        else:
            told.append(f"Its pose was only {_mm(estimate)} off{_partly(estimate)}: it would probably have held.")
    elif not tried:
        told.append("The looks found no part that the policy could decide about.")
    return " ".join(told)


def verdict(cells: Sequence[Cell], names: Mapping[tuple[str, str], str], pairs: Sequence[Paired] = ()) -> str:
    """Which method places most parts, and from which others it cannot be told apart, for the cells of one part.

    Args:
        cells: of one part in one run.
        names: what each method and policy is called.
        pairs: the run's differences between methods.
    """
    done = [cell for cell in cells if cell.experiments]
    if not done:
        return "No experiment has a result yet."
    ranked = sorted(done, key=lambda cell: -cell.tp / cell.experiments)
    best, others = ranked[0], ranked[1:]
    failed = f"{best.fp} failed attempt{'s' * (best.fp != 1)}"
    told = f"{names[best.method, best.policy]} places {_share(best)} of the parts with {failed}"
    if not others:
        return f"{told}."
    level = [names[cell.method, cell.policy] for cell in others if best.same and _shares_letter(cell, best)]
    rest = "; ".join(f"{names[cell.method, cell.policy]} {_share(cell)} with {cell.fp}" for cell in others)
    if not best.same:
        apart = "No test says whether they differ."
    elif level:
        apart = f"It cannot be told apart from {_listed(level)} in parts placed."
    else:
        apart = "The differences in parts placed are significant (5 %, Holm)."
    return " ".join((f"{told}; {rest}. {apart}", *_failing(best, names, pairs)))


def _failing(best: Cell, names: Mapping[tuple[str, str], str], pairs: Sequence[Paired]) -> Iterator[str]:
    """Which methods fail more or fewer attempts than the best, if that is what others are compared with."""
    reference = best.object, best.method, best.policy
    own = [row for row in pairs if (row.object, row.reference, row.reference_policy) == reference and row.failed_ci]
    for word, place, sign in (("more", 0, 1), ("fewer", 1, -1)):
        found = [names[row.method, row.policy] for row in own if row.failed_ci and sign * row.failed_ci[place] > 0]
        if found:
            verb = "fails" if len(found) == 1 else "fail"
            yield f"{_listed(found)} {verb} {word} attempts (95 % interval)."


def _happened(attempt: Row) -> str:
    state = _DOING.get(attempt["last_state"], f"in state {attempt['last_state']}")
    force = "" if attempt["contact_force_N"] is None else f" with {attempt['contact_force_N']:.0f} N"
    return _HAPPENED[Outcome(attempt["outcome"])].format(force=force, state=state)


def _pose(attempt: Row, estimate: Row | None) -> str:
    if estimate is None:
        return "The logs have no estimate for it."
    if estimate["true_part"] is None:
        return "The detection shows no part at all."
    if not is_wrong(estimate):
        return f"Its pose was right within {_mm(estimate)}{_partly(estimate)}."
    held = attempt["outcome"] == Outcome.PLACED
    why = (
        "; the part may look the same from there (of symmetries, those of the part's file are counted)" if held else ""
    )
    return f"Its pose was {_mm(estimate)} off{_partly(estimate)}{why}."


def _judged(attempt: Row, estimate: Row | None, policy: str) -> str:
    u, threshold = attempt["u"], attempt["threshold"]
    if threshold is None:
        return f"The policy “{policy}” set no bound on u."
    if kind_of(attempt["outcome"]) != "placed" and is_wrong(estimate):
        return f"u = {u:.2f} stayed within the threshold {threshold:.2f}, so the error went unnoticed."
    return f"u = {u:.2f} met the threshold {threshold:.2f}."


def _mm(estimate: Row) -> str:
    return f"{1000 * estimate['true_mdd_m']:.1f} mm"


def _partly(estimate: Row) -> str:
    visible = estimate["true_visibility"]
    return f" (only {100 * visible:.0f} % of the part was visible)" if visible < _PARTLY else ""


def _share(cell: Cell) -> str:
    return f"{100 * cell.tp / cell.parts:.0f} %"


def _shares_letter(one: Cell, other: Cell) -> bool:
    return bool(set(one.same or "") & set(other.same or ""))


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
