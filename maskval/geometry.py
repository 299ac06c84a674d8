"""Rigid poses in monogram notation: `X_AB` is the pose of frame B in frame A, and `X_AC = X_AB @ X_BC`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maskval.errors import InvalidPoseError
from maskval.inputs.arrays import floats

# A float32 rotation is orthonormal to about 2e-7; a matrix typed with five digits is not a rotation.
ROTATION_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """The pose X_AB of frame B in frame A: `p_A = rotation @ p_B + translation`.

    Args:
        rotation: R_AB, (3, 3), orthonormal to 1e-6 with determinant +1.
        translation: Origin of B in A, (3,), metres.

    Raises:
        InvalidPoseError: If a shape is wrong, a number is not finite, or the rotation is none.
    """

    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]
    # NumPy would take a pose for a scalar; this makes `pose @ array` and `array @ pose` a TypeError.
    __array_ufunc__: ClassVar[None] = None

    def __post_init__(self) -> None:
        rotation = _array("rotation", self.rotation, (3, 3))
        translation = _array("translation", self.translation, (3,))
        _check_rotation(*rotation.tolist())
        self._freeze(rotation, translation)

    def __reduce__(self) -> tuple[type[Self], tuple[NDArray[np.float64], NDArray[np.float64]]]:
        # What comes out of a pickle is not writeable either.
        return type(self), (self.rotation, self.translation)

    def _freeze(self, rotation: NDArray[np.float64], translation: NDArray[np.float64]) -> None:
        rotation.setflags(write=False)
        translation.setflags(write=False)
        object.__setattr__(self, "rotation", rotation)
        object.__setattr__(self, "translation", translation)

    @classmethod
    def _trusted(cls, rotation: NDArray[np.float64], translation: NDArray[np.float64]) -> Self:
        """A pose of fresh arrays that are known to be valid: what composition makes needs no second check."""
        pose = object.__new__(cls)
        pose._freeze(rotation, translation)
        return pose

    @classmethod
    def identity(cls) -> Self:
        """The pose of a frame in itself."""
        return cls._trusted(np.eye(3), np.zeros(3))

    @classmethod
    def from_translation(cls, translation: ArrayLike) -> Self:
        """A pose without rotation.

        Args:
            translation: Origin of B in A, (3,), metres.
        """
        return cls._trusted(np.eye(3), _array("translation", translation, (3,)))

    @classmethod
    def from_matrix(cls, matrix: ArrayLike) -> Self:
        """The pose that a homogeneous matrix holds.

        Args:
            matrix: (4, 4), its last row 0 0 0 1, translation in metres.
        """
        X = _array("matrix", matrix, (4, 4))
        if not np.array_equal(X[3], (0, 0, 0, 1)):
            raise InvalidPoseError(f"the last row of a homogeneous matrix must be 0 0 0 1, but is {X[3]}")
        return cls(X[:3, :3], X[:3, 3])

    @classmethod
    def from_quaternion_wxyz(cls, quaternion_wxyz: ArrayLike, translation: ArrayLike = (0, 0, 0)) -> Self:
        """The pose of a unit quaternion and a translation.

        Args:
            quaternion_wxyz: Scalar first, (4,), of norm 1 to 1e-6 (the rest is normalised away).
            translation: Origin of B in A, (3,), metres.
        """
        q = _array("quaternion_wxyz", quaternion_wxyz, (4,))
        norm = float(np.sqrt(q @ q))
        if abs(norm - 1) > ROTATION_TOLERANCE:
            raise InvalidPoseError(f"quaternion_wxyz must have norm 1 to {ROTATION_TOLERANCE:g}, but has {norm:.9g}")
        return cls._trusted(_matrix_from_quaternion(q / norm), _array("translation", translation, (3,)))

    @classmethod
    def from_rotvec(cls, rotvec: ArrayLike, translation: ArrayLike = (0, 0, 0)) -> Self:
        """The pose of a rotation vector (axis times angle) and a translation.

        Args:
            rotvec: Axis times angle, (3,), radians.
            translation: Origin of B in A, (3,), metres.
        """
        r = _array("rotvec", rotvec, (3,))
        half = 0.5 * math.sqrt(float(r @ r))
        # sin(h) / (2 h), whose limit at 0 is 1/2: below 1e-8 the next term is under half a unit in the last place.
        scale = 0.5 * math.sin(half) / half if half > 1e-8 else 0.5
        q = np.array((math.cos(half), *(scale * r)))
        return cls._trusted(_matrix_from_quaternion(q / np.sqrt(q @ q)), _array("translation", translation, (3,)))

    def __matmul__(self, other: "Pose") -> "Pose":
        if not isinstance(other, Pose):
            return NotImplemented
        return Pose._trusted(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

    def inverse(self) -> "Pose":
        """X_BA, the pose of A in B."""
        R_BA = self.rotation.T.copy()
        return Pose._trusted(R_BA, -(R_BA @ self.translation))

    def apply(self, points_B: ArrayLike) -> NDArray[np.float64]:
        """The points in frame A, of the shape of the points given.

        Args:
            points_B: Points in frame B, (..., 3), metres.
        """
        points = floats("points_B", points_B, InvalidPoseError)
        if points.shape[-1:] != (3,):
            raise InvalidPoseError(f"points_B must have shape (..., 3), but has {points.shape}")
        moved: NDArray[np.float64] = points @ self.rotation.T + self.translation
        return moved

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The homogeneous matrix, (4, 4)."""
        X = np.eye(4)
        X[:3, :3] = self.rotation
        X[:3, 3] = self.translation
        return X

    @property
    def quaternion_wxyz(self) -> NDArray[np.float64]:
        """The unit quaternion, scalar first and not negative, (4,)."""
        return _quaternion_from_matrix(self.rotation)

    @property
    def rotvec(self) -> NDArray[np.float64]:
        """Rotation axis times angle, (3,), radians, of norm at most π."""
        q = self.quaternion_wxyz
        sine = math.sqrt(float(q[1:] @ q[1:]))
        # angle / sin(angle / 2), whose limit at 0 is 2.
        scale = 2 * math.atan2(sine, float(q[0])) / sine if sine > 1e-8 else 2.0
        rotvec: NDArray[np.float64] = scale * q[1:]
        return rotvec


