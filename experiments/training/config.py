"""What a person sets for `graspcell train`."""

# ruff: noqa: PLC0415  # the parts are loaded when the job begins: --help does not wait for them

from dataclasses import dataclass
from pathlib import Path

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, worker_count, writable_folder


@dataclass(frozen=True)
class Train:
    """Train a detector and two pose networks for a part on rendered pictures, for --estimator networks.

    Renders what is missing of the pictures (s1, s2 and held-out in --pictures), trains, and writes detector.onnx,
    s1.onnx, s2.onnx and manifest.json to --out. The same command again goes on where it was stopped, also with more
    steps.
    """

    object: str = "antenna"
    """The part: antenna, handle, or a TOML file of your own."""
    images: int = 3000
    """Pictures to train on, of each style."""
    held_out: int = 300
    """Pictures of style s1 that settings and figures are found on."""
    pose_steps: int = 20_000
    """Steps of each pose network, 32 crops each."""
    detector_steps: int = 8_000
    """Steps of the detector, 8 pictures each."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes to render and train in; 0 takes one per core. One network is trained in one process."""
    pictures: Path | None = None
    """Folder of the pictures; OUT/pictures by default. Networks of other settings can share it."""
    out: Path = Path("out/networks")
    """Folder for the networks; made if missing."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    @property
    def pictures_folder(self) -> Path:
        """Where the pictures are."""
        return self.out / "pictures" if self.pictures is None else self.pictures

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from sim.errors import SimError
        from sim.model.parts import load_part

        all_at_least(self, images=1, held_out=1, pose_steps=4, detector_steps=4, seed=0, jobs=0)
        try:
            load_part(self.object)
        except SimError as error:
            raise UsageError(str(error)) from error
        writable_folder(self.out)
        for package in ("torch", "onnx", "onnxruntime"):
            _check_installed(package)


def _check_installed(package: str) -> None:
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise UsageError(f"train needs {package}, which is not installed: pip install 'graspcell[train]'")
