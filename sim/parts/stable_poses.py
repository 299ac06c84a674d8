"""The ways in which a part lies still on a flat surface."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import trimesh
from numpy.typing import NDArray

from cell.rounding import rounded

RAREST_RESTING_POSE = 0.02  # poses less likely than this are facets of a rounded edge, on which no real part stays
_SUPPORT = 1e-3  # m above the lowest point within which a part is supported


@dataclass(frozen=True, slots=True, eq=False)
class RestingPose:
    """One way to lie on a flat surface: the rotation R_WO, the height of O's origin (m) and how likely it is."""

    rotation: NDArray[np.float64]
    height: float
    probability: float

    def __post_init__(self) -> None:
        copied = np.array(self.rotation)
        copied.flags.writeable = False
        object.__setattr__(self, "rotation", copied)

    @classmethod
    def from_up(cls, up_O: NDArray[np.float64], vertices: NDArray[np.float64], probability: float) -> Self:
        """The pose in which a direction of O points up, turned from O's own axes by the least angle.

        Args:
            up_O: unit vector, (3,).
            vertices: the part's, (V, 3) m.
            probability: how likely the pose is.
        """
        R_WO = rounded(turned_up(up_O))
        return cls(R_WO, float(rounded(-(vertices @ R_WO[2]).min())), probability)


def turned_up(up_O: NDArray[np.float64]) -> NDArray[np.float64]:
    """R_WO of the least angle that turns a direction of O, a unit vector, to W's z; half a turn about x from −z."""
    x, y, z = up_O
    if z < -1.0 + 1e-9:
        return np.diag([1.0, -1.0, -1.0])
    across = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])  # of up × z
    R_WO: NDArray[np.float64] = np.eye(3) + across + across @ across / (1.0 + z)
    return R_WO


def resting_poses(mesh: trimesh.Trimesh) -> tuple[RestingPose, ...]:
    """Every way in which the part lies still on a plane, likeliest first; the probabilities add up to 1.

    All numbers are rounded. Of equally likely poses, as a mirrored part has, the first is the one whose rotation has
    the lesser entries, row by row.
    """
    transforms, probabilities = trimesh.poses.compute_stable_poses(mesh, n_samples=1, sigma=0.0)
    kept = probabilities >= RAREST_RESTING_POSE
    shares = rounded(probabilities[kept] / probabilities[kept].sum())
    poses = [
        RestingPose(transform[:3, :3], float(transform[2, 3]), float(share))
        for transform, share in zip(rounded(transforms[kept]), shares, strict=True)
    ]
    return tuple(sorted(poses, key=lambda pose: (-pose.probability, *pose.rotation.ravel())))


def is_supported(pose: RestingPose, vertices: NDArray[np.float64], center_of_mass: NDArray[np.float64]) -> bool:
    """Whether the centre of mass stands over the box around the points that the part lies on, within `_SUPPORT`.

    Args:
        pose: how it lies.
        vertices: the part's, (V, 3) m in O.
        center_of_mass: (3,) m in O.
    """
    points = vertices @ pose.rotation.T
    support = points[points[:, 2] < points[:, 2].min() + _SUPPORT, :2]
    over = (pose.rotation @ center_of_mass)[:2]
    return bool((support.min(axis=0) - _SUPPORT <= over).all() and (over <= support.max(axis=0) + _SUPPORT).all())
