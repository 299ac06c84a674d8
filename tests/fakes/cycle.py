"""A whole cycle on the fakes, and what it told."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from cell.cycle import Cycle, CycleConfig
from cell.interfaces import Listener, Policy, Touch
from cell.perception import Perception
from cell.records import AttemptRecord, DecisionRecord, State, Tally, TimeSlot, Transition
from tests.fakes.estimators import FakeMasks, FakeMethod, FakePoses, PoseScript
from tests.fakes.referee import FakeReferee, Try
from tests.fakes.scene import brick, on_belt, small_layout, turned
from tests.fakes.script import MOVE_TIME, SETTLE_TIME
from tests.fakes.station import FakeStation

T = TypeVar("T")


class Records:
    """A listener that keeps every record and lets the station know in which state the controller is."""

    def __init__(self, station: FakeStation) -> None:
        self._station = station
        self.all: list[object] = []

    def __call__(self, record: object) -> None:
        if isinstance(record, Transition):
            self._station.state = record.target
        self.all.append(record)

    def of(self, kind: type[T]) -> list[T]:
        return [record for record in self.all if isinstance(record, kind)]


@dataclass(frozen=True)
class Experiment:
    """A cycle that has run, with everything that took part in it."""

    count: Tally
    records: Records
    station: FakeStation
    referee: FakeReferee

    @property
    def transitions(self) -> list[Transition]:
        return self.records.of(Transition)

    @property
    def seen(self) -> list[DecisionRecord]:
        return self.records.of(DecisionRecord)

    @property
    def attempts(self) -> list[AttemptRecord]:
        return self.records.of(AttemptRecord)

    @property
    def slots(self) -> list[TimeSlot]:
        return self.records.of(TimeSlot)


def run_cycle(
    policy: Policy,
    *,
    config: CycleConfig | None = None,
    masks: Callable[[FakeStation], FakeMasks] | Sequence[Sequence[float]] = ((0.9,),),
    X_BO: PoseScript | None = None,
    X_BO_second: PoseScript | None = None,
    u: Sequence[float | Sequence[float]] = (0.0,),
    tries: Sequence[Try] = (Try(),),
    touches: dict[State, Touch] | None = None,
    left_on_belt: int = 0,
    listener: Listener | None = None,
    belt_speed: float = 0.0,
) -> Experiment:
    """Runs a cycle on the fakes; unless scripted otherwise every frame shows one certain part that can be placed.

    Given `X_BO_second`, there is a second pose estimator, and the method needs both.
    """
    layout, part = small_layout(belt_speed), brick()
    station = FakeStation(layout, move_time=MOVE_TIME, touches=touches)
    referee, records = FakeReferee(station, tries, left_on_belt), Records(station)
    detector = masks(station) if callable(masks) else FakeMasks(masks)
    estimators = [FakePoses(X_BO or [on_belt(part, layout, turned())])]
    if X_BO_second is not None:
        estimators.append(FakePoses(X_BO_second))
    cycle = Cycle(
        station=station,
        referee=referee,
        perception=Perception(part, detector, tuple(estimators), FakeMethod(u, len(estimators)), pixel_center=0.5),
        policy=policy,
        layout=layout,
        config=config or CycleConfig(parts=1, settle_time=SETTLE_TIME),
        listener=listener or records,
    )
    return Experiment(cycle.run(), records, station, referee)
