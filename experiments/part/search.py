"""The grasps and the slot of a part, chosen anew as trials rule grasps out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cell.layout import Layout
from experiments.part.files import Draft
from maskval import Mesh
from sim.part_making.grasp_search import Candidate, find_candidates
from sim.part_making.samples import sample_surface
from sim.part_making.selection import Chosen, choose
from sim.part_making.slot import Slot, fit_slot

_ALIKE_PLACE = 0.006  # m between tools that hold the part alike
_ALIKE_AXIS = np.cos(np.radians(10.0))


class GraspSearch:
    """Candidates of one part; those that failed are left out of the next choice."""

    def __init__(self, draft: Draft, layout: Layout, seed: int) -> None:
        self._draft, self._layout = draft, layout
        self._mesh = Mesh(draft.mesh.vertices, draft.mesh.faces)
        center = np.asarray(draft.mesh.center_mass)
        surface = sample_surface(draft.mesh)
        self._candidates = find_candidates(surface, draft.poses, center, layout.gripper, seed)

    def chosen(self) -> Draft:
        """The part with the best grasps that are left, and a slot for them."""
        chosen = choose(self._candidates, self._draft.poses, self._mesh, self._layout)
        slot = fit_slot(chosen, self._draft.poses, self._mesh, self._layout) if chosen else Slot((0.0, 0.0), 0)
        return replace(self._draft, chosen=chosen, slot=slot)

    def without(self, failed: Sequence[tuple[Chosen, int]]) -> Draft | None:
        """The part without grasps like those that failed in a stable pose; None if a pose would then have none."""
        left = [one for one in self._candidates if not any(_alike(one, other, pose) for other, pose in failed)]
        before = {index for one in self._candidates for index in one.usable}
        if {index for one in left for index in one.usable} != before:
            return None
        self._candidates = left
        return self.chosen()


def _alike(one: Candidate, failed: Chosen, pose: int) -> bool:
    if pose not in one.usable:
        return False
    mine, other = one.grip.X_OT, failed.grasp.X_OT
    near = float(np.linalg.norm(mine.translation - other.translation)) < _ALIKE_PLACE
    approach = float(mine.rotation[:, 2] @ other.rotation[:, 2])
    closing = abs(float(mine.rotation[:, 1] @ other.rotation[:, 1]))
    return near and min(approach, closing) > _ALIKE_AXIS
