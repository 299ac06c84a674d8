"""Where the bodies of a world are, and what they look like: to show the cell without OpenGL."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.runtime.pictures import scenery_of
from sim.runtime.world import World
from sim.scenery.shapes import Shape, shapes_of

Places = dict[str, NDArray[np.float64]]  # of bodies by name: position in W (m) and quaternion wxyz, (7,)


class Bodies:
    """The bodies of a world that can be seen.

    Args:
        world: whose they are.

    Attributes:
        shapes: what they look like.

    Raises:
        MeshesMissingError: the maker's meshes are asked for and not installed.
    """

    def __init__(self, world: World) -> None:
        self._world, self._mj_model = world, scenery_of(world)
        self._data = mujoco.MjData(self._mj_model)
        self.shapes: list[Shape] = shapes_of(self._mj_model)
        self._numbers = {shape.body: self._mj_model.body(shape.body).id for shape in self.shapes}
        self._wrist = self._mj_model.camera("wrist").id

    def at(self, positions: NDArray[np.floating] | None = None) -> tuple[Places, Pose]:
        """Where they are, and the wrist camera's X_WC.

        Args:
            positions: of the joints, as a `Film` has them; as they are now by default.
        """
        data = self._data
        data.qpos[:] = self._world.data.qpos if positions is None else positions
        mujoco.mj_kinematics(self._mj_model, data)
        mujoco.mj_camlight(self._mj_model, data)
        places = {name: np.concatenate((data.xpos[body], data.xquat[body])) for name, body in self._numbers.items()}
        rotation = data.cam_xmat[self._wrist].reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
        return places, Pose(rotation, data.cam_xpos[self._wrist])
