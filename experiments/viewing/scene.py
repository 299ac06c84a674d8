"""The cell as a scene of viser: bodies, the wrist camera with what it showed, estimated poses, and a line of words."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cell.records import DecisionRecord
from experiments.observing.drawing import MODEL
from experiments.observing.observer import Status
from experiments.observing.words import headline
from maskval import Pose
from sim.runtime.bodies import Bodies
from sim.runtime.world import World
from sim.scenery.lighting import EYE, TARGET

_FRUSTUM = 0.12  # m: how far in front of the camera its picture is drawn
_FIELD = 0.75  # rad: what a browser shows from top to bottom
_MOVED = 1e-4  # m, and of a quaternion: below it nothing is sent


class Scene:
    """Draws moments of an experiment on a server of viser.

    Args:
        server: viser's.
        world: where the experiment runs.

    Attributes:
        bodies: of the world.
    """

    def __init__(self, server: Any, world: World) -> None:
        self._scene, self._world, self.bodies = server.scene, world, Bodies(world)
        self._frames: dict[str, Any] = {}
        self._places: dict[str, NDArray[np.float64]] = {}
        self._decided: DecisionRecord | None = None
        self._look: Any = None
        self._estimates: list[Any] = []
        server.initial_camera.position, server.initial_camera.look_at = EYE, TARGET
        server.initial_camera.up, server.initial_camera.fov = (0.0, 0.0, 1.0), _FIELD
        self._scene.set_up_direction("+z")
        self._add_bodies()
        camera = world.layout.camera
        self._camera = self._scene.add_camera_frustum(
            "/camera",
            fov=2 * np.arctan(camera.height / 2 / camera.fy),
            aspect=camera.width / camera.height,
            scale=_FRUSTUM,
            color=MODEL,
        )
        x, y, z = TARGET
        self._words = self._scene.add_label("/words", "", position=(x, y, z + 1.25), anchor="bottom-center")

    def show(
        self,
        status: Status,
        time: float,
        positions: NDArray[np.floating] | None = None,
        look: NDArray[np.uint8] | None = None,
    ) -> None:
        """Draws a moment.

        Args:
            status: what is known.
            time: s.
            positions: of the joints; as they are now by default.
            look: the newest look's picture, (H, W, 3), where there is one.
        """
        places, X_WC = self.bodies.at(positions)
        for name, place in places.items():
            self._move(name, self._frames[name], place)
        self._move("/camera", self._camera, np.concatenate((X_WC.translation, X_WC.quaternion_wxyz)))
        if status.decided is not self._decided:
            self._decided = status.decided
            self._show_look(status.decided, look)
        words = headline(status, time, self._world.parts)
        if words != self._words.text:
            self._words.text = words

    def _add_bodies(self) -> None:
        for number, shape in enumerate(self.bodies.shapes):
            if shape.body not in self._frames:
                self._frames[shape.body] = self._scene.add_frame(f"/{shape.body}", show_axes=False)
            name = f"/{shape.body}/{number}"
            self._scene.add_mesh_simple(name, shape.vertices, shape.faces, color=shape.rgb, flat_shading=True)

    def _move(self, name: str, handle: Any, place: NDArray[np.float64]) -> None:
        """Sends where something is, if it has moved."""
        before = self._places.get(name)
        if before is None or np.abs(place - before).max() > _MOVED:
            self._places[name] = place
            handle.position, handle.wxyz = place[:3], place[3:]

    def _show_look(self, decided: DecisionRecord | None, look: NDArray[np.uint8] | None) -> None:
        """The frustum of the newest look with its picture, and the model at each estimated pose."""
        for handle in self._estimates:
            handle.remove()
        self._estimates = []
        if decided is None:
            return
        observation, mesh = decided.observation, self._world.part_model.part.mesh
        X_WC = self._world.layout.X_WB @ observation.frame.X_BC
        if look is not None:
            self._estimates.append(self._frustum(X_WC, look))
        for index, X_CO in enumerate(observation.poses[0]):
            X_WO = X_WC @ X_CO
            self._estimates.append(
                self._scene.add_mesh_simple(
                    f"/estimate/{index}",
                    mesh.vertices.astype(np.float32),
                    mesh.faces.astype(np.uint32),
                    color=MODEL,
                    wireframe=index != decided.decision.detection,
                    opacity=0.5,
                    position=X_WO.translation,
                    wxyz=X_WO.quaternion_wxyz,
                )
            )

    def _frustum(self, X_WC: Pose, look: NDArray[np.uint8]) -> Any:
        camera = self._world.layout.camera
        return self._scene.add_camera_frustum(
            "/look",
            fov=2 * np.arctan(camera.height / 2 / camera.fy),
            aspect=camera.width / camera.height,
            scale=_FRUSTUM,
            image=look[::2, ::2],
            position=X_WC.translation,
            wxyz=X_WC.quaternion_wxyz,
        )
