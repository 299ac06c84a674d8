"""A part's shape from its mesh: everything but its grasps and its slot."""

import re
from collections.abc import Callable

import numpy as np

from experiments.errors import UsageError
from experiments.part.config import MakePart
from experiments.part.files import Draft
from maskval import InvalidFileError
from maskval.inputs.files import check_input
from sim.errors import PartFileError
from sim.model.parts import part_names
from sim.part_making.frame import choose_frame
from sim.part_making.pieces import AGREEMENT, MOST_PIECES, cut_into_pieces
from sim.part_making.pose_search import representatives, stable_poses
from sim.part_making.slot import Slot
from sim.part_making.surface_file import read_surface
from sim.part_making.symmetry_search import find_symmetries
from sim.parts.part_file import MASS_KG


def draft_of(config: MakePart, tell: Callable[[str], None]) -> Draft:
    """The part without grasps.

    Args:
        config: what the person set.
        tell: gets a line about each step as it ends.

    Raises:
        UsageError: a name that does not do, or a mesh that cannot be read.
        SimError: no part can be made of the mesh; the message says why.
    """
    path = config.mesh
    if path is None:
        raise UsageError("expected a mesh file, got none")
    try:
        check_input(path)
    except InvalidFileError as error:
        raise UsageError(f"mesh file {error}") from error
    name = _name(config.name or re.sub(r"[^A-Za-z0-9_.-]", "-", path.stem).lstrip("_.-"))
    tell(f"reading {path.name} ...")
    try:
        surface = read_surface(path, config.unit)
    except InvalidFileError as error:
        raise UsageError(f"mesh file {error}") from error
    mesh, _, moved = choose_frame(surface.mesh)
    x, y, z = (1000 * length for length in mesh.extents)
    notes = (f"unit of {path.name}: {surface.unit}", *surface.notes, *([moved] if moved else []))
    tell(f"{path.name}: {x:.1f} × {y:.1f} × {z:.1f} mm, {len(mesh.faces)} faces, {1e6 * mesh.volume:.2f} cm³")
    for note in notes:
        tell(f"  {note}")
    mass, mass_source = _mass(config, float(mesh.volume))
    turns = find_symmetries(mesh)
    poses = representatives(stable_poses(mesh), turns)
    if not poses:
        raise PartFileError(f"{path.name}: the part has no stable pose of 2 % and more: it rolls or tips over")
    tell(f"  {len(poses)} stable poses, {len(turns)} axes of symmetry; cutting into convex pieces ...")
    pieces = cut_into_pieces(mesh)
    if not pieces.agree:
        raise PartFileError(
            f"{path.name}: the volume of at most {MOST_PIECES} convex pieces is {pieces.share:.2f} times the mesh's, "
            f"expected 1 ± {AGREEMENT}: walls too thin or too many; expected a simpler mesh"
        )
    tell(f"  {len(pieces.hulls)} pieces with {pieces.share:.2f} times the mesh's volume (1 ± {AGREEMENT:g} is allowed)")
    empty = Slot((0.0, 0.0), 0)
    return Draft(name, path.name, mesh, pieces, mass, mass_source, config.friction, poses, turns, (), empty, notes)


def _name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,59}", name):
        raise UsageError(f"expected --name of 1 to 60 letters, digits, _ . or -, got {name!r}")
    if name in part_names():
        raise UsageError(
            f"expected another --name than those of the shipped parts, {', '.join(part_names())}; got {name!r}"
        )
    return name


def _mass(config: MakePart, volume: float) -> tuple[float, str]:
    if config.mass is not None:
        return config.mass, "as given"
    mass = float(np.round(config.density * volume, 5))
    if not MASS_KG[0] <= mass <= MASS_KG[1]:
        low, high = MASS_KG
        raise UsageError(
            f"the volume at {config.density:g} kg/m³ weighs {mass:g} kg, expected {low} to {high:g}: --mass KG"
        )
    return mass, f"the mesh's volume at {config.density:g} kg/m³"
