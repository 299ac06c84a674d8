"""Free parts as bodies of a MuJoCo model, and how their contacts are solved."""

from itertools import product

import mujoco
import numpy as np

from sim.model.parts import PartModel
from sim.model.robot import GRIP_SOLIMP, GRIP_SOLREF, PAD_FRICTION, PADS, SLIP_SOLREF

PART_SOLREF = (0.006, 1.0)
FURNITURE_FRICTION = (0.7, 0.01, 0.001)


def part_body(index: int) -> str:
    """Name of the body of part `index`."""
    return f"part_{index}"


def set_physics(spec: mujoco.MjSpec, time_step: float) -> None:
    """Sets how contacts are solved.

    Args:
        spec: the model.
        time_step: s.
    """
    option = spec.option
    option.timestep = time_step
    # The implicit integrators change the arm's acceleration after the contacts were solved: what is held then slides.
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 100.0  # a held part creeps out of the jaws at 10 and falls at 1
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE  # 4.0.0's sparse Newton solver has a defect (issue 3767)
    option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP


def add_part_assets(spec: mujoco.MjSpec, model: PartModel) -> None:
    """Adds the shape, the convex pieces and the material of a kind of part."""
    name, mesh = model.part.name, model.part.mesh
    spec.add_material(name=name, rgba=model.rgba, specular=model.specular, shininess=model.shininess, reflectance=0.0)
    shape = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_EXACT)
    shape.uservert, shape.userface = mesh.vertices.ravel(), mesh.faces.ravel()
    for index, piece in enumerate(model.pieces):
        convex = spec.add_mesh(name=f"{name}_piece_{index}", inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX)
        convex.uservert, convex.userface = piece.vertices.ravel(), piece.faces.ravel()


def piece_geom(index: int, piece: int) -> str:
    """Name of a convex piece of part `index`."""
    return f"piece_{piece}_of_{part_body(index)}"


def add_part(spec: mujoco.MjSpec, index: int, model: PartModel, mass_scale: float = 1.0) -> None:
    """Adds a free part, whose assets `spec` has."""
    body = spec.worldbody.add_body(name=part_body(index), pos=(0.0, 2.0 + index, 1.0))
    body.add_freejoint(name=part_body(index))
    body.mass, body.ipos, body.explicitinertial = mass_scale * model.mass, model.center_of_mass, True
    inertia = mass_scale * model.inertia
    body.fullinertia = [*np.diag(inertia), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    mesh = mujoco.mjtGeom.mjGEOM_MESH
    body.add_geom(
        name=part_body(index),
        type=mesh,
        meshname=model.part.name,
        material=model.part.name,
        contype=0,
        conaffinity=0,
        density=0.0,
    )
    for piece in range(len(model.pieces)):
        body.add_geom(
            name=piece_geom(index, piece),
            type=mesh,
            meshname=f"{model.part.name}_piece_{piece}",
            group=3,
            density=0.0,
            condim=4,
            friction=(model.friction, 0.01, 0.001),
            solref=PART_SOLREF,
            solimp=GRIP_SOLIMP,
        )


def add_grips(spec: mujoco.MjSpec, index: int, model: PartModel) -> None:
    """Has the jaws' pads hold part `index`: contacts whose friction has a reference of its own; see `SLIP_SOLREF`."""
    for piece, pad in product(range(len(model.pieces)), PADS):
        spec.add_pair(
            geomname1=pad,
            geomname2=piece_geom(index, piece),
            condim=4,
            friction=(PAD_FRICTION[0], *PAD_FRICTION, PAD_FRICTION[-1]),
            solref=GRIP_SOLREF,
            solreffriction=SLIP_SOLREF,
            solimp=GRIP_SOLIMP,
        )
