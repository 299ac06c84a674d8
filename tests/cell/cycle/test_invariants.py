"""Whatever happens."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from cell.interfaces import Detection, Frame, Outcome, Touch
from cell.records import State
from maskval import Pose
from tests.cell.cycle.runs import CAREFUL, FAR, HERE, ON_ITS_SIDE, config
from tests.fakes import ATTEMPT, VOID, FakeMasks, FakeStation, Try, run_cycle, scripted


@dataclass(frozen=True)
class Happening:
    """What one look meets: whether a part is seen, how uncertain it is, where it is, and a contact thereafter."""

    seen: bool
    u: float
    X_BO: Pose
    touch_on_the_way: bool


class EventfulMasks(FakeMasks):
    """Sees what happens, and puts things in the way of the camera's next move."""

    def __init__(self, station: FakeStation, happenings: Sequence[Happening]) -> None:
        super().__init__([[0.9] if happening.seen else [] for happening in happenings])
        self._station, self._happenings, self._looks = station, happenings, 0

    def detect(self, frame: Frame) -> Sequence[Detection]:
        if scripted(self._happenings, self._looks).touch_on_the_way:
            self._station.touches |= {State.SEARCH: Touch.ROBOT, State.REFINE: Touch.ROBOT}
        self._looks += 1
        return super().detect(frame)


HAPPENINGS = st.builds(
    Happening,
    seen=st.booleans(),
    u=st.sampled_from([0.0, 0.2, 0.4, 0.6, 0.9]),
    X_BO=st.sampled_from([HERE, ON_ITS_SIDE, FAR]),
    touch_on_the_way=st.booleans(),
)
FINISHED = st.sampled_from([Outcome.PLACED, Outcome.PLACED, Outcome.DROPPED, Outcome.MISPLACED]).map(Try)
STOPPED = st.sampled_from([*ATTEMPT]).map(lambda state: Try(touches=(state, Touch.CONTAINER)))


@given(
    happenings=st.lists(HAPPENINGS, min_size=1, max_size=12),
    tries=st.lists(st.one_of(FINISHED, STOPPED, st.just(VOID)), min_size=1, max_size=6),
    config=st.builds(config, st.integers(1, 4), st.sampled_from([1.0, 6.0, 12.0])),
    left_on_belt=st.integers(0, 4),
)
@settings(max_examples=200, deadline=None)
def test_whatever_happens_every_part_has_one_slot_and_every_slot_is_a_tp_an_fp_or_a_timeout(
    happenings, tries, config, left_on_belt
):
    experiment = run_cycle(
        CAREFUL,
        config=config,
        masks=lambda station: EventfulMasks(station, happenings),
        X_BO=[happening.X_BO for happening in happenings],
        u=[happening.u for happening in happenings],
        tries=tries,
        left_on_belt=left_on_belt,
    )
    count, slots = experiment.count, experiment.slots
    assert count.tp + count.fp + count.timeouts == config.parts
    assert count.fn == left_on_belt

    assert [slot.index for slot in slots] == list(range(config.parts))
    assert slots[0].start == 0.0
    assert all(before.end == after.start for before, after in pairwise(slots))
    assert slots[-1].end == count.duration == experiment.station.time
    outcomes = [slot.outcome for slot in slots]
    assert outcomes.count(Outcome.PLACED) == count.tp
    assert outcomes.count(None) == count.timeouts
    assert all(slot.end >= slot.start + config.slot_time for slot in slots if slot.outcome is None)

    attempted = [attempt.outcome for attempt in experiment.attempts]
    assert attempted.count(Outcome.PLACED) == count.tp
    assert attempted.count(Outcome.VOID) == count.void
    assert attempted.count(Outcome.UNREACHABLE) == count.unreachable
    camera_contacts = sum(
        motion.contact is not None and motion.state in (State.SEARCH, State.REFINE)
        for motion in experiment.station.motions
    )
    assert sum(outcome.is_false_positive for outcome in attempted) + camera_contacts == count.fp
    assert all(attempt.start < slots[attempt.slot].start + config.slot_time for attempt in experiment.attempts)
    assert all(attempt.u <= 0.2 for attempt in experiment.attempts)

    transitions = experiment.transitions
    assert all(before.target is after.source for before, after in pairwise(transitions))
    assert (transitions[0].source, transitions[-1].target) == (State.SEARCH, State.DONE)
