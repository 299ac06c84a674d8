"""The options of `graspcell video`."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

import math
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from experiments.commands.config import CellOptions
from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, check_cell
from experiments.setup.names import METHOD_NAMES, OWN

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec
    from experiments.video.make import VideoSettings
    from experiments.video.shots import Shot

VIDEO, REPLAY, RECORDING = ".mp4", ".html", ".rrd"
_RANGES = (("speed_up", 0.1, 20), ("frames_per_second", 1, 60), ("samples", 1, 64), ("height", 120, 1080))


@dataclass(frozen=True)
class Video(CellOptions):
    """Show an experiment again: as a video (.mp4), as a page with the cell in 3D (.html), or as a Rerun file (.rrd).

    With the folder of a run, shows one of its experiments, checked to come to the same again bit for bit, in the cell
    that the run's record says; without, the experiment that compare runs with the same options. A video shows overview,
    wrist camera, masks, estimated poses and decisions of several methods on the same parts. Needs the extra video for
    .mp4, view for .html, rerun for .rrd.
    """

    run: Annotated[Path | None, tyro.conf.Positional] = None
    """Folder of a run, as compare or merge writes it."""
    object: str | None = None
    """Part: antenna, handle, or a TOML file of your own; of a run, a part's name. By default antenna, or the run's."""
    methods: Annotated[
        tuple[str, ...],
        tyro.conf.arg(
            help=f"Uncertainty methods, side by side on the same parts: {', '.join(METHOD_NAMES)}; {OWN}. By default "
            "maskval, or all of the run."
        ),
    ] = ()
    policy: str | None = None
    """Policy of all methods; see graspcell run. By default each method's own, or all of the run."""
    experiment: int = 0
    """Number of the experiment."""
    attempt: int | None = None
    """Show this attempt only, by its number in attempts.parquet, from the look that led to it on."""
    u_grasp: tuple[str, ...] = ()
    """Grasping thresholds of your own, METHOD=U; they take precedence over --thresholds."""
    speed_up: float = 1.0
    """Seconds of the cell's clock per second of the video, 0.1 to 20."""
    frames_per_second: int = 12
    """Of the video, 1 to 60."""
    height: int | None = None
    """Of an overview, pixels, a multiple of 12 from 120 to 1080; by default 480, less for several experiments."""
    samples: int = 1
    """Pictures that each frame is the mean of, 1 to 64: more make edges smooth and shadows soft, and take longer."""
    out: Path = Path("out/video.mp4")
    """What is written: .mp4, .html or .rrd."""

    def shots(self) -> "list[Shot]":
        """The experiments, method by method.

        Raises:
            UsageError: an invalid argument, or a run that has no such experiment.
        """
        from experiments.reading.resimulation import Choice
        from experiments.video.shots import Shot, shots_of_run

        all_at_least(self, experiment=0)
        if self.run is None:
            return [Shot(spec) for spec in self.specs()]
        told = _changed(self, type(self)(), {field.name for field in fields(CellOptions)} | {"u_grasp"})
        if told:
            raise UsageError(f"expected no {', '.join(told)} with a run, whose record says it")
        objects, policies = (() if name is None else (name,) for name in (self.object, self.policy))
        return shots_of_run(self.run, Choice(objects, self.methods, policies, (self.experiment,)))

    def specs(self) -> "list[ExperimentSpec]":
        """The experiments that the options ask for, without a run.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.setup.methods import named_methods
        from experiments.setup.thresholds import load_thresholds
        from experiments.video.shots import MOST

        check_cell(self.parts, self.seed, self.speed)
        methods = named_methods(self.methods or ("maskval",), networks=self.actors.are_networks)
        part = self.object or "antenna"
        if len(methods) > MOST or len(set(methods)) < len(methods):
            raise UsageError(f"expected 1 to {MOST} different names for --methods, got {' '.join(methods)}")
        thresholds = load_thresholds(self.thresholds, networks=self.actors.are_networks).with_told(
            self.u_grasp, methods
        )
        self._check((part,), methods, (self.policy,), thresholds)
        return [self._spec(part, method, self.policy, thresholds, self.experiment) for method in methods]

    def settings(self) -> "VideoSettings":
        """How it is made.

        Raises:
            UsageError: an invalid argument.
        """
        from experiments.video.make import VideoSettings

        if self.attempt is not None:
            all_at_least(self, attempt=0)
        for name, least, most in _RANGES:
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and least <= value <= most):
                raise UsageError(f"expected --{name.replace('_', '-')} within {least:g} and {most:g}, got {value:g}")
        if self.height is not None and self.height % 12:
            raise UsageError(f"expected --height of a multiple of 12 pixels, got {self.height}")
        if self.out.suffix not in (VIDEO, REPLAY, RECORDING):
            raise UsageError(f"expected --out to end in {VIDEO}, {REPLAY} or {RECORDING}, got {self.out}")
        return VideoSettings(self.attempt, self.speed_up, self.frames_per_second, self.samples, self.height)


def _changed(given: Any, usual: Any, names: set[str]) -> list[str]:
    """The options that are not as they are by default, those of groups among them."""
    found = []
    for name in [field.name for field in fields(usual) if field.name in names]:
        mine, default = getattr(given, name), getattr(usual, name)
        if is_dataclass(default):
            found += _changed(mine, default, {field.name for field in fields(default)})
        elif mine != default:
            found.append(f"--{name.replace('_', '-')}")
    return found
