"""What a person sets for `graspcell uq`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from experiments.errors import UsageError

_MOST_RESAMPLES = 100_000  # of which 95 % intervals no longer change; a day for a large data set
_MOST_MM = 1e4  # the greatest diameter of a mesh


@dataclass(frozen=True)
class Uq:
    """Print MaskVal's uncertainty of every pose of a BOP submission, and how good it is if true poses are known.

    Reads only a data set in BOP's layout: it works for any detector and pose estimator, without the cell. The poses are
    CSV on stdout, the summary and warnings are on stderr. Poses that certainly are not what was meant (metres for
    millimetres, another frame, masks of another image ...) end it with exit code 2; docs/maskval.md lists the rules.
    """

    dataset: Path
    """Folder in BOP's layout: models/ and the split's scenes."""
    results: Path
    """The poses: a results file of BOP, .csv."""
    masks: str
    """Detections with masks, .json or .json.gz (BOP's results of 2022, or a whole COCO file; run lengths or
    polygons); or the data set's own masks: mask_visib, or mask."""
    split: str = "test"
    """Folder of the scenes in the data set."""
    association: Literal["greedy", "optimal", "known"] = "greedy"
    """How poses find their masks: greedy, optimal (Hungarian), or known: in the order of the files."""
    alpha: float = 0.8
    """Visibility below which the certainty is lowered by the visibility, 0 to 1."""
    pixel_center: float = 0.5
    """Where pixel i of the masks is sampled: i + 0.5 for BOP's and OpenGL's, i + 0 for OpenCV's."""
    canvas: Literal["full", "3x3"] = "full"
    """Where the whole silhouette is counted for the visibility: all of it, or BOP's 3 x 3 images."""
    error: Literal["mssd", "mdd", "add", "add-s"] = "mssd"
    """The error of a pose; mssd is the mdd where an object has no symmetries."""
    error_threshold_mm: float = 15.0
    """Greatest error of a good pose, mm."""
    demanded_ap: float = 0.99
    """AP that the thresholds are to reach, above 0 and below 1."""
    seed: int = 0
    """Root of the random numbers of the intervals."""
    resamples: int = 200
    """Bootstrap samples of the 95 % intervals. Fewer than 40 give no interval."""
    out: Path | None = None
    """File for the table of poses instead of stdout, .csv (or .json with --json)."""
    json: bool = False
    """Poses, warnings and summary as one JSON object instead of CSV."""
    pictures: Path | None = None
    """Folder for pictures of the worst, the median and the best pose: detection, projection, and their overlap."""
    strict: bool = False
    """Exit with code 3 if there is a warning."""
    check: bool = True
    """Look whether poses and masks can be meant as they are."""

    def check_values(self) -> None:
        """Rejects values out of range.

        Raises:
            UsageError: says which, and what is valid.
        """
        for name, value, legal, words in (
            ("--alpha", self.alpha, 0 <= self.alpha <= 1, "in 0..1"),
            ("--pixel-center", self.pixel_center, 0 <= self.pixel_center < 1, "of at least 0 and below 1"),
            ("--demanded-ap", self.demanded_ap, 0 < self.demanded_ap < 1, "above 0 and below 1"),
            ("--resamples", self.resamples, 1 <= self.resamples <= _MOST_RESAMPLES, f"of 1 to {_MOST_RESAMPLES}"),
            ("--seed", self.seed, 0 <= self.seed < 2**63, "of at least 0 and below 2^63"),
            (
                "--error-threshold-mm",
                self.error_threshold_mm,
                0 < self.error_threshold_mm <= _MOST_MM,
                f"above 0 and at most {_MOST_MM:g}",
            ),
        ):
            if not legal:
                raise UsageError(f"expected {name} {words}, got {value:g}")
        ending = ".json" if self.json else ".csv"
        if self.out is not None and self.out.suffix != ending:
            raise UsageError(f"expected --out as a {ending} file, got {str(self.out)!r}")
        if not self.masks.endswith((".json", ".json.gz")) and self.masks not in ("mask_visib", "mask"):
            raise UsageError(f"expected --masks as a .json or .json.gz file, mask_visib or mask, got {self.masks}")
