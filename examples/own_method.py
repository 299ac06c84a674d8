"""An uncertainty method of your own beside MaskVal, in the cell.

Run it with `python own_method.py`, or by the command
`graspcell compare --objects antenna --methods maskval own_method:Area --experiments 1`.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np

from maskval import silhouette


class Area:
    """How much the areas of mask and silhouette differ, as a share of the larger one; where they lie does not count."""

    u_grasp = 0.1  # poses up to this u are grasped

    def __call__(self, estimates):
        """One u in [0, 1] per pose, (N,)."""
        shapes = [silhouette(estimates.mesh, pose, estimates.camera).area_px for pose in estimates.poses[0]]
        areas = [int(mask.sum()) for mask in estimates.masks]
        return np.array([1.0 - min(a, b) / max(a, b, 1) for a, b in zip(shapes, areas, strict=True)])


if __name__ == "__main__":
    options = sys.argv[1:] or ["--experiments", "1"]
    command = [sys.executable, "-m", "experiments.cli", "compare", "--objects", "antenna"]
    here = Path(__file__).parent
    subprocess.run([*command, "--methods", "maskval", "own_method:Area", *options], cwd=here, check=True)
