"""What the command says of a part: how it lies, how it is held, what is not covered, and what to type next."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cell.layout import Container, Gripper, Layout
from cell.part import Part
from experiments.part.files import Draft
from experiments.part.trials import FELL, Tried
from maskval import Mesh
from sim.errors import SimError
from sim.model.parts import load_part
from sim.networks.noise_model import load_noise
from sim.part_making.fingers import LEAST_CLEARANCE
from sim.part_making.reach import ENOUGH, belt_share
from sim.parts.part_checks import tilt_of, warnings_of
from sim.parts.stable_poses import RestingPose

LOWEST = 0.004  # m; of a lower part the pads get no hold
WIDEST = 2 * (Gripper().max_half_opening - LEAST_CLEARANCE)
_SLOTS = Container().rows * Container().columns


def check_lines(path: Path) -> tuple[list[str], bool]:
    """What is wrong or probably not meant in a part's file, a line each, and whether the file is refused."""
    if path.suffix != ".toml":
        return [f"error: {path}: expected the .toml file of a part; `graspcell part MESH` makes one from a mesh"], True
    try:
        model = load_part(str(path))
        load_noise(model.noise)
    except SimError as error:
        return [f"error: {' '.join(str(error).split())}"], True
    told = [*warnings_of(model.part, model.resting_poses, model.pieces), *out_of_reach(model.part, model.resting_poses)]
    warnings = [f"warning: {path}: {line}" for line in told]
    poses, grasps = len(model.resting_poses), len(model.part.grasps)
    return [
        *warnings,
        f"{path}: {model.part.name}, {model.mass:g} kg, {poses} stable poses, {grasps} grasps, "
        f"{len(model.pieces)} pieces: fit" + (f", with {len(warnings)} warnings" if warnings else ""),
    ], False


def report_lines(draft: Draft, tried: Sequence[Tried]) -> list[str]:
    """The stable poses with their grasps and what the trials came to, then the slots."""
    lines = ["stable pose  share  up in O                grasp      held"]
    for index, pose in enumerate(draft.poses):
        up = " ".join(f"{x + 0.0:6.2f}" for x in pose.rotation[2])
        owner = next((one for one in draft.chosen if index in one.poses), None)
        results = [one for one in tried if one.pose == index]
        name = "none" if owner is None else owner.grasp.name
        lines.append(f"{index:11}  {pose.probability:5.1%}  {up}  {name:9}  {_held(results)}")
    lines += _uncovered(draft)
    if draft.chosen:
        mesh = Mesh(draft.mesh.vertices, draft.mesh.faces)
        grasps = tuple(one.grasp for one in draft.chosen)
        lines += out_of_reach(Part(draft.name, mesh, grasps, draft.slot.size), draft.poses)
        lines.append(_slot_line(draft))
    return lines


def out_of_reach(part: Part, poses: Sequence[RestingPose]) -> list[str]:
    """The stable poses with a grasp from above that the arm does not reach everywhere on the belt, a line each."""
    lines = []
    for index, pose in enumerate(poses):
        if not any(tilt_of(grasp, pose) <= grasp.max_tilt for grasp in part.grasps):
            continue
        share = belt_share(part, pose, Layout())
        if share < ENOUGH:
            where = f"on {share:.1%} of the belt only" if share > 0 else "nowhere on the belt"
            lines.append(
                f"poses[{index}]: the arm reaches a part that lies so, {pose.probability:.1%} of them, {where}"
            )
    return lines


def next_lines(path: Path, draft: Draft) -> list[str]:
    """What to type next."""
    few = f" --parts {draft.slot.reached}" if 0 < draft.slot.reached < _SLOTS else ""
    thresholds = Path("out/dataset/thresholds.toml")
    return [
        f"part in {path}; next:",
        f"  graspcell compare --objects {path} --estimator oracle --methods none{few}",
        f"  graspcell dataset --objects {path} --methods maskval ensemble-add",
        f"  graspcell compare --objects {path} --thresholds {thresholds}{few}",
    ]


def _held(results: Sequence[Tried]) -> str:
    if not results:
        return "not tried"
    held, trials = sum(one.held for one in results), sum(one.trials for one in results)
    others = {outcome: count for one in results for outcome, count in one.outcomes.items() if outcome != "placed"}
    told = ", ".join(f"{count} {outcome}" for outcome, count in others.items() if outcome != FELL)
    fell = f"; {others[FELL]} {FELL} before" if FELL in others else ""
    return f"{held} of {trials}" + (f" ({told})" if told else "") + fell


def _uncovered(draft: Draft) -> list[str]:
    served = {index for one in draft.chosen for index in one.poses}
    left = [index for index in range(len(draft.poses)) if index not in served]
    if not left:
        return ["every stable pose has a grasp"]
    vertices = draft.mesh.vertices
    return [
        f"not covered: stable pose {index}, {draft.poses[index].probability:.1%} of the parts: "
        f"{why_uncovered(vertices, draft.poses[index])}"
        for index in left
    ]


def why_uncovered(vertices: NDArray[np.float64], pose: RestingPose) -> str:
    """Why the gripper holds no part that lies so, as far as its outline shows it.

    Args:
        vertices: the part's, (V, 3) m in O.
        pose: how it lies.
    """
    points = vertices @ pose.rotation.T
    height, angles = float(np.ptp(points[:, 2])), np.linspace(0.0, np.pi, 90, endpoint=False)
    widths = np.ptp(points[:, :2] @ np.array([np.cos(angles), np.sin(angles)]), axis=0)
    if height < LOWEST:
        return f"{1000 * height:.1f} mm high, and finger tips stay 3 mm off the belt"
    if widths.min() > WIDEST:
        return f"at least {1000 * widths.min():.0f} mm wide, and jaws go around {1000 * WIDEST:.0f} mm at most"
    return "no two opposite faces that the jaws can close on from above without meeting belt or part"


def _slot_line(draft: Draft) -> str:
    x, y = (1000 * size for size in draft.slot.size)
    if draft.slot.reached == _SLOTS:
        return f"slot: {x:g} × {y:g} mm; the arm reaches all {_SLOTS}"
    if draft.slot.reached:
        reached = draft.slot.reached
        return f"slot: {x:g} × {y:g} mm; the arm reaches {reached} of {_SLOTS}: use --parts {reached}"
    return f"slot: no: with {x:g} × {y:g} mm the container has no slot that the arm reaches"
