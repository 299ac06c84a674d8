"""Conditions on a compiled cell: light, reflections and friction."""

import mujoco

from sim.model.conditions import Conditions

BELT_MATERIAL = "belt"


def disturb(mj_model: mujoco.MjModel, conditions: Conditions) -> None:
    """Changes the compiled cell in place; undisturbed conditions leave every bit as it is."""
    headlight = mj_model.vis.headlight
    lights = mj_model.light_ambient, mj_model.light_diffuse, mj_model.light_specular
    for brightness in (*lights, headlight.ambient, headlight.diffuse, headlight.specular):
        brightness[:] = conditions.light * brightness
    mj_model.mat_reflectance[mj_model.material(BELT_MATERIAL).id] = conditions.reflections
    # Gloss: the nearer to 1, the brighter and the smaller the lights' highlights on parts and belt.
    for gloss in (mj_model.mat_specular, mj_model.mat_shininess):
        gloss[:] = gloss + conditions.reflections * (1.0 - gloss)
    # MuJoCo takes the larger friction of two bodies that touch, so that all of them are scaled.
    mj_model.geom_friction[:, 0] *= conditions.friction
    mj_model.pair_friction[:, :2] *= conditions.friction  # both directions of sliding
