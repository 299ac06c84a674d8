"""What a person sets for `graspcell dataset`."""

# ruff: noqa: PLC0415  # the parts are loaded when the job begins: --help does not wait for them

import shlex
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

from experiments.dataset.rules import ANNOTATED_VISIBILITY, Rules
from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, worker_count, writable_folder

if TYPE_CHECKING:
    from experiments.dataset.sources import PictureSet

CountingRules = tyro.conf.OmitArgPrefixes[Rules]  # --averaging, not --rules.averaging

_SAME = ("resamples", "jobs", "alternatives", "figures", "out")  # options that change no figure
_BATCH = 100  # images that a worker makes at a time


@dataclass(frozen=True)
class Dataset:
    """Evaluate the simulated networks and the uncertainty methods as the paper did its own: on a set of test images.

    Makes images of several parts among clutter, by geometry alone, and prints the detector's figures, Spearman and
    AUC AR of each method and the thresholds u_t,g beside the paper's. Writes dataset.json, thresholds.toml (for
    compare) and manifest.json to --out.
    """

    objects: tuple[str, ...] = ("antenna", "handle")
    """Parts: names, or TOML files of your own."""
    methods: tuple[str, ...] = ("maskval", "ensemble-add", "oracle-mask", "oracle-mdd", "random")
    """Uncertainty methods: those of compare but for temporal, which needs several views; or your own as
    package.module:Class; or all for all of these."""
    estimator: Literal["noisy", "networks"] = "noisy"
    """noisy: simulated networks on generated images; networks: trained ones on the pictures of --pictures."""
    networks: Path | None = None
    """Folder of trained networks, as graspcell train writes it; those that come along for the part by default."""
    pictures: Path | None = None
    """Folder of rendered pictures, as graspcell render-dataset writes it; of several objects, one in a folder of each
    one's name."""
    split: str = "test"
    """The split of these pictures."""
    images: int = 10_000
    """Test images per part."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes to make images in; 0 takes one per core. The results do not depend on it."""
    resamples: int = 200
    """Bootstrap samples of the 95 % intervals; they draw whole images. Fewer than 40 give no interval."""
    rules: CountingRules = field(default_factory=Rules)
    annotated_visibility: float = ANNOTATED_VISIBILITY
    """Least visible share of a part that the detector is asked for, 0 to 1; 0.1 as in BOP's 2D tasks."""
    alternatives: bool = False
    """Also print what each other counting rule would give."""
    figures: bool = False
    """Also draw curves.png and errors.png; needs the extra graspcell[figures]."""
    out: Path = Path("out/dataset")
    """Folder for the results; made if missing."""

    @property
    def command(self) -> str:
        """What to type for the same figures: every option that differs from its default and changes them."""
        words = ["graspcell dataset"]
        default = Dataset()
        for owner, other in ((self, default), (self.rules, default.rules)):
            for option in fields(owner):
                value = getattr(owner, option.name)
                if value == getattr(other, option.name) or option.name in ("rules", *_SAME):
                    continue
                values = map(str, value) if isinstance(value, tuple) else [str(value)]
                words += [f"--{option.name.replace('_', '-')}", *map(shlex.quote, values)]
        return " ".join(words)

    @property
    def named_methods(self) -> tuple[str, ...]:
        """The methods, with "all" for every one that can judge a single image."""
        from experiments.setup.methods import named_methods

        networks = self.estimator == "networks"
        without = ("none", "temporal", "depth") if networks else ("none", "temporal")
        every = tuple(name for name in named_methods(["all"], networks=networks) if name not in without)
        return every if list(self.methods) == ["all"] else self.methods

    def picture_set(self, part: str) -> "PictureSet | None":
        """The pictures of a part, and the networks that look at them; None for generated images."""
        from experiments.dataset.sources import PictureSet

        if self.pictures is None:
            return None
        folder = self.pictures if len(self.objects) == 1 else self.pictures / part
        return PictureSet(folder, self.split, self.networks)

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    @property
    def batches(self) -> list[range]:
        """The numbers of the images of each batch."""
        return [range(first, min(first + _BATCH, self.images)) for first in range(0, self.images, _BATCH)]

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from experiments.dataset.batch import make_uncertainties
        from sim.errors import SimError
        from sim.model.parts import load_part
        from sim.networks.ground_truth import LatestTruth
        from sim.networks.noise_model import load_noise
        from sim.networks.random_streams import Streams

        all_at_least(self, images=1, seed=0, jobs=0, resamples=1)
        if not 0 <= self.annotated_visibility <= 1:
            raise UsageError(f"expected --annotated-visibility in 0..1, got {self.annotated_visibility:g}")
        methods = self.named_methods
        for option, chosen in (("--objects", self.objects), ("--methods", methods)):
            if not chosen:
                raise UsageError(f"expected at least one name for {option}, got none")
        if len(set(methods)) < len(methods):
            raise UsageError(f"expected different names for --methods, got {' '.join(methods)}")
        try:
            names = [load_part(part).part.name for part in self.objects]
            for part in self.objects:
                model = load_part(part)
                load_noise(model.noise)
                make_uncertainties(methods, model.part, Streams(0, 0, model.part.name), LatestTruth())
        except SimError as error:
            raise UsageError(str(error)) from error
        if len(set(names)) < len(names):
            raise UsageError(f"expected different names for --objects, got {' '.join(self.objects)}")
        self._check_pictures(names)
        if self.figures:
            from experiments.dataset.figures import check_matplotlib

            check_matplotlib()
        writable_folder(self.out)

    def _check_pictures(self, parts: list[str]) -> None:
        from experiments.setup.estimators import check_networks

        if (self.estimator == "networks") != (self.pictures is not None):
            raise UsageError("expected --estimator networks and --pictures FOLDER together, got only one of them")
        if self.pictures is None:
            if self.networks is not None:
                raise UsageError(f"--networks {self.networks} is only for --estimator networks")
            return
        if len(parts) > 1 and self.networks is not None:
            raise UsageError("--networks: expected one object, whose networks they are, got several")
        for part, source in zip(parts, self.objects, strict=True):
            check_networks(self.networks, source)
            pictures = self.picture_set(part)
            assert pictures is not None  # there is a folder
            pictures.check(self.images)