PoseLike = Pose | ArrayLike  # a pose, or its homogeneous matrix, (4, 4)
PosesLike = Sequence[Pose | ArrayLike] | NDArray[np.float64]  # N of them, or an array (N, 4, 4)


def as_pose(X: PoseLike) -> Pose:
    """The pose, of a pose or of its homogeneous matrix, (4, 4).

    Raises:
        InvalidPoseError: If it is neither.
    """
    return X if isinstance(X, Pose) else Pose.from_matrix(X)


def as_poses(poses: PosesLike) -> tuple[Pose, ...]:
    """The poses, of poses, of homogeneous matrices, (N, 4, 4), or of a list of either.

    Raises:
        InvalidPoseError: If one is neither; the message says which.
    """
    if isinstance(poses, Pose) or not isinstance(poses, Sequence | np.ndarray):
        raise InvalidPoseError(f"poses must be a list of poses or an array (N, 4, 4), but are {type(poses).__name__}")
    made = []
    for index, X in enumerate(poses):
        try:
            made.append(as_pose(X))
        except InvalidPoseError as error:
            raise InvalidPoseError(f"pose {index}: {error}") from error
    return tuple(made)


def angle_between(R1: NDArray[np.float64], R2: NDArray[np.float64]) -> float:
    """The angle of the rotation that leads from R1 to R2, radians, in [0, π].

    Args:
        R1: Rotation, (3, 3).
        R2: Rotation, (3, 3).
    """
    R = np.asarray(R1).T @ np.asarray(R2)
    sine = 0.5 * math.sqrt((R[2, 1] - R[1, 2]) ** 2 + (R[0, 2] - R[2, 0]) ** 2 + (R[1, 0] - R[0, 1]) ** 2)
    # The arc cosine of the trace alone loses half of the digits near 0 and near π.
    return math.atan2(sine, 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1))


def _check_rotation(x: list[float], y: list[float], z: list[float]) -> None:
    """Raises unless three rows are a rotation; in Python's numbers, because NumPy takes longer for nine."""
    off = max(abs(_dot(a, b) - (a is b)) for a, b in ((x, x), (y, y), (z, z), (x, y), (y, z), (z, x)))
    if off > ROTATION_TOLERANCE:
        raise InvalidPoseError(
            f"rotation must be orthonormal to {ROTATION_TOLERANCE:g}, but R Rᵀ differs from I by {off:.3g}"
        )
    (a, b, c), (d, e, f) = x, y
    if _dot((b * f - c * e, c * d - a * f, a * e - b * d), z) < 0:  # the third row is the cross product of the others
        raise InvalidPoseError("rotation must have determinant +1, but has -1: it mirrors (a left-handed frame?)")


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    array = floats(name, value, InvalidPoseError)
    if array.shape != shape:
        raise InvalidPoseError(f"{name} must have shape {shape}, but has {array.shape}")
    if not all(map(math.isfinite, array.ravel().tolist())):
        raise InvalidPoseError(f"{name} must be finite, but is {array.tolist()}")
    return array


def _matrix_from_quaternion(q: NDArray[np.float64]) -> NDArray[np.float64]:
    w, x, y, z = (float(value) for value in q)
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
    )


def _quaternion_from_matrix(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Shepperd's method: each row is the quaternion times four times one of its components; take the longest."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = R.tolist()
    rows = np.array(
        (
            (1 + xx + yy + zz, zy - yz, xz - zx, yx - xy),
            (zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx),
            (xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy),
            (yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz),
        )
    )
    q: NDArray[np.float64] = rows[np.argmax(np.diagonal(rows))]
    q = q / np.sqrt(q @ q)
    return -q if q[0] < 0 else q
