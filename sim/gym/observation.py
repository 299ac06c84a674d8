"""How a learner observes the detections: arrays of a fixed size, padded with zeros, without any truth."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from cell.interfaces import Observation
from cell.perception import Perception
from maskval import Camera, Estimates, Needs, Pose, UncertaintyMethod, needs_of, silhouette
from sim.gym.options import EnvOptions
from sim.instance_ids import PIXEL_CENTER

Array = NDArray[np.float64]
Encoded = dict[str, Any]  # arrays by name, as `gymnasium.spaces.Dict` has them

WORKSPACE = 2.0  # m from the robot's base in each direction; the arm reaches 1.3 m, estimates beyond are clipped
DEPTH_RANGE = 10.0  # m; the floor is 1.5 m from the highest view


class DetectionEncoder:
    """Per detection, in the order of the detector's scores: one row of each entry of the space, flattened.

    They are flat, because learning libraries take arrays of one dimension or images; `reshape(max_detections, -1)`
    restores the rows.
    """

    def __init__(self, options: EnvOptions, camera: Camera) -> None:
        self._count, self._images, self._camera = options.max_detections, options.images, camera
        self._methods = tuple(options.methods)

    @property
    def spaces(self) -> dict[str, spaces.Space[Any]]:
        """The space of each entry."""
        n = self._count
        share = (0.0, 1.0)
        found: dict[str, spaces.Space[Any]] = {"valid": spaces.MultiBinary(n)}
        for name in self._methods:
            found[f"u_{name}"] = box(n, *share)
        found |= {
            "score": box(n, *share),
            "visibility": box(n, *share),
            "mask_area": box(n, *share),
            "box": box(4 * n, *share),
            "position": box(3 * n, -WORKSPACE, WORKSPACE),
            "orientation": box(4 * n, -1.0, 1.0),
        }
        size = (self._camera.height, self._camera.width)
        kinds: dict[str, spaces.Space[Any]] = {
            "rgb": spaces.Box(0, 255, (*size, 3), np.uint8),
            "depth": spaces.Box(0.0, DEPTH_RANGE, (*size, 1), np.float32),
            "masks": spaces.Box(0, 255, (*size, 1), np.uint8),
        }
        return found | {name: kinds[name] for name in self._images}

    def empty(self) -> Encoded:
        """Without any detection."""
        return {name: np.zeros(space.shape or (), space.dtype) for name, space in self.spaces.items()}

    def encode(
        self, observation: Observation, perception: Perception, methods: Mapping[str, UncertaintyMethod]
    ) -> Encoded:
        """The entries of an observation.

        Args:
            observation: what was concluded from a picture.
            perception: what concluded it, with the first of the methods.
            methods: the episode's, by name.
        """
        values = self.empty()
        poses = observation.poses[0][: self._count]
        masks = [detection.mask for detection in observation.detections[: self._count]]
        n = len(poses)
        values["valid"][:n] = 1
        for name, u in _uncertainties(observation, perception, methods).items():
            values[f"u_{name}"][:n] = u[:n]
        X_BO_est = [observation.X_BO_est(index) for index in range(n)]
        rows: dict[str, Callable[[int], float | Array]] = {
            "score": lambda i: observation.detections[i].score,
            "visibility": lambda i: self._visibility(perception, poses[i]),
            "mask_area": lambda i: float(masks[i].mean()),
            "box": lambda i: box_around(masks[i]),
            "position": lambda i: np.clip(X_BO_est[i].translation, -WORKSPACE, WORKSPACE),
            "orientation": lambda i: np.clip(X_BO_est[i].quaternion_wxyz, -1.0, 1.0),
        }
        for name, row in rows.items():
            table = values[name].reshape(self._count, -1)  # a view
            for index in range(n):
                table[index] = row(index)
        return values | self._pictures(observation, masks)

    def _visibility(self, perception: Perception, X_CO_est: Pose) -> float:
        """The share of the estimated part's silhouette that lies in the image; occlusion is not known."""
        return silhouette(perception.part.mesh, X_CO_est, self._camera, pixel_center=PIXEL_CENTER).visibility

    def _pictures(self, observation: Observation, masks: list[NDArray[np.bool_]]) -> Encoded:
        frame, found = observation.frame, Encoded()
        if "rgb" in self._images and frame.rgb is not None:
            found["rgb"] = frame.rgb.copy()
        if "depth" in self._images and frame.depth is not None:
            found["depth"] = np.minimum(frame.depth, np.float32(DEPTH_RANGE))[..., np.newaxis]
        if "masks" in self._images:
            numbers = np.zeros((self._camera.height, self._camera.width, 1), np.uint8)
            for index in reversed(range(len(masks))):  # the better score lies on top
                numbers[masks[index]] = index + 1
            found["masks"] = numbers
        return found


def _uncertainties(
    observation: Observation, perception: Perception, methods: Mapping[str, UncertaintyMethod]
) -> dict[str, Array]:
    """The u of all detections by method; the perception has already called the first method."""
    first, *others = methods
    seen = observation.frame, observation.detections, observation.poses, observation.correspondences
    asked = {name: replace(perception, method=methods[name]).uncertainties(*seen) for name in others}
    return {first: observation.uncertainties} | asked


class AllMethods:
    """Implements `maskval.UncertaintyMethod` with the first of several; it needs what any of them needs."""

    def __init__(self, methods: dict[str, UncertaintyMethod]) -> None:
        self._first = next(iter(methods.values()))
        self.needs = Needs.together(*map(needs_of, methods.values()))

    def __call__(self, estimates: Estimates) -> Array:
        """The first method's u, (N,)."""
        return self._first(estimates)


def box(size: int, low: float, high: float) -> spaces.Box:
    """A vector of float32 with these bounds."""
    return spaces.Box(low, high, (size,), np.float32)


def box_around(mask: NDArray[np.bool_]) -> Array:
    """Left, top, right and bottom of a mask as shares of the image's width and height, (4,); zeros for an empty one."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    if not len(rows):
        return np.zeros(4)
    height, width = mask.shape
    return np.array([columns[0] / width, rows[0] / height, (columns[-1] + 1) / width, (rows[-1] + 1) / height])
