"""The truth about an attempt: where the part really is."""

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Contact, Outcome, Touch
from sim.model.fixtures import TRAY_MARGIN
from sim.runtime.station import SimStation
from sim.runtime.world import World

MAX_TILT = np.radians(20.0)  # from how the part lay on the belt
SLOT_TOLERANCE = 0.001  # m, of contact's softness

_COLLISIONS = {
    Touch.BELT: Outcome.COLLISION_BELT,
    Touch.CONTAINER: Outcome.COLLISION_CONTAINER,
    Touch.PRESSED: Outcome.COLLISION_CONTAINER,
    Touch.PART: Outcome.COLLISION_PART,
    Touch.ROBOT: Outcome.COLLISION_ROBOT,
}


class SimReferee:
    """Implements `cell.interfaces.Referee` by looking into the world."""

    def __init__(self, world: World, station: SimStation) -> None:
        self._world, self._station = world, station
        self._container_slot = 0
        self._up = self._upwards()

    def attempt_begins(self, container_slot: int) -> None:
        """See `Referee`."""
        self._container_slot = container_slot
        self._up = self._upwards()
        self._station.forget_touches()

    def verdict(self, stopped_by: Contact | None) -> Outcome:
        """See `Referee`."""
        if stopped_by is not None:
            return _COLLISIONS[stopped_by.touch]
        touched = self._station.touched_parts()
        if not touched:
            return Outcome.VOID
        if any(self._is_placed(part) for part in touched):
            return Outcome.PLACED
        if any(not self.is_on_belt(part) and self._is_over_container(part) for part in touched):
            return Outcome.MISPLACED
        return Outcome.DROPPED

    def parts_on_belt(self) -> int:
        """See `Referee`."""
        return sum(self.is_on_belt(part) or self._has_left(part) for part in range(self._world.parts))

    def is_on_belt(self, part: int) -> bool:
        """Whether the part's middle is over the belt and no part of it far below."""
        belt = self._world.layout.belt
        vertices = self._vertices_W(part)
        x, y = (vertices[:, :2].min(axis=0) + vertices[:, :2].max(axis=0)) / 2
        over = abs(x - belt.center_x) <= belt.width / 2 and -belt.length / 2 <= y <= belt.length / 2 + belt.upstream
        return bool(over and vertices[:, 2].min() > belt.top_z - 0.02)

    def _has_left(self, part: int) -> bool:
        """Whether a moving belt has carried the part over its end, where the tray is."""
        belt = self._world.layout.belt
        x, y, _ = self._world.X_WO(part).translation
        return bool(belt.speed and y < -belt.length / 2 and abs(x - belt.center_x) <= belt.width / 2 + TRAY_MARGIN)

    def _is_placed(self, part: int) -> bool:
        vertices = self._vertices_W(part)
        container, slot_size = self._world.layout.container, self._world.part_model.part.slot_size
        center = container.slot_center(self._container_slot, slot_size)
        inside = np.all(np.abs(vertices[:, :2] - center[:2]) <= np.array(slot_size) / 2 + SLOT_TOLERANCE)
        on_floor = vertices[:, 2].min() < container.floor_z + container.wall_height / 2
        tilt = np.arccos(np.clip(self._up[part] @ self._upwards()[part], -1.0, 1.0))
        return bool(inside and on_floor and tilt < MAX_TILT)

    def _is_over_container(self, part: int) -> bool:
        container, (size_x, size_y) = self._world.layout.container, self._world.part_model.part.slot_size
        x, y = self._vertices_W(part)[:, :2].mean(axis=0)
        half_x = container.columns * (size_x + container.wall_thickness) / 2
        half_y = container.rows * (size_y + container.wall_thickness) / 2
        return bool(abs(x - container.center_x) <= half_x and abs(y - container.center_y) <= half_y)

    def _vertices_W(self, part: int) -> NDArray[np.float64]:
        return self._world.X_WO(part).apply(self._world.part_model.part.mesh.vertices)

    def _upwards(self) -> NDArray[np.float64]:
        """The direction up, seen from every part, (parts, 3)."""
        return np.array([self._world.X_WO(part).rotation[2] for part in range(self._world.parts)])
