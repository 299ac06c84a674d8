"""An uncertainty method of your own beside MaskVal, in the cell.

Run it with `python own_method.py`, or by the command
`graspcell compare --objects antenna --methods maskval own_method:Area --experiments 1`.
"""

import sys

import numpy as np

from experiments.cli import main
from maskval import silhouette


class Area:
    """How much the areas of mask and silhouette differ, as a share of the larger one; where they lie does not count."""

    u_grasp = 0.1  # poses up to this u are grasped

    def __call__(self, estimates):
        """One u in [0, 1] per pose, (N,)."""
        mesh, camera, center = estimates.mesh, estimates.camera, estimates.pixel_center
        shapes = [silhouette(mesh, pose, camera, pixel_center=center).mask.sum() for pose in estimates.poses[0]]
        areas = estimates.masks.sum(axis=(1, 2))
        return np.array([1.0 - min(a, b) / max(a, b, 1) for a, b in zip(shapes, areas, strict=True)])


if __name__ == "__main__":  # workers import this file, too
    options = sys.argv[1:] or ["--experiments", "1"]
    main(["compare", "--objects", "antenna", "--methods", "maskval", "own_method:Area", *options])
