"""The files of a part: its TOML with every choice and its reason, its meshes and its error model."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from experiments.part.trials import Tried
from experiments.results.files import replacing, write_text
from sim.part_making.pieces import Pieces
from sim.part_making.selection import Chosen
from sim.part_making.slot import Slot
from sim.parts.stable_poses import RestingPose
from sim.parts.turns import Turn


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A part before it is written.

    Attributes:
        name: of the part.
        source: of the mesh, for the file's head.
        mesh: the surface in O, m.
        pieces: what collides.
        mass: kg.
        mass_source: where it comes from.
        friction: sliding.
        poses: stable poses.
        turns: symmetries.
        chosen: grasps.
        slot: the container's.
        notes: what was done to the mesh.
    """

    name: str
    source: str
    mesh: trimesh.Trimesh
    pieces: Pieces
    mass: float
    mass_source: str
    friction: float
    poses: tuple[RestingPose, ...]
    turns: tuple[Turn, ...]
    chosen: tuple[Chosen, ...]
    slot: Slot
    notes: tuple[str, ...]


def write_meshes(folder: Path, draft: Draft) -> None:
    """Writes the surface and the pieces, binary PLY in metres.

    Raises:
        UsageError: they cannot be written.
    """
    for name, mesh in {
        f"{draft.name}.ply": draft.mesh,
        **dict(zip(_piece_names(draft), draft.pieces.hulls, strict=True)),
    }.items():
        with replacing(folder / name) as file:
            content: Any = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(file_type="ply")
            file.write(content)


def write_part(folder: Path, draft: Draft, tried: Sequence[Tried]) -> Path:
    """Writes the part's TOML file, with what the trials came to beside each grasp; returns its path.

    Raises:
        UsageError: it cannot be written.
    """
    path = folder / f"{draft.name}.toml"
    write_text(path, part_text(draft, tried))
    return path


def part_text(draft: Draft, tried: Sequence[Tried]) -> str:
    """The text of the part's file."""
    x, y = (1000 * size for size in draft.slot.size)
    pieces = "".join(f'\n    "{name}",' for name in _piece_names(draft))
    lines = [
        f"# Made from {draft.source} by `graspcell part`. Lengths in millimetres where the name says so, otherwise SI.",
        *(f"# {note}" for note in draft.notes),
        "",
        f'name = "{draft.name}"',
        f"mass_kg = {draft.mass:.4g}  # {draft.mass_source}",
        f"friction = {draft.friction:g}  # sliding, against everything but the gripper's pads; assumed",
        "rgba = [0.30, 0.33, 0.38, 1.0]",
        "specular = 0.4",
        "shininess = 0.4",
        'noise = "noise.toml"  # the estimators\' error model, beside this file',
        "",
        "[mesh]",
        f'file = "{draft.name}.ply"',
        f"pieces = [  # convex; together {draft.pieces.share:.2f} of the part's volume{pieces}\n]",
        "",
        "[slot]",
        f"size_mm = [{x:g}, {y:g}]  # inner size along W's x and y; the arm reaches {draft.slot.reached} of these",
        "",
        *_pose_lines(draft),
        *_turn_lines(draft.turns),
        "# The tool centre point, from where it comes, and along which axis the jaws close: all in O.",
    ]
    for number, one in enumerate(draft.chosen):
        lines += _grasp_lines(number, one, draft, tried)
    return "\n".join(lines) + "\n"


def _pose_lines(draft: Draft) -> list[str]:
    served = {index for one in draft.chosen for index in one.poses}
    lines = ["# How it lies: which direction of O points up, and how likely that is; the likeliest first."]
    for index, pose in enumerate(draft.poses):
        none = "" if index in served else "  # no grasp: a part that lies so stays on the belt"
        lines += ["[[poses]]", f"up = {_vector(pose.rotation[2], 9)}{none}", f"probability = {pose.probability:g}", ""]
    return lines


def _turn_lines(turns: Sequence[Turn]) -> list[str]:
    lines = (
        ["# Turns after which it looks the same; fold 0 is any angle."] if turns else ["# No symmetry was found.", ""]
    )
    for turn in turns:
        lines += [
            "[[symmetries]]",
            f"axis = {_vector(turn.axis.axis_O, 9)}",
            f"point_mm = {_vector(1000 * turn.axis.offset_O, 3)}",
            f"fold = {turn.fold}",
            "",
        ]
    return lines


def _grasp_lines(number: int, one: Chosen, draft: Draft, tried: Sequence[Tried]) -> list[str]:
    grasp, grip = one.grasp, one.candidate.grip
    told = [result for result in tried if result.grasp == number]
    held, trials = sum(result.held for result in told), sum(result.trials for result in told)
    share = f"held and placed in {held} of {trials} trials in physics" if trials else "not tried in physics"
    poses = ", ".join(map(str, one.poses)) or "none alone"
    return [
        "",
        "[[grasps]]",
        f'name = "{grasp.name}"  # stable poses {poses} (from 0); across {2000 * grip.half_width:.1f} mm; {share}',
        f"tcp_mm = {_vector(1000 * grasp.X_OT.translation, 3)}",
        f"approach = {_vector(grasp.X_OT.rotation[:, 2], 9)}",
        f"closing = {_vector(grasp.X_OT.rotation[:, 1], 9)}",
        f"half_opening_mm = {1000 * grasp.half_opening:.1f}",
        f"max_tilt_deg = {np.degrees(grasp.max_tilt):.1f}",
    ]


def _vector(numbers: np.ndarray, digits: int) -> str:
    return (
        "["
        + ", ".join(f"{x + 0.0:g}" if x == round(x) else f"{x:.{digits}g}" for x in np.round(numbers, digits) + 0.0)
        + "]"
    )


def _piece_names(draft: Draft) -> list[str]:
    return [f"piece_{index:02d}.ply" for index in range(len(draft.pieces.hulls))]
