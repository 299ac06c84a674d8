"""Registers the cell's Gymnasium environments: `gymnasium.make("graspcell:GraspCell-v0")`.

Gymnasium finds no installed environments by itself since its version 1.0; this module's name before the colon, or
`import graspcell`, is how it gets to know them.
"""

import gymnasium

gymnasium.register("GraspCell-v0", entry_point="sim.gym.decision_env:GraspCellEnv")
gymnasium.register("GraspCellMotion-v0", entry_point="sim.gym.motion_env:GraspCellMotionEnv")
