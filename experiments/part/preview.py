"""preview.png: the part in each stable pose with its grasp, and in its slot."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import NDArray

from cell.layout import Gripper, Layout
from experiments.part.files import Draft
from experiments.results.files import replacing
from sim.part_making.selection import Chosen
from sim.part_making.slot import release_opening
from sim.part_making.solids import simplified
from sim.parts.part_checks import laid_points
from sim.parts.stable_poses import RestingPose
from sim.polygons import convex_outline

_COLUMNS = 4
_FACES = 1500
_FINGER = 0.05  # m of the fingers that are drawn
_EDGES = ((0, 1), (0, 2), (1, 3), (2, 3), (4, 5), (4, 6), (5, 7), (6, 7), (0, 4), (1, 5), (2, 6), (3, 7))

Array = NDArray[np.float64]


def draw_preview(draft: Draft, path: Path) -> None:
    """Draws one view per stable pose, likeliest first, then the slot from above.

    Raises:
        UsageError: the file cannot be written.
    """
    diameter = float(np.linalg.norm(draft.mesh.extents))
    shown, _ = simplified(draft.mesh, _FACES, [share * diameter for share in (2e-3, 5e-3, 1e-2)])
    rows = -(-(len(draft.poses) + 1) // _COLUMNS)
    figure = Figure(figsize=(3.4 * _COLUMNS, 3.3 * rows), dpi=90)
    for index, pose in enumerate(draft.poses):
        owner = next((one for one in draft.chosen if index in one.poses), None)
        axes: Any = figure.add_subplot(rows, _COLUMNS, index + 1, projection="3d")
        _draw_pose(axes, shown.vertices[shown.faces], pose, owner)
        grasp = "no grasp" if owner is None else owner.grasp.name
        axes.set_title(f"pose {index}, {pose.probability:.0%}: {grasp}", fontsize=9)
    _draw_slot(figure.add_subplot(rows, _COLUMNS, len(draft.poses) + 1), draft, shown.vertices[shown.faces])
    figure.suptitle(f"{draft.name}: stable poses, jaws before they close, slot")
    figure.tight_layout()
    with replacing(path) as file:
        figure.savefig(file, format="png")


def _draw_pose(axes: Any, triangles: Array, pose: RestingPose, owner: Chosen | None) -> None:
    placed = triangles @ pose.rotation.T + [0.0, 0.0, pose.height]
    normals = np.cross(placed[:, 1] - placed[:, 0], placed[:, 2] - placed[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-15)
    light = 0.55 + 0.45 * np.clip(normals @ [0.3, -0.5, 0.81], 0.0, 1.0)
    axes.add_collection3d(Poly3DCollection(placed, facecolors=np.outer(light, [0.55, 0.65, 0.8]).clip(0, 1)))
    points = [placed.reshape(-1, 3)]
    for box in _fingers(owner, owner.grasp.half_opening) if owner else []:
        corners = box @ pose.rotation.T + [0.0, 0.0, pose.height]
        axes.add_collection3d(
            Line3DCollection([corners[list(edge)] for edge in _EDGES], colors="tab:red", linewidths=1)
        )
        points.append(corners)
    low, high = np.vstack(points).min(axis=0), np.vstack(points).max(axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), zlim=(0, 2 * half))
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=25, azim=-55)
    axes.set_axis_off()
    floor = np.array([[low[0], low[1], 0], [high[0], low[1], 0], [high[0], high[1], 0], [low[0], high[1], 0]])
    axes.add_collection3d(Poly3DCollection([floor], facecolors=[(0.3, 0.3, 0.3, 0.15)]))


def _fingers(owner: Chosen, half_opening: float) -> list[Array]:
    """The corners of both fingers in O, their jaws open by `half_opening` (m)."""
    gripper = Gripper()
    x, tip, boxes = gripper.finger_width / 2, gripper.tip_below_tcp, []
    for side in (-1, 1):
        inner, outer = side * half_opening, side * (half_opening + gripper.finger_thickness)
        corners = [(u, v, w) for u in (-x, x) for v in (inner, outer) for w in (tip - _FINGER, tip)]
        boxes.append(owner.grasp.X_OT.apply(np.array(corners)))
    return boxes


def _draw_slot(axes: Any, draft: Draft, triangles: Array) -> None:
    """The slot from above with the part in its likeliest pose that has a grasp, and the jaws as they let go."""
    half_x, half_y = (500 * size for size in draft.slot.size)
    axes.plot([-half_x, half_x, half_x, -half_x, -half_x], [-half_y, -half_y, half_y, half_y, -half_y], "k-")
    owner = next(one for one in draft.chosen if one.poses)
    R_WO, opening = draft.poses[owner.poses[0]].rotation, release_opening(owner, Layout())
    boxes = [1000 * laid_points(R_WO, box)[:, :2] for box in _fingers(owner, opening)]
    part = 1000 * laid_points(R_WO, triangles.reshape(-1, 3))[:, :2]
    everything = np.vstack([part, *boxes])
    middle = (everything.min(axis=0) + everything.max(axis=0)) / 2
    axes.add_collection(PolyCollection((part - middle).reshape(-1, 3, 2), facecolors=[(0.55, 0.65, 0.8)]))
    for box in boxes:
        outline = convex_outline(box) - middle
        axes.fill(*outline.T, fill=False, edgecolor="tab:red")
    axes.set_aspect("equal")
    axes.set_title(f"slot {2 * half_x:g} × {2 * half_y:g} mm, {draft.slot.reached} reached", fontsize=9)
