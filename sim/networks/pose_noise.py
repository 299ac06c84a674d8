"""From a true pose to what the pose estimators S1 and S2 would say: a core of small errors, and outliers.

With the view's difficulty D, the hidden share h = 1 − visibility and the distance r of the part's middle:
    S1's scale is s = exp(λ D + a h), S2's is r_B exp(λ D_B + a h) with D_B = ρ_D D + √(1 − ρ_D²) e_B;
    the core has standard deviations s r/r₀ times: lateral, depth_ratio × lateral along the ray, rotation about the
    two axes across the ray, in_plane_ratio × rotation about the ray;
    an outlier has logit p = logit p_out + log q_B (S2 only) + b_D difficulty + b_h h, and is a half turn about the
    part's near-symmetry axis or a gross error. S1 and S2 draw them with a correlation; of the outliers that they
    have in common, a share has the same content.
Errors along and about the ray are meant in the frame of the viewing ray: z from the camera to the part's middle,
x in the camera's x-z plane. Rotations turn about the part's middle.
"""

import math
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from maskval import Camera, Mesh, Pose
from sim.networks.noise_model import PoseNoise

Array = NDArray[np.float64]

_CLOSEST = 0.1  # an estimate stays at least this share of the true distance away from the camera


@dataclass(frozen=True, slots=True, eq=False)
class PoseLatents:
    """Standard-normal numbers of one view; rows are S1 and S2.

    Attributes:
        difficulty: D, shared by mask, S1 and S2.
        second_difficulty: e_B, S2's own.
        same_content: below its quantile, a common outlier has the same content.
        core: (2, 6): across the ray x, y, along it, rotation about x, y and the ray.
        gate: (2,): below its quantile, the estimate is an outlier.
        flip: (2,): below its quantile, the outlier is a flip.
        gross: (2, 6), as `core`.
    """

    difficulty: float
    second_difficulty: float
    same_content: float
    core: Array
    gate: Array
    flip: Array
    gross: Array

    COUNT: ClassVar[int] = 30  # numbers in the vector, without the difficulty

    @classmethod
    def from_vector(cls, difficulty: float, vector: Array) -> Self:
        """The record of a difficulty and `COUNT` other numbers; the arrays are read-only.

        Raises:
            ValueError: another number of numbers, or one is not finite.
        """
        if vector.shape != (cls.COUNT,) or not np.isfinite(vector).all():
            raise ValueError(f"expected {cls.COUNT} finite latents, got {vector}")
        frozen = vector.copy()
        frozen.setflags(write=False)
        return cls(
            difficulty=float(difficulty),
            second_difficulty=float(frozen[0]),
            same_content=float(frozen[1]),
            core=frozen[2:14].reshape(2, 6),
            gate=frozen[14:16],
            flip=frozen[16:18],
            gross=frozen[18:30].reshape(2, 6),
        )


def noisy_pose(
    X_CO_true: Pose, center_O: Array, visibility: float, latents: PoseLatents, noise: PoseNoise, *, network: int
) -> Pose:
    """X_CO_est of S1 (network 0) or S2 (network 1).

    Args:
        X_CO_true: The true pose.
        center_O: The part's middle, (3,) m.
        visibility: Visible share of the whole silhouette, in [0, 1].
        latents: The view's numbers.
        noise: The parameters.
        network: 0 or 1.
    """
    error, flipped = pose_error(X_CO_true, center_O, visibility, latents, noise, network=network)
    X_CO = _flip(X_CO_true, center_O, noise.flip_axis) if flipped else X_CO_true
    return displace(X_CO, center_O, error)


def pose_error(
    X_CO_true: Pose, center_O: Array, visibility: float, latents: PoseLatents, noise: PoseNoise, *, network: int
) -> tuple[Array, bool]:
    """The error in the frame of the ray, (6,): shift m and rotation vector rad; and whether the part is flipped.

    Args: see `noisy_pose`.
    """
    p_C = X_CO_true.apply(center_O)
    distance = math.sqrt(float(p_C @ p_C))
    error = core_scale(visibility, latents, noise, network=network) * distance * _core(latents, noise, network=network)
    flipped = False
    if is_outlier(visibility, latents, noise, network=network):
        source = 0 if network == 1 and _same_content(visibility, latents, noise) else network
        flipped = bool(ndtr(latents.flip[source]) < noise.flip_share)
        if not flipped:
            error = error + _gross_sd(noise) * latents.gross[source]
    error[2] = max(error[2], (_CLOSEST - 1.0) * distance)
    return error, flipped


def core_scale(visibility: float, latents: PoseLatents, noise: PoseNoise, *, network: int) -> float:
    """The scale s of the core, > 0; 1 for S1 in a view of difficulty 0 of an unhidden part.

    Args: see `noisy_pose`.
    """
    own = 1.0 if network == 0 else noise.second_scale
    gain = noise.difficulty_gain * _difficulty(latents, noise, network=network) + noise.hidden_gain * (1.0 - visibility)
    return own * math.exp(gain)


