"""The options of `graspcell bench`."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from experiments.commands.config import Compare
from experiments.setup.checks import all_at_least

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec


@dataclass(frozen=True)
class Bench:
    """Measure how fast experiments run here, what takes the time, and what a second process brings.

    Prints ratios, since the clock of a shared machine says little.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts to be sequenced: names, or TOML files of your own."""
    method: str = "maskval"
    """Uncertainty method."""
    experiments: int = 3
    """Experiments per object."""
    parts: int = 8
    """Parts on the belt per experiment; 1 to 8."""
    jobs: int = 2
    """Processes that are compared with one."""
    seed: int = 0
    """Root of all random numbers."""

    def specs(self) -> "dict[str, list[ExperimentSpec]]":
        """The experiments of each object.

        Raises:
            UsageError: an invalid argument.
        """
        all_at_least(self, experiments=1, jobs=1)
        compare = Compare(
            parts=self.parts,
            seed=self.seed,
            objects=self.objects,
            methods=(self.method,),
            experiments=self.experiments,
        )
        specs = compare.specs()
        return {part: [spec for spec in specs if spec.part == part] for part in self.objects}
