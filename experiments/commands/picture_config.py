"""The options of `graspcell picture`."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it, nor need OpenGL

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, check_cell, check_part_and_method, one_of

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec


@dataclass(frozen=True)
class Picture:
    """Take a picture of the cell at a moment of an experiment with exact estimates."""

    object: str = "antenna"
    """Part to be sequenced: antenna, handle, or a TOML file of your own."""
    after: int = 3
    """How many time slots are over."""
    state: str = "insert"
    """The state that the robot then enters: search, approach, close, transfer, insert, ..."""
    camera: str = "overview"
    """overview: beside the cell; wrist: what the robot sees."""
    size: tuple[int, int] = (960, 720)
    """Width and height, pixels, up to 1920 × 1080."""
    seed: int = 0
    """Root of all random numbers."""
    maker_meshes: bool = False
    """Draw the arm with its maker's meshes; needs the extra graspcell[meshes]."""
    out: Path = Path("out/cell.png")
    """The picture, .png or .jpg."""

    def spec(self) -> "ExperimentSpec":
        """The experiment that the picture is taken from.

        Raises:
            UsageError: an invalid argument.
        """
        from cell.records import State
        from experiments.setup.experiment import ExperimentSpec
        from experiments.setup.thresholds import load_thresholds

        check_cell(1, self.seed, "ur-default")
        all_at_least(self, after=0)
        one_of("--state", self.state, tuple(state.value for state in State))
        one_of("--camera", self.camera, ("overview", "wrist"))
        width, height = self.size
        if not (1 <= width <= 1920 and 1 <= height <= 1080):
            raise UsageError(f"expected --size within 1 1 and 1920 1080, got {width} {height}")
        if self.out.suffix not in (".png", ".jpg"):
            raise UsageError(f"expected --out to end in .png or .jpg, got {self.out}")
        check_part_and_method(self.object, "none", load_thresholds("paper"))
        return ExperimentSpec(
            part=self.object,
            method="none",
            estimator="oracle",
            thresholds=load_thresholds("paper"),
            speed="ur-default",
            parts=8,
            seed=self.seed,
            experiment=0,
            maker_meshes=self.maker_meshes,
        )
