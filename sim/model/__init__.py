"""The cell as a MuJoCo model: parts, robot, fixtures and conditions in, compiled model and renderer out."""
