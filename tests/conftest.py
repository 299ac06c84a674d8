from hypothesis import settings

import sim  # noqa: F401  # before any test imports MuJoCo: it chooses the OpenGL that needs no window

# The same examples everywhere: a test that fails in CI fails at home. No deadline: the cores may be shared.
settings.register_profile("graspcell", derandomize=True, deadline=None)
settings.load_profile("graspcell")
