"""What a person sets for `graspcell calibrate`."""

# ruff: noqa: PLC0415  # the parts are loaded when the job begins: --help does not wait for them

from dataclasses import dataclass
from pathlib import Path

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, worker_count


@dataclass(frozen=True)
class Calibrate:
    """Fit a part's error model to the paper's dataset tables, and say what the tables do not determine.

    Makes test images as `dataset` does, fits the detector's parameters to the mask figures and then the pose networks'
    to Spearman, AUC AR and u_t,g, and draws parameter sets that fit as well. Writes noise.toml, ensemble.json,
    calibration.json and manifest.json to --out.
    """

    part: str = "antenna"
    """Part: a name, or a TOML file of your own."""
    targets: str | None = None
    """Targets and priors: a preset or a TOML file of the same form; by default the preset of the part's name."""
    start: str | None = None
    """A noise file to begin with, an earlier result; the middle of the priors by default."""
    images: int = 6_000
    """Images to fit on."""
    seed: int = 1
    """Root of all random numbers; another one than `dataset`'s, so that its images are new to the fit."""
    rounds: int = 6
    """Steps of each fit at most; 1 stays where it begins."""
    draws: int = 20
    """Parameter sets to draw around the fit and to try."""
    jobs: int = 0
    """Processes; 0 takes one per core. The results do not depend on it."""
    out: Path = Path("out/calibrate")
    """Folder for the results; made if missing."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from experiments.calibration.targets import load_calibration
        from sim.errors import SimError
        from sim.model.parts import load_part
        from sim.networks.noise_model import load_noise

        all_at_least(self, images=1, seed=0, rounds=1, draws=0, jobs=0)
        try:
            model = load_part(self.part)
            noise = load_noise(self.start or model.noise)
        except SimError as error:
            raise UsageError(str(error)) from error
        load_calibration(self.targets or model.part.name, noise)
