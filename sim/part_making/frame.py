"""The part's frame O: the mesh's own, or one whose x axis runs along the part's longest side."""

import numpy as np
import trimesh

from maskval import Pose

_LONGER = 1.1  # times x: another side so much longer becomes x, since the slots are longer along x
_AXES = ("x", "y", "z")


def choose_frame(mesh: trimesh.Trimesh) -> tuple[trimesh.Trimesh, Pose, str | None]:
    """The mesh in O, X_MO of O in the mesh's frame M, and what was changed, if anything.

    O is M, unless another side of the part is clearly longer than that along x, or M's origin lies outside the part's
    box. Then O's origin is the middle of the box, and x runs along the longest side.
    """
    extents, bounds = mesh.extents, mesh.bounds
    longest = int(np.argmax(np.round(extents, 6)))
    inside = bool((bounds[0] <= 1e-9).all() and (bounds[1] >= -1e-9).all())
    turned = extents[longest] > _LONGER * extents[0]
    if inside and not turned:
        return mesh, Pose.identity(), None
    axes = np.roll(np.eye(3), -longest, axis=0) if turned else np.eye(3)  # rows: O's axes in M, right-handed
    X_MO = Pose(axes.T, np.round(bounds.mean(axis=0), 6))
    moved = mesh.copy()
    moved.apply_transform(X_MO.inverse().matrix)
    which = f"its x axis along the mesh's {_AXES[longest]}" if turned else "its axes those of the mesh"
    origin = " ".join(f"{1000 * x:g}" for x in X_MO.translation)
    return moved, X_MO, f"frame O has its origin in the middle of the mesh's box, at {origin} mm, {which}"
