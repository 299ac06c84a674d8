"""Conditions on a compiled cell: light, reflections and friction."""

import mujoco

from sim.model.conditions import Conditions

BELT_MATERIAL = "belt"


def disturb(model: mujoco.MjModel, conditions: Conditions) -> None:
    """Changes the compiled cell in place; undisturbed conditions leave every bit as it is."""
    headlight = model.vis.headlight
    lights = model.light_ambient, model.light_diffuse, model.light_specular
    for brightness in (*lights, headlight.ambient, headlight.diffuse, headlight.specular):
        brightness[:] = conditions.light * brightness
    model.mat_reflectance[model.material(BELT_MATERIAL).id] = conditions.reflections
    # Gloss: the nearer to 1, the brighter and the smaller the lights' highlights on parts and belt.
    for gloss in (model.mat_specular, model.mat_shininess):
        gloss[:] = gloss + conditions.reflections * (1.0 - gloss)
    # MuJoCo takes the larger friction of two bodies that touch, so that all of them are scaled.
    model.geom_friction[:, 0] *= conditions.friction
