"""What a person sets for `graspcell part`."""

# ruff: noqa: PLC0415  # the engine is loaded when a job begins: --help does not wait for it

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from experiments.errors import UsageError
from experiments.setup.checks import all_at_least, worker_count

DENSITY = 1200.0  # kg/m³, ABS with some filling: what housings and clips are made of
FRICTION = 0.6


@dataclass(frozen=True)
class MakePart:
    """Make a part of your own from a mesh: what collides, stable poses, symmetries, grasps tried in physics, slot.

    Reads .stl, .obj, .ply or .glb and writes a folder with the part's TOML file, its meshes, its error model and
    preview.png to --out; needs the extra graspcell[parts]. Or checks part files with --check.
    """

    mesh: Annotated[Path | None, tyro.conf.Positional] = None
    """The mesh of one closed body."""
    check: tuple[Path, ...] = ()
    """Part files to check instead: what is wrong or probably not meant, a line each."""
    name: str | None = None
    """Name of the part; by default the mesh file's."""
    unit: str | None = None
    """The mesh's unit: mm, cm, m or inch; found by its size if that leaves no doubt."""
    mass: float | None = None
    """Mass, kg; by default the volume times --density."""
    density: float = DENSITY
    """Density, kg/m³."""
    friction: float = FRICTION
    """Sliding friction against everything but the gripper's pads; the default is that of the shipped parts."""
    trials: int = 4
    """Attempts in physics per grasp and stable pose, with exact poses; 0 tries nothing."""
    seed: int = 0
    """Root of all random numbers."""
    jobs: int = 0
    """Processes for the trials; 0 takes one per core. The results do not depend on it."""
    preview: bool = True
    """Draw preview.png; needs the extra graspcell[figures]."""
    out: Path | None = None
    """Folder of the part; out/parts/NAME by default."""

    @property
    def workers(self) -> int:
        """Processes to use."""
        return worker_count(self.jobs)

    def refuse_invalid(self) -> None:
        """Rejects invalid arguments.

        Raises:
            UsageError: says which and why.
        """
        from sim.part_making.surface_file import UNITS
        from sim.parts.part_file import FRICTION as FRICTIONS
        from sim.parts.part_file import MASS_KG

        if (self.mesh is None) == (not self.check):
            raise UsageError("expected a mesh file, or --check with part files, and not both")
        all_at_least(self, trials=0, seed=0, jobs=0)
        if self.unit is not None and self.unit not in UNITS:
            raise UsageError(f"unknown unit {self.unit!r}: expected one of {', '.join(UNITS)}")
        for name, value, (low, high) in (
            ("--mass", self.mass, MASS_KG),
            ("--density", self.density, (10.0, 25_000.0)),
            ("--friction", self.friction, FRICTIONS),
        ):
            if value is not None and not low <= value <= high:
                raise UsageError(f"expected {name} in {low:g}..{high:g}, got {value:g}")
