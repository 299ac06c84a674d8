"""The options of `graspcell video`."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from experiments.commands.config import CellOptions
from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, check_cell
from experiments.setup.names import METHOD_NAMES, OWN

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec
    from experiments.video.make import VideoSettings

_MOST_METHODS = 9


@dataclass(frozen=True)
class Video(CellOptions):
    """Make a video of an experiment: overview, wrist camera, masks, estimated poses and decisions.

    Runs the same experiment as compare does with the same seed and number, again and bit for bit. Needs the extra
    graspcell[video].
    """

    object: str = "antenna"
    """Part to be sequenced: antenna, handle, or a TOML file of your own."""
    methods: Annotated[
        tuple[str, ...],
        tyro.conf.arg(help=f"Uncertainty methods, side by side on the same parts: {', '.join(METHOD_NAMES)}; {OWN}."),
    ] = ("maskval",)
    policy: str | None = None
    """Policy of all methods; see graspcell run."""
    experiment: int = 0
    """Number of the experiment."""
    attempt: int | None = None
    """Show this attempt only, by its number in attempts.parquet, from the look that led to it on."""
    u_grasp: tuple[str, ...] = ()
    """Grasping thresholds of your own, METHOD=U; they take precedence over --thresholds."""
    speed_up: float = 1.0
    """Seconds of the cell's clock per second of the video, 0.1 to 20."""
    frames_per_second: int = 20
    """Of the video, 1 to 60."""
    samples: int = 2
    """Pictures that each frame is the mean of, 1 to 64; more make shadows softer and take longer."""
    out: Path = Path("out/video.mp4")
    """The video, .mp4."""

    def specs(self) -> "list[ExperimentSpec]":
        """The experiments, method by method.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.methods import named_methods
        from experiments.setup.thresholds import load_thresholds

        check_cell(self.parts, self.seed, self.speed)
        all_at_least(self, experiment=0)
        methods = named_methods(self.methods)
        if not 1 <= len(methods) <= _MOST_METHODS:
            raise UsageError(f"expected 1 to {_MOST_METHODS} names for --methods, got {' '.join(methods)}")
        thresholds = load_thresholds(self.thresholds).with_told(self.u_grasp, methods)
        self._check((self.object,), methods, (self.policy,), thresholds)
        return [self._spec(self.object, method, self.policy, thresholds, self.experiment) for method in methods]

    def settings(self) -> "VideoSettings":
        """How the video is made.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.video.make import VideoSettings

        if self.attempt is not None:
            all_at_least(self, attempt=0)
        for name, least, most in (("speed_up", 0.1, 20), ("frames_per_second", 1, 60), ("samples", 1, 64)):
            value = getattr(self, name)
            if not (math.isfinite(value) and least <= value <= most):
                raise UsageError(f"expected --{name.replace('_', '-')} within {least:g} and {most:g}, got {value:g}")
        if self.out.suffix != ".mp4":
            raise UsageError(f"expected --out to end in .mp4, got {self.out}")
        return VideoSettings(self.attempt, self.speed_up, self.frames_per_second, self.samples)
