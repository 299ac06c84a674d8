"""Registers the cell's Gymnasium environments: `gymnasium.make("graspcell:GraspCell-v0")`.

Gymnasium finds no installed environments by itself since its version 1.0; this module's name before the colon, or
`import graspcell`, is how it gets to know them.
"""

from importlib.util import find_spec
from pathlib import Path

import gymnasium

_PACKAGES = ("maskval", "cell", "sim")  # what the environments are made of


def check_packages() -> None:
    """Looks whether the packages are graspcell's own: the current folder may have others of these names.

    Raises:
        ImportError: one is another; the message names both places.
    """
    for name in _PACKAGES:
        own = Path(__file__).resolve().parent / name
        spec = find_spec(name)
        places = [] if spec is None else [*(spec.submodule_search_locations or ()), spec.origin]
        found = places[0] if places else None
        if found is None or Path(found).resolve() != own:
            raise ImportError(
                f"expected graspcell's own package {name} in {own}, but Python finds {found}: "
                "rename the other one, or run from another folder"
            )


check_packages()
gymnasium.register("GraspCell-v0", entry_point="sim.gym.decision_env:GraspCellEnv")
gymnasium.register("GraspCellMotion-v0", entry_point="sim.gym.motion_env:GraspCellMotionEnv")
