"""The cell as its controller knows it: kinematics, motion, perception ports and the cycle. No simulator, no truth."""
