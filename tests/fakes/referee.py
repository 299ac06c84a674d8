"""A referee who says what is written."""

from collections.abc import Sequence
from dataclasses import dataclass

from cell.interfaces import Contact, Outcome, Touch
from cell.records import State
from tests.fakes.script import HALF_WIDTH, scripted
from tests.fakes.station import FakeStation


@dataclass(frozen=True)
class Try:
    """How an attempt shall go: what the referee says of it, or where it is stopped, and where the jaws stop."""

    outcome: Outcome = Outcome.PLACED
    touches: tuple[State, Touch] | None = None
    part_half_width: float = HALF_WIDTH


VOID = Try(Outcome.VOID, part_half_width=0.0)
COLLISIONS = {
    Touch.BELT: Outcome.COLLISION_BELT,
    Touch.CONTAINER: Outcome.COLLISION_CONTAINER,
    Touch.PART: Outcome.COLLISION_PART,
    Touch.PRESSED: Outcome.COLLISION_CONTAINER,
    Touch.ROBOT: Outcome.COLLISION_ROBOT,
}


class FakeReferee:
    """Implements `cell.interfaces.Referee`: sets the scene for the n-th attempt and says what its script says."""

    def __init__(self, station: FakeStation, tries: Sequence[Try] = (Try(),), left_on_belt: int = 0) -> None:
        self._station, self._tries, self._left_on_belt = station, tries, left_on_belt
        self.container_slots: list[int] = []
        self.verdicts: list[Contact | None] = []

    def attempt_begins(self, container_slot: int) -> None:
        now = scripted(self._tries, len(self.container_slots))
        self.container_slots.append(container_slot)
        self._station.part_half_width = now.part_half_width
        if now.touches is not None:
            self._station.touches[now.touches[0]] = now.touches[1]

    def verdict(self, stopped_by: Contact | None) -> Outcome:
        self.verdicts.append(stopped_by)
        if stopped_by is not None:
            return COLLISIONS[stopped_by.touch]
        return scripted(self._tries, len(self.container_slots) - 1).outcome

    def parts_on_belt(self) -> int:
        return self._left_on_belt
