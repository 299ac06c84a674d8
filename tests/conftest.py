import os

from hypothesis import settings

os.environ.setdefault("MUJOCO_GL", "egl")  # before any test imports MuJoCo: some render with it without this package

# The same examples everywhere: a test that fails in CI fails at home. No deadline: the cores may be shared.
settings.register_profile("graspcell", derandomize=True, deadline=None)
settings.load_profile("graspcell")
