"""When a run may stop: as soon as its conditions are answered, with an error rate that holds at every look."""

from collections.abc import Hashable, Iterable, Sequence

from cell.records import Tally
from experiments.errors import UsageError
from experiments.results.counted import Counted, Of
from experiments.setup.experiment import ExperimentSpec
from experiments.setup.policies import policy_name
from experiments.statistics.until import Condition, Judgement, Quantity, judge, parse_condition
from sim.model.parts import load_part


class Stopping:
    """Conditions on a run, and what its experiments say about them so far.

    An answer rests on the leading experiments, by number, that have all ended. So it is the same for any number of
    workers and any order in which they finish.

    Args:
        texts: the conditions, see `parse_condition`.
        specs: the experiments planned.

    Raises:
        UsageError: a condition is none, or of an object or method that is not compared.
    """

    def __init__(self, texts: Sequence[str], specs: Sequence[ExperimentSpec]) -> None:
        cells: dict[Of, list[ExperimentSpec]] = {}
        for spec in specs:
            of = load_part(spec.part).part.name, spec.method, policy_name(spec.policy, spec.method)
            cells.setdefault(of, []).append(spec)
        self._texts = tuple(texts)
        self._parts = specs[0].parts
        self._worlds = {of[0]: [spec.noise or spec.experiment for spec in group] for of, group in cells.items()}
        self._counted: dict[Of, dict[int, Counted]] = {of: {} for of in cells}
        self._questions = [
            _Question(text, part, *_cells_of(condition, part, tuple(cells)), condition)
            for text, condition in ((text, parse_condition(text)) for text in texts)
            for part in dict.fromkeys(of[0] for of in cells)
            if condition.part in (None, part)
        ]
        for text in texts:
            if not any(question.text == text for question in self._questions):
                raise UsageError(f'expected an object of {", ".join(self._worlds)} in "{text}"')
        self._judged: dict[int, tuple[int, Judgement]] = {}

    def add(self, counted: Counted) -> bool:
        """Takes one more experiment into account; returns whether all conditions are answered."""
        if counted.of in self._counted:
            self._counted[counted.of][counted.experiment] = counted
        return all(self._judgement(number).holds is not None for number in range(len(self._questions)))

    @property
    def experiments(self) -> int | None:
        """With how many experiments, from the first, all conditions were answered; None before."""
        found = [self._judgement(number).experiments for number in range(len(self._questions))]
        return max((number for number in found if number is not None), default=None) if None not in found else None

    def lines(self) -> list[str]:
        """The answers, or how far they are, in words."""
        return [question.told(self._judgement(number)) for number, question in enumerate(self._questions)]

    def _judgement(self, number: int) -> Judgement:
        question = self._questions[number]
        leading = min(_leading(self._counted[of]) for of in question.cells)
        if self._judged.get(number, (-1, None))[0] != leading:
            self._judged[number] = leading, self._judge(question, leading)
        return self._judged[number][1]

    def _judge(self, question: "_Question", leading: int) -> Judgement:
        values = [
            [_value(question.condition.quantity, self._counted[of][number].count) for number in range(leading)]
            for of in question.cells
        ]
        worlds: Sequence[Hashable] = self._worlds[question.part]
        return judge(question.condition, *values, worlds=worlds, parts=self._parts)


class _Question:
    """One condition for one object."""

    def __init__(self, text: str, part: str, first: Of, second: Of | None, condition: Condition) -> None:
        self.text, self.part, self.condition = text, part, condition
        self.cells = (first,) if second is None else (first, second)

    def told(self, judgement: Judgement) -> str:
        """The answer in words."""
        if judgement.mean is None:
            return f"{self.part}: {self.text}: nothing is known yet"
        low, high = judgement.interval()
        figures = f"{judgement.mean:.3f} [{low:.3f}, {high:.3f}]"
        if judgement.holds is None:
            return f"{self.part}: {self.text}: not answered; {figures} at all looks"
        answer = "yes" if judgement.holds else "no"
        return f"{self.part}: {self.text}: {answer}, after {judgement.experiments} experiments; {figures} at all looks"


def _cells_of(condition: Condition, part: str, cells: Iterable[Of]) -> tuple[Of, Of | None]:
    """The cells that a condition is about."""
    methods: dict[str, list[Of]] = {}
    for of in cells:
        if of[0] == part:
            methods.setdefault(of[1], []).append(of)

    def cell(method: str) -> Of:
        if method not in methods:
            raise UsageError(f"expected one of {', '.join(methods)} in --until, got {method}")
        if len(methods[method]) > 1:
            raise UsageError(f"expected one policy with --until, got {len(methods[method])} for {method}")
        return methods[method][0]

    return cell(condition.method), None if condition.other is None else cell(condition.other)


def _leading(counted: dict[int, Counted]) -> int:
    """How many experiments from number 0 on have ended, without a gap."""
    number = 0
    while number in counted:
        number += 1
    return number


def _value(quantity: Quantity, count: Tally | None) -> float | None:
    if count is None:
        return None
    return {"ap": count.ap, "ar": count.ar, "placed": float(count.tp), "failed": float(count.fp)}[quantity]
