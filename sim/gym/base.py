"""What the learning environments have in common: a world of their own, seeds, pictures and the truth for `info`."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Generic, SupportsFloat, TypeVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame, Image, MaskEstimator, Observation, Outcome
from cell.layout import Layout
from cell.part import pose_error
from maskval import UncertaintyMethod
from maskval.inputs.spelling import shown
from sim.errors import EnvOptionError, NetworkError
from sim.gym.checks import check_keys, check_kind, check_name, check_whole
from sim.gym.observation import AllMethods, DetectionEncoder, Encoded
from sim.gym.options import LEARNED, EnvOptions
from sim.gym.recording import Notes
from sim.learned.estimators import learned_estimators
from sim.learned.weights import networks_of
from sim.model.parts import load_part
from sim.networks.estimators import Kind
from sim.networks.ground_truth import LatestTruth
from sim.networks.noise_model import PartNoise, load_noise
from sim.networks.random_streams import Streams
from sim.runtime.episode import Episode, Estimators, SimCell, begin_episode, build_cell
from sim.runtime.pictures import Pictures
from sim.runtime.viewer import Window, has_display

Action = TypeVar("Action")
MOST_SIZE = (1080, 1920)  # px, what the model's off-screen buffer holds
TIME_LIMIT = 3600.0  # s of the wall clock per call of a network or method: learning keeps machines busy for hours

Info = dict[str, Any]
Step = tuple[Encoded, SupportsFloat, bool, bool, Info]


class CellEnv(gymnasium.Env[Encoded, Action], Generic[Action]):
    """An episode is one experiment: parts on the belt, each with its time slot.

    `reset(seed=s)` begins experiment 0 of seed s, every `reset()` after it the next one: the same parts in the same
    poses, seen with the same errors, as `graspcell compare --seed s` has. `reset(options={"noise": …})` changes
    parameters of the error model for one episode. The world is built at the first reset.

    Args:
        render_mode: None, "rgb_array" (the overview camera) or "human" (a window, in real time).
        render_size: height and width of rendered pictures, px.
        options: see `EnvOptions`.
    """

    def __init__(self, render_mode: str | None = None, render_size: tuple[int, int] = (480, 640), **options: Any):
        check_keys("options", options, (entry.name for entry in fields(EnvOptions)))
        self.options = EnvOptions(**options)
        if render_mode is not None:
            check_name("render_mode", render_mode, ("human", "rgb_array"))
        if not isinstance(render_size, tuple | list) or len(render_size) != 2:  # height and width
            raise EnvOptionError(f"expected render_size to be height and width, px, got {shown(render_size)}")
        for name, size, most in zip(("height", "width"), render_size, MOST_SIZE, strict=True):
            check_whole(f"render_size's {name}", size, 1, most)
        self.render_mode, self._render_size = render_mode, render_size
        if not has_display():  # what can be chosen here
            self.metadata = {**self.metadata, "render_modes": ["rgb_array"]}
        load_part(self.options.part)  # an unknown one is an error here, not at the first reset
        self._estimators()
        self._encoder = DetectionEncoder(self.options, Layout().camera)
        self._seed: int | None = None
        self._experiment = 0
        self._cell: SimCell | None = None
        self._overview: Pictures | None = None
        self._window: Window | None = None
        self._notes: Notes | None = None
        self._latest_truth = LatestTruth()
        self._methods: dict[str, UncertaintyMethod] = {}  # of the episode

    def _begin_episode(self, seed: int | None, options: dict[str, Any] | None) -> Episode:
        """Seeds the episode and begins it."""
        noise = self._choose_experiment(seed, {} if options is None else options)
        cell = self._built()
        chosen = self.options
        streams = Streams(self._seed or 0, self._experiment, cell.world.part_model.part.name)
        self._methods = methods = chosen.make_methods()
        method = AllMethods(methods) if len(methods) > 1 else next(iter(methods.values()))
        episode = begin_episode(cell, streams, self._latest_truth, self._estimators(), method, noise=noise)
        detector = episode.perception.detector
        if chosen.camera_images:
            detector = WithImages(detector, chosen.camera_images)
        return replace(episode, perception=replace(episode.perception, detector=detector, time_limit=TIME_LIMIT))

    def _estimators(self) -> Kind | Estimators:
        """What the episodes see with.

        Raises:
            EnvOptionError: trained networks were asked for, and there are none for the part.
        """
        chosen = self.options
        if chosen.estimator == LEARNED:
            part = load_part(chosen.part).part
            folder = None if chosen.networks is None else Path(chosen.networks)
            try:
                return learned_estimators(networks_of(part.name, folder), part)
            except NetworkError as error:
                raise EnvOptionError(str(error)) from error
        return "oracle" if chosen.estimator == "oracle" else "noisy"

    def _choose_experiment(self, seed: int | None, options: dict[str, Any]) -> PartNoise:
        """Chooses it; returns the episode's error model."""
        if seed is not None:
            check_whole("seed", seed, 0, 2**63 - 1)
        check_keys("reset options", options, ("experiment", "noise"))
        check_whole("experiment", options.get("experiment", 0), 0, 2**31 - 1)
        changed = options.get("noise", {})
        check_kind("noise", changed, dict)
        gymnasium.Env.reset(self, seed=seed)
        if changed and self.options.estimator != "noisy":
            raise EnvOptionError(f"expected no noise with the estimator {self.options.estimator}, got {changed}")
        noise = load_noise(load_part(self.options.part).noise).changed(changed)
        if seed is not None or self._seed is None:
            self._seed = int(self.np_random.integers(2**32)) if seed is None else seed
            self._experiment = -1
        self._experiment = options.get("experiment", self._experiment + 1)
        return noise

    def _built(self) -> SimCell:
        if self._cell is None:
            chosen = self.options
            self._cell = build_cell(chosen.part, chosen.n_parts, chosen.conditions, False)
            if self.render_mode == "human":
                self._window = Window(self._cell.world)
                self._cell.world.on_step = self._window.show
        return self._cell

    def render(self) -> Any:
        """The cell from beside it, (H, W, 3) uint8, for "rgb_array"; None otherwise.

        Raises:
            gymnasium.error.ResetNeeded: there is no world before the first reset.
        """
        if self._cell is None:
            raise gymnasium.error.ResetNeeded("nothing to render before the first reset: call reset first")
        world = self._cell.world
        if self.render_mode != "rgb_array":
            return None
        if self._overview is None:
            self._overview = Pictures(world, *self._render_size)
        return self._overview.rgb("overview")

    def frames(self, per_second: float) -> list[NDArray[np.uint8]]:
        """Pictures of what happened since the last call, for `RecordMotion`; the first time, of the present alone.

        Args:
            per_second: how many there are of a second of the cell's clock.
        """
        present = self.render()
        if self._cell is None or self._overview is None:
            raise EnvOptionError(f"expected render_mode rgb_array to record, got {self.render_mode}")
        if self._notes is None:
            self._notes = Notes(self._cell.world, per_second)
            return [present]
        return [self._overview.rgb("overview", positions) for positions in self._notes.take()]

    def close(self) -> None:
        """Releases window and OpenGL contexts; a reset creates new ones."""
        for held in (self._window, self._overview, self._cell.camera if self._cell else None):
            if held is not None:
                held.close()
        if self._cell is not None:
            self._cell.world.on_step = None
        self._cell = self._overview = self._window = self._notes = None
        self._latest_truth, self._methods = LatestTruth(), {}

    def _truth(self, observation: Observation | None = None) -> Info:
        """Where the parts are, and which of them the newest picture's detections show with which error."""
        world = self._built().world
        X_BW = world.layout.X_WB.inverse()
        told: Info = {"X_BO": np.array([(X_BW @ world.X_WO(part)).matrix for part in range(world.parts)])}
        if observation is None:
            return told
        truth, kind = self._latest_truth.of(observation.frame), world.part_model.part
        parts = [truth.part_of(detection) for detection in observation.detections]
        errors = [
            None if part is None else pose_error(X_CO_est, truth.X_CO_true[part], kind.mesh, kind.symmetries)
            for part, X_CO_est in zip(parts, observation.poses[0], strict=True)
        ]
        return told | {"part": parts, "mdd_m": errors}


def event(outcome: Outcome | None, slot: int, time: float) -> Info:
    """What `info["events"]` says of an outcome, None for a slot's time-out."""
    return {"outcome": "time-out" if outcome is None else outcome.value, "slot": slot, "time": time}


class WithImages:
    """Implements `cell.interfaces.MaskEstimator`: another one, for whose frames more images are taken."""

    def __init__(self, detector: MaskEstimator, images: frozenset[Image]) -> None:
        self._detector = detector
        self.images = detector.images | images
        self.inference_time = detector.inference_time

    def detect(self, frame: Frame) -> list[Detection]:
        """See `MaskEstimator`."""
        return list(self._detector.detect(frame))