def outlier_probability(visibility: float, latents: PoseLatents, noise: PoseNoise, *, network: int) -> float:
    """The chance p of an outlier in a view of this difficulty and visibility, in [0, 1].

    Args: see `noisy_pose`.
    """
    p = noise.outlier_probability
    odds = p / (1.0 - p)
    if network == 1:
        odds *= noise.second_outlier_odds_ratio
    gain = noise.outlier_difficulty_gain * _difficulty(latents, noise, network=network)
    odds *= math.exp(gain + noise.outlier_hidden_gain * (1.0 - visibility))
    return odds / (1.0 + odds)


def is_outlier(visibility: float, latents: PoseLatents, noise: PoseNoise, *, network: int) -> bool:
    """Whether the estimate is a flip or a gross error.

    Args: see `noisy_pose`.
    """
    gate = latents.gate[0]
    if network == 1:
        gate = _mix(noise.second_outlier_correlation, gate, latents.gate[1])
    return bool(ndtr(gate) < outlier_probability(visibility, latents, noise, network=network))


def pose_of_nothing(mask: NDArray[np.bool_], camera: Camera, mesh: Mesh, latents: Array) -> Pose:
    """A pose for a mask that shows no part: in its direction, as far away as its size suggests, turned anyhow.

    Args:
        mask: (H, W), not empty.
        camera: The image's.
        mesh: The part that is looked for.
        latents: Standard-normal numbers, (4,): a direction in the space of quaternions.
    """
    v, u = (index + 0.5 for index in np.nonzero(mask))
    size_px = math.hypot(np.ptp(u) + 1.0, np.ptp(v) + 1.0)
    z = math.sqrt(camera.fx * camera.fy) * mesh.diameter / size_px
    y = (float(v.mean()) - camera.cy) / camera.fy * z
    x = ((float(u.mean()) - camera.cx) * z - camera.skew * y) / camera.fx
    turn = Pose.from_quaternion_wxyz(latents / math.sqrt(float(latents @ latents)), (x, y, z))
    return turn @ Pose.from_translation(-mesh.center)


def displace(X_CO: Pose, center_O: Array, error: Array) -> Pose:
    """The pose after an error in the frame of the ray: the part's middle is shifted, the part turns about it.

    Args:
        X_CO: A pose in front of the camera.
        center_O: The part's middle, (3,) m.
        error: Shift, m, and rotation vector, rad, both along the axes of the ray, (6,).
    """
    p_C = X_CO.apply(center_O)
    R_CR = ray_frame(p_C)
    return Pose.from_rotvec(R_CR @ error[3:], p_C + R_CR @ error[:3]) @ Pose.from_translation(-p_C) @ X_CO


def ray_frame(p_C: Array) -> Array:
    """R_CR, (3, 3): the frame R of the ray through a point, z away from the camera, x in the camera's x-z plane.

    Args:
        p_C: The point, (3,) m, in front of the camera.
    """
    x, y, z = (p_C / math.sqrt(float(p_C @ p_C))).tolist()
    across = math.hypot(x, z)
    return np.array(((z / across, -x * y / across, x), (0.0, across, y), (-x / across, -z * y / across, z)))


def _core(latents: PoseLatents, noise: PoseNoise, *, network: int) -> Array:
    """The core at scale 1, for 1 m of distance."""
    numbers = latents.core[0]
    if network == 1:
        numbers = _mix(noise.second_core_correlation, numbers, latents.core[1])
    lateral, rotation = noise.lateral_mm / 1000.0, math.radians(noise.rotation_deg)
    across, about = noise.depth_ratio * lateral, noise.in_plane_ratio * rotation
    sd = np.array((lateral, lateral, across, rotation, rotation, about))
    core: Array = sd * numbers / (noise.reference_distance_mm / 1000.0)
    return core


def _gross_sd(noise: PoseNoise) -> Array:
    lateral, depth = noise.gross_lateral_mm / 1000.0, noise.gross_depth_mm / 1000.0
    rotation = math.radians(noise.gross_rotation_deg)
    return np.array((lateral, lateral, depth, rotation, rotation, rotation))


def _difficulty(latents: PoseLatents, noise: PoseNoise, *, network: int) -> float:
    if network == 0:
        return latents.difficulty
    return float(_mix(noise.second_difficulty_correlation, latents.difficulty, latents.second_difficulty))


def _same_content(visibility: float, latents: PoseLatents, noise: PoseNoise) -> bool:
    """Whether S2's outlier repeats S1's."""
    shared = bool(ndtr(latents.same_content) < noise.second_same_content_share)
    return shared and is_outlier(visibility, latents, noise, network=0)


def _flip(X_CO: Pose, center_O: Array, axis_O: tuple[float, float, float]) -> Pose:
    """The pose after half a turn about an axis through the part's middle."""
    turn = Pose.from_rotvec(math.pi * np.array(axis_O), center_O)
    return X_CO @ turn @ Pose.from_translation(-center_O)


def _mix(correlation: float, shared: Array | float, own: Array | float) -> Array | float:
    """Standard-normal numbers that correlate with the shared ones."""
    return correlation * shared + math.sqrt(1.0 - correlation**2) * own
