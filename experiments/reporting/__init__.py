"""Runs as one page that explains them: `graspcell report`."""
