"""The UR10 (CB3): its dimensions, limits, forward kinematics and closed-form inverse kinematics.

Frame B is the arm's Denavit-Hartenberg base frame, the one that the teach pendant calls "base". The ROS description's
`base_link` has the same origin and the same z but its x and y axes are turned by 180° about z: a point at
(0.7, 0.2, 0.1) in base_link is at (-0.7, -0.2, 0.1) in B. Frame F is the flange, the ROS description's `tool0`, z
pointing out of it. Angles are radians, in the order base, shoulder, elbow, wrist 1, wrist 2, wrist 3.

The inverse has up to eight solutions. Which one is nearest to the present joints may change along a motion, and then
the arm swings over its own top. `inverse_on_branch` and `inverse_path` therefore know one class of solutions only: arm
facing the target, elbow up, wrist 2 on its negative side.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cell.errors import KinematicsInputError
from maskval import Pose

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Universal Robots, "DH parameters for calculations of kinematics and dynamics", UR10 (CB series), metres.
D1, D4, D5, D6 = 0.1273, 0.163941, 0.1157, 0.0922
A2, A3 = -0.612, -0.5723
DH_A = (0.0, A2, A3, 0.0, 0.0, 0.0)
DH_D = (D1, 0.0, 0.0, D4, D5, D6)
DH_ALPHA = (math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)

# UR10 technical data sheet (CB3): working range ±360° on every joint; 120°/s on base and shoulder, else 180°/s.
JOINT_LIMIT = 2 * math.pi
SPEED_LIMITS = tuple(math.radians(speed_deg) for speed_deg in (120.0, 120.0, 180.0, 180.0, 180.0, 180.0))
# N m: the efforts of the ROS-Industrial ur_description for the UR10.
TORQUE_LIMITS = (330.0, 330.0, 150.0, 54.0, 54.0, 54.0)

# The eight solutions: signs of (shoulder, elbow, wrist 2). Shoulder +1 has the arm reach along +x of its own plane,
# -1 along -x; elbow is the sign of q3; wrist 2 is the sign of sin q5.
BRANCHES = np.array([(s, e, w) for s in (1, -1) for e in (1, -1) for w in (1, -1)], dtype=np.float64)
# The class to keep. The DH links have negative lengths, so an arm that faces its target reaches along -x: shoulder -1.
# With it, q3 > 0 is the elbow above the line from shoulder to wrist.
BRANCH = np.array([-1.0, 1.0, -1.0])
BRANCHES.setflags(write=False)
BRANCH.setflags(write=False)

# Distance to keep from the singular poses. At sin q3 = 0.1 the arm has lost 1.5 mm of its reach of 1.18 m; at
# sin q5 = 0.1 a turn of the flange may cost ten times its speed at the wrist; at a radius of 50 mm the base turns by
# 20 rad/s per m/s.
MIN_SIN_ELBOW = 0.1
MIN_SIN_WRIST_2 = 0.1
MIN_WRIST_RADIUS_M = 0.05

# A solution counts when forward kinematics gives the target back to this, in metres and in entries of the rotation.
FK_TOLERANCE = 1e-9
HALF_TURN_TOLERANCE = 1e-9  # turns
# Between neighbours of a path (2 ms: below 0.007 rad at full speed) a larger step is a flip and not a motion.
MAX_PATH_STEP_RAD = 0.5


def forward(q: ArrayLike) -> Pose:
    """Pose X_BF of the flange.

    Args:
        q: joint angles, shape (6,), rad.

    Raises:
        KinematicsInputError: wrong shape or not finite.
    """
    return Pose.from_matrix(forward_batch(checked_joints(q)[np.newaxis])[0])


def forward_batch(q: ArrayLike) -> Array:
    """Poses X_BF of the flange as homogeneous matrices, shape (N, 4, 4).

    Args:
        q: joint angles, shape (N, 6), rad.

    Raises:
        KinematicsInputError: wrong shape or not finite.
    """
    joints = _checked(q, "joint angles", (None, 6))
    X = _link_transform(joints, 0)
    for joint in range(1, 6):
        X = X @ _link_transform(joints, joint)
    return X


def inverse(X_BF: ArrayLike) -> tuple[Array, Mask]:
    """All solutions of the inverse kinematics, in the order of `BRANCHES`, and which of them are valid.

    Valid solutions lie in (-π, π] and give the target back through `forward_batch` to `FK_TOLERANCE`. On a singular
    pose two of them may coincide. The others hold finite numbers without meaning.

    Args:
        X_BF: flange poses, shape (N, 4, 4).

    Returns:
        Joint angles, shape (N, 8, 6), rad, and validity, shape (N, 8).

    Raises:
        KinematicsInputError: wrong shape or not finite.
    """
    X = _checked(X_BF, "flange poses", (None, 4, 4))
    q, in_reach, _ = _closed_form(X[:, np.newaxis], BRANCHES)
    back = forward_batch(q.reshape(-1, 6)).reshape(*q.shape[:2], 4, 4)
    return q, in_reach & (np.abs(back - X[:, np.newaxis]).max(axis=(2, 3)) < FK_TOLERANCE)


def inverse_on_branch(X_BF: Pose, q_near: ArrayLike) -> Array | None:
    """Joint angles of the class `BRANCH`, shape (6,), rad; None when the pose has none within the limits.

    None also covers the neighbourhood of singular poses (`MIN_SIN_ELBOW`, `MIN_SIN_WRIST_2`, `MIN_WRIST_RADIUS_M`) and
    an upper arm below the horizontal. Shoulder, elbow and wrists 1 and 2 follow from the pose alone; base and wrist 3
    take the turn nearest to `q_near` that the joint limits allow.

    Args:
        X_BF: the flange's target pose.
        q_near: joint angles to stay near to, shape (6,), rad.

    Raises:
        KinematicsInputError: `q_near` has the wrong shape or is not finite.
    """
    path = inverse_path(X_BF.matrix[np.newaxis], q_near)
    return None if path is None else path[0]


def inverse_path(X_BF: ArrayLike, q_start: ArrayLike) -> Array | None:
    """Joint angles along a path of flange poses, shape (N, 6), rad, all of the class `BRANCH`, without a jump.

    None when a pose on the way is out of reach, out of the class, near singular (see `inverse_on_branch`), beyond a
    joint limit without letting base or wrist 3 jump by a turn, or when a joint steps by more than `MAX_PATH_STEP_RAD`.

    Args:
        X_BF: flange poses in order, close to one another, shape (N, 4, 4), N ≥ 1.
        q_start: joint angles that choose the turn of base and wrist 3 at the first pose, shape (6,), rad.

    Raises:
        KinematicsInputError: wrong shape, not finite or no pose at all.
    """
    X = _checked(X_BF, "flange poses", (None, 4, 4))
    near = checked_joints(q_start)
    if len(X) == 0:
        raise KinematicsInputError("expected at least one flange pose, got an array of shape (0, 4, 4)")
    q, in_reach, wrist_radius = _closed_form(X, BRANCH)
    regular = (
        (wrist_radius >= MIN_WRIST_RADIUS_M)
        & (np.abs(np.sin(q[:, 2])) >= MIN_SIN_ELBOW)
        & (np.abs(np.sin(q[:, 4])) >= MIN_SIN_WRIST_2)
    )
    if not np.all(in_reach & regular & (np.sin(q[:, 1]) < 0.0)):
        return None
    # Wrist 1 of a tool that points down is near -90°; its cut lies opposite, at 90°.
    q[:, 3] = np.where(q[:, 3] >= math.pi / 2, q[:, 3] - 2 * math.pi, q[:, 3])
    for joint in (0, 5):
        turned = np.unwrap(q[:, joint])
        q[:, joint] = turned + _turns_towards(turned[0], near[joint])
    if np.abs(q).max() > JOINT_LIMIT or np.abs(np.diff(q, axis=0)).max(initial=0.0) > MAX_PATH_STEP_RAD:
        return None
    return q


def checked_joints(q: ArrayLike) -> Array:
    """The joint angles as an array of shape (6,).

    Args:
        q: joint angles, shape (6,), rad.

    Raises:
        KinematicsInputError: wrong shape or not finite.
    """
    return _checked(q, "joint angles", (6,))


def _checked(values: ArrayLike, what: str, shape: tuple[int | None, ...]) -> Array:
    array = np.asarray(values, dtype=np.float64)
    fits = array.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, array.shape, strict=True))
    if not fits:
        wanted = ", ".join("N" if size is None else str(size) for size in shape) + ("," if len(shape) == 1 else "")
        raise KinematicsInputError(f"expected {what} of shape ({wanted}), got {array.shape}")
    if not np.isfinite(array).all():
        first = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise KinematicsInputError(f"expected finite {what}, got {array[first]} at index {first}")
    return array


def _turns_towards(angle: float, near: float) -> float:
    """The multiple of 2π, rad, that takes the angle nearest to `near` without leaving the joint's range.

    Half a turn away on either side, it is the lesser angle: -π and π, which only the last bit tells apart, end alike.
    """
    turns = math.ceil((near - angle) / (2 * math.pi) - 0.5 - HALF_TURN_TOLERANCE) * 2 * math.pi
    if abs(angle + turns) > JOINT_LIMIT:
        turns -= math.copysign(2 * math.pi, angle + turns)
    return turns


def _link_transform(q: Array, joint: int) -> Array:
    """DH transform Rz(q) Tz(d) Tx(a) Rx(α) of one joint for every row of joint angles, shape (N, 4, 4)."""
    cos_q, sin_q = np.cos(q[:, joint]), np.sin(q[:, joint])
    # α is 0 or ±90°: rounding keeps the zeros exact.
    cos_alpha, sin_alpha = round(math.cos(DH_ALPHA[joint])), round(math.sin(DH_ALPHA[joint]))
    X = np.zeros((len(q), 4, 4))
    X[:, 0, 0], X[:, 0, 1], X[:, 0, 2], X[:, 0, 3] = cos_q, -sin_q * cos_alpha, sin_q * sin_alpha, DH_A[joint] * cos_q
    X[:, 1, 0], X[:, 1, 1], X[:, 1, 2], X[:, 1, 3] = sin_q, cos_q * cos_alpha, -cos_q * sin_alpha, DH_A[joint] * sin_q
    X[:, 2, 1], X[:, 2, 2], X[:, 2, 3] = sin_alpha, cos_alpha, DH_D[joint]
    X[:, 3, 3] = 1.0
    return X


def _closed_form(X: Array, branch: Array) -> tuple[Array, Mask, Array]:
    """Joint angles in (-π, π], whether the arm reaches, and the wrist's distance from the base axis in the arm's plane.

    Args:
        X: flange poses X_BF, shape (..., 4, 4).
        branch: signs of (shoulder, elbow, wrist 2) as in `BRANCHES`, shape (..., 3), broadcast with the poses.
    """
    shoulder, elbow, wrist = branch[..., 0], branch[..., 1], branch[..., 2]
    n, o, a, p = X[..., :3, 0], X[..., :3, 1], X[..., :3, 2], X[..., :3, 3]
    c = p - D6 * a  # centre of wrist 3's joint: D4 to the side of the arm's plane
    rho = np.hypot(c[..., 0], c[..., 1])
    offset = np.arcsin(np.minimum(D4 / np.maximum(rho, D4), 1.0))
    q1 = np.arctan2(c[..., 1], c[..., 0]) + np.where(shoulder > 0, offset, math.pi - offset)
    cos_1, sin_1 = np.cos(q1), np.sin(q1)

    def along_plane(v: Array) -> Array:
        return np.asarray(cos_1 * v[..., 0] + sin_1 * v[..., 1])

    def across_plane(v: Array) -> Array:
        return np.asarray(sin_1 * v[..., 0] - cos_1 * v[..., 1])

    # The axis of joints 2, 3 and 4 seen from the flange is (s5 c6, -s5 s6, c5).
    n_across, o_across = across_plane(n), across_plane(o)
    q5 = wrist * np.arctan2(np.hypot(n_across, o_across), across_plane(a))
    q6 = np.arctan2(-wrist * o_across, wrist * n_across)

    # Axis of wrist 2, in the arm's plane: (sin, -cos) of q2 + q3 + q4.
    z4 = -np.sin(q6)[..., np.newaxis] * n - np.cos(q6)[..., np.newaxis] * o
    q234 = np.arctan2(along_plane(z4), -z4[..., 2])
    x, y = along_plane(c - D5 * z4), c[..., 2] - D5 * z4[..., 2] - D1
    cos_3 = (x**2 + y**2 - A2**2 - A3**2) / (2 * A2 * A3)
    q3 = elbow * np.arccos(np.clip(cos_3, -1.0, 1.0))
    q2 = np.arctan2(y, x) - np.arctan2(A3 * np.sin(q3), A2 + A3 * np.cos(q3))

    q = np.stack(np.broadcast_arrays(q1, q2, q3, q234 - q2 - q3, q5, q6), axis=-1)
    # Rounding may put a straight arm just beyond its reach.
    in_reach = (rho >= D4 - 1e-12) & (np.abs(cos_3) <= 1.0 + 1e-12)
    return math.pi - np.mod(math.pi - q, 2 * math.pi), in_reach, np.abs(along_plane(c))
