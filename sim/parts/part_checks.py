"""What a part's numbers must mean together: grasps at the part, a slot that takes it, pieces that fill it."""

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import NDArray

from cell.grasping import heading_of
from cell.part import Grasp, Part
from sim.errors import PartFileError
from sim.parts.stable_poses import RestingPose, is_supported

FARTHEST_TCP = 0.03  # m outside the part's box; the pads reach from 25 mm before the TCP to 15 mm beyond it
PIECES_BEYOND = 0.05  # of the diameter by which a piece may stand out of the part's box
LEAST_FILLED = 0.5  # of the part's box along each axis that the pieces must reach over
HULL_SHARE = (0.8, 1.3)  # of the part's volume: pieces outside of this are worth a warning


def check_part(
    part: Part,
    poses: Sequence[RestingPose],
    pieces: Sequence[trimesh.Trimesh],
    center_of_mass: NDArray[np.float64],
) -> None:
    """Rejects a part whose file contradicts its mesh.

    Raises:
        PartFileError: names the key, its value and what is valid.
    """
    if not poses:
        raise PartFileError(
            "poses: expected at least one stable pose, got none of 2 % and more; a round part needs [[poses]] in its "
            "file, which `graspcell part MESH` writes"
        )
    vertices = part.mesh.vertices
    for index, pose in enumerate(poses):
        if not is_supported(pose, vertices, center_of_mass):
            up = pose.rotation[2].round(4).tolist()
            raise PartFileError(f"poses[{index}].up: expected a direction in which the part stands, got {up}: it falls")
    for index, grasp in enumerate(part.grasps):
        _check_tcp(index, grasp, part.mesh.bounds)
    _check_slot(part, poses)
    _check_pieces(part, pieces)


def warnings_of(part: Part, poses: Sequence[RestingPose], pieces: Sequence[trimesh.Trimesh]) -> list[str]:
    """What works but is probably not meant, a line each."""
    told = []
    for index, pose in enumerate(poses):
        tilts = [tilt_of(grasp, pose) for grasp in part.grasps]
        if not any(tilt <= grasp.max_tilt for tilt, grasp in zip(tilts, part.grasps, strict=True)):
            told.append(
                f"poses[{index}]: no grasp from above: a part that lies so (up {pose.rotation[2].round(3).tolist()} in "
                f"O, {pose.probability:.0%} of the parts) stays; the most upright grasp is tilted by "
                f"{np.degrees(min(tilts)):.0f}°"
            )
    surface = trimesh.Trimesh(part.mesh.vertices, part.mesh.faces)
    share = sum(piece.volume for piece in pieces) / surface.volume
    if not HULL_SHARE[0] <= share <= HULL_SHARE[1]:
        told.append(
            f"mesh.pieces: what collides has {share:.2f} times the part's volume, expected {HULL_SHARE[0]} to "
            f"{HULL_SHARE[1]}; `graspcell part MESH` makes pieces that fit"
        )
    return told


def tilt_of(grasp: Grasp, pose: RestingPose) -> float:
    """The tilt of a grasp's approach from the vertical, rad, at a part that lies so."""
    return float(np.arccos(np.clip(-(pose.rotation @ grasp.X_OT.rotation[:, 2])[2], -1.0, 1.0)))


def laid_points(R_WO: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points (N, 3) of O along W's axes, with the part turned as it is laid into its slot; O's origin stays at 0."""
    heading = heading_of(R_WO)
    c, s = np.cos(heading), np.sin(heading)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    laid: NDArray[np.float64] = points @ (turn @ R_WO).T
    return laid


def laid_extents(R_WO: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Extents of `laid_points` along W's axes, (3,) m."""
    extents: NDArray[np.float64] = np.ptp(laid_points(R_WO, points), axis=0)
    return extents


def _check_tcp(index: int, grasp: Grasp, bounds: NDArray[np.float64]) -> None:
    tcp = grasp.X_OT.translation
    outside = np.linalg.norm(np.maximum(0.0, np.maximum(bounds[0] - tcp, tcp - bounds[1])))
    if outside > FARTHEST_TCP:
        low, high = (1000 * bounds).round(1).tolist()
        raise PartFileError(
            f"grasps[{index}].tcp_mm: expected a point within {1000 * FARTHEST_TCP:.0f} mm of the part's box "
            f"{low} to {high}, got {(1000 * tcp).round(1).tolist()}"
        )


def _check_slot(part: Part, poses: Sequence[RestingPose]) -> None:
    for index, pose in enumerate(poses):
        needed = laid_extents(pose.rotation, part.mesh.vertices)[:2]
        if (needed > np.array(part.slot_size)).any():
            got = [round(1000 * size, 1) for size in part.slot_size]
            raise PartFileError(
                f"slot.size_mm: expected at least {(1000 * needed).round(1).tolist()}, the part in its stable pose "
                f"{index}, got {got}"
            )


def _check_pieces(part: Part, pieces: Sequence[trimesh.Trimesh]) -> None:
    low, high = part.mesh.bounds
    room = PIECES_BEYOND * part.mesh.diameter
    for index, piece in enumerate(pieces):
        if (piece.bounds[0] < low - room).any() or (piece.bounds[1] > high + room).any():
            box = (1000 * piece.bounds).round(1).tolist()
            raise PartFileError(f"mesh.pieces[{index}]: expected a piece within the part's box, got {box} mm")
    bounds = np.array([piece.bounds for piece in pieces])
    reach = bounds[:, 1].max(axis=0) - bounds[:, 0].min(axis=0)
    if (reach < LEAST_FILLED * (high - low)).any():
        raise PartFileError(
            f"mesh.pieces: expected pieces that fill the part's box of {(1000 * (high - low)).round(1).tolist()} mm, "
            f"got {(1000 * reach).round(1).tolist()} mm"
        )
