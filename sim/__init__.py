"""The cell in MuJoCo: the only package that knows the engine, and the only one that knows the truth."""

import os

# MuJoCo chooses its OpenGL when it is first imported; off-screen is what a cell without a window needs.
os.environ.setdefault("MUJOCO_GL", "egl")
