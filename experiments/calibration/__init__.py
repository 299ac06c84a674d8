"""`graspcell calibrate`: error models fitted to the paper's dataset tables."""
