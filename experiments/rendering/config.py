"""What a person sets for `graspcell render-dataset`."""

# ruff: noqa: PLC0415  # the parts are loaded when the job begins: --help does not wait for them

import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, worker_count, writable_folder

IMAGES_PER_SCENE = 1000  # as in BOP's rendered training images; one scene's annotations are held in memory at a time
_MOST_BODIES = 30  # of a kind in a picture
_BATCH = 10  # images that a worker makes at a time; divides IMAGES_PER_SCENE

if TYPE_CHECKING:
    from sim.images.pictures import Shot

Style = Literal["s1", "s2"]


@dataclass(frozen=True)
class RenderDataset:
    """Render a set of pictures as a BOP dataset, to train or test real networks: RGB, depth, masks and true poses.

    Writes models/, camera.json, the split with its scenes, the split's targets and manifest.json to --out.
    """

    style: Style = "s1"
    """s1: parts and clutter dropped onto the floor of a room; s2: parts in the air, pasted over a background."""
    object: str = "antenna"
    """The part: antenna, handle, or a TOML file of your own."""
    images: int = 100
    """Pictures to take."""
    split: str = "test"
    """Name of the split's folder; another split has other pictures."""
    textured: float = 0.5
    """Share of parts with a random texture instead of their own colour, 0 to 1."""
    samples: int = 3
    """Samples per pixel and side: 3 renders smooth borders, 1 is fast."""
    views_per_heap: int = 1
    """Pictures of each heap of s1, all in one scene; they are not independent, but the heap's fall costs the most."""
    parts: tuple[int, int] | None = None
    """Least and greatest number of parts; 2 7 for s1 and 2 6 for s2 if not set."""
    clutter: tuple[int, int] | None = None
    """Least and greatest number of other bodies; 4 12 for s1 and 0 4 for s2 if not set."""
    spread_m: tuple[float, float] = (0.05, 0.30)
    """Least and greatest radius of the circle that the bodies of a heap of s1 fall into: in wide ones more parts lie on
    the floor itself."""
    distance_m: tuple[float, float] = (0.4, 1.2)
    """Least and greatest distance of a part's middle from the camera, along its axis."""
    elevation_deg: tuple[float, float] | None = None
    """Least and greatest angle of the camera's axis over the floor; 25 90 for s1 if not set. s2 has no floor: its parts
    are turned as they would be on one, and in any way if not set."""
    rgb: Literal["png", "jpg"] = "png"
    """Format of the RGB pictures: without loss, or as BOP's training sets have them (quality 95)."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes to render in; 0 takes one per core. The pictures do not depend on it."""
    out: Path = Path("out/rendered")
    """Folder for the dataset; made if missing, refused if it holds anything."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    @property
    def shot(self) -> "Shot":
        """How the pictures are taken."""
        from sim.images.pictures import Shot

        return Shot(
            textured=self.textured,
            views_per_heap=self.views_per_heap,
            distance=self.distance_m,
            elevation_deg=self.elevation_deg,
            parts=self.parts,
            clutter=self.clutter,
            spread=self.spread_m,
        )

    @property
    def batches(self) -> list[range]:
        """The numbers of the pictures of each batch; none reaches into another scene, none parts those of a heap."""
        size = math.lcm(_BATCH, self.views_per_heap)
        return [range(first, min(first + size, self.images)) for first in range(0, self.images, size)]

    def check(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from sim.errors import SimError
        from sim.model.parts import load_part

        all_at_least(self, images=1, seed=0, jobs=0, samples=1, views_per_heap=1)
        if self.samples % 2 == 0:
            raise UsageError(f"expected --samples of 1, 3, 5, ..., got {self.samples}")
        if IMAGES_PER_SCENE % self.views_per_heap:
            raise UsageError(f"expected --views-per-heap that divides {IMAGES_PER_SCENE}, got {self.views_per_heap}")
        if not 0 <= self.textured <= 1:
            raise UsageError(f"expected --textured in 0..1, got {self.textured:g}")
        _check_span("--spread-m", self.spread_m, (0.01, 1.0))
        for option, span, least in (("--parts", self.parts, 1), ("--clutter", self.clutter, 0)):
            if span is not None:
                _check_span(option, span, (least, _MOST_BODIES))
        _check_span("--distance-m", self.distance_m, (0.25, 3.0))
        if self.elevation_deg is not None:
            _check_span("--elevation-deg", self.elevation_deg, (10.0, 90.0))
        if not re.fullmatch(r"[A-Za-z0-9_-]+", self.split) or self.split == "models":
            raise UsageError(f"expected --split of letters, digits, _ and -, and not models, got {self.split!r}")
        try:
            load_part(self.object)
        except SimError as error:
            raise UsageError(str(error)) from error
        writable_folder(self.out)
        if any(self.out.iterdir()):
            raise UsageError(f"{self.out} is not empty: expected a new or empty folder for --out")


def _check_span(option: str, span: tuple[float, float], limits: tuple[float, float]) -> None:
    low, high = span
    if not limits[0] <= low <= high <= limits[1]:
        least, most = limits
        raise UsageError(f"expected {option} LOW HIGH in {least:g}..{most:g}, LOW first, got {low:g} {high:g}")
