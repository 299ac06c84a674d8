"""Whether an experiment begins as it should: otherwise it has failed, and counts for no method."""

import numpy as np

from cell.interfaces import Touch
from sim.errors import StartError
from sim.runtime.world import World

_REST = (
    0.05  # m/s and rad/s: parts sleep when an experiment begins, or were nudged by 0.01 m/s to wake on a moving belt
)


def check_start(world: World) -> None:
    """Asks whether all parts lie still on the belt, which no slot of the container is, and none touches the robot.

    Raises:
        StartError: a part does not.
    """
    belt = world.belt_true
    near, far = np.array([belt.width / 2, belt.length / 2]), np.array([belt.width / 2, belt.length / 2 + belt.upstream])
    for index in range(world.parts):
        x, y, z = world.p_W_center_of_mass(index)
        offset = np.array([x - belt.center_x, y])
        if not ((-near <= offset).all() and (offset <= far).all() and z > belt.top_z):
            raise StartError(f"part {index} begins at ({x:.3f}, {y:.3f}, {z:.3f}) m, expected it on the belt")
        speed = float(np.abs(world.velocity(index)).max())
        if speed > _REST:
            raise StartError(f"part {index} begins with {speed:.2f} m/s or rad/s, expected it at rest")
    forces = np.linalg.norm(world.contact_forces()[world.touch_sensors()[Touch.PART]], axis=1)
    if forces.any():
        raise StartError(f"the robot begins with {forces.max():.1f} N against a part, expected no touch")
