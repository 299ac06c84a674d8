"""Convex pieces that fill a part, by CoACD: what of the part collides."""

from dataclasses import dataclass

import numpy as np
import trimesh

from cell.rounding import rounded
from sim.part_making.solids import extra, joined, simplified, solid_of

AGREEMENT = 0.20  # share of the part's volume by which the pieces' may differ
MOST_PIECES = 96
_CONCAVITIES = (0.1, 0.05)  # CoACD's thresholds that are tried one after the other
# Fewer trials and samples than CoACD's own values: three times as fast, some pieces more.
_SEARCH = {"resolution": 1000, "mcts_nodes": 10, "mcts_iterations": 30, "mcts_max_depth": 2, "seed": 0}
_FACES = 3_000  # of the surface that is cut: the cost grows with them
_SIMPLER = (1e-3, 2e-3, 4e-3)  # of the diameter
_CRUMB = 1e-4  # of the volume: smaller pieces carry nothing


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Convex pieces.

    Attributes:
        hulls: the pieces.
        share: the volume that they fill together, in units of the part's.
    """

    hulls: tuple[trimesh.Trimesh, ...]
    share: float

    @property
    def agree(self) -> bool:
        """Whether the volume is the part's, to `AGREEMENT`."""
        return abs(self.share - 1.0) <= AGREEMENT


def cut_into_pieces(mesh: trimesh.Trimesh) -> Pieces:
    """Convex pieces of a closed surface, coarse ones if their volume agrees with the part's.

    Raises:
        PartExtraError: CoACD is not installed.
    """
    diameter = float(np.linalg.norm(mesh.extents))
    simple, _ = simplified(mesh, _FACES, [share * diameter for share in _SIMPLER])
    hull = mesh.convex_hull
    best = Pieces((_clean(hull),), hull.volume / mesh.volume)
    for concavity in _CONCAVITIES:
        if best.agree:
            break
        found = _cut(simple, mesh.volume, concavity)
        if len(found.hulls) <= MOST_PIECES and abs(found.share - 1.0) < abs(best.share - 1.0):
            best = found
    return best


def _cut(mesh: trimesh.Trimesh, volume: float, concavity: float) -> Pieces:
    coacd = extra("coacd")
    coacd.set_log_level("off")
    cut = coacd.run_coacd(coacd.Mesh(mesh.vertices, mesh.faces), threshold=concavity, preprocess_mode="off", **_SEARCH)
    hulls = [_clean(trimesh.Trimesh(vertices, faces).convex_hull) for vertices, faces in cut]
    hulls = [hull for hull in hulls if hull.volume > _CRUMB * volume]
    solids = [solid for hull in hulls if (solid := solid_of(hull)) is not None]
    return Pieces(tuple(hulls), float(joined(solids).volume()) / volume)


def _clean(hull: trimesh.Trimesh) -> trimesh.Trimesh:
    """The hull of its corners, rounded to a micrometre."""
    made: trimesh.Trimesh = trimesh.convex.convex_hull(rounded(hull.vertices, 6))
    return made
