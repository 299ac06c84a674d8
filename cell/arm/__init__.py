"""The arm: kinematics, limits, trajectories and conveyor tracking."""
