"""Other software that draws silhouettes, each behind the same three methods, and in a process of its own.

A contender is imported and built where it runs, so that one that is not installed can be named as missing.
"""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose


class Contender(Protocol):
    """Something that draws one mesh with one camera."""

    # Where pixel i is sampled, i + PIXEL_CENTER.
    PIXEL_CENTER: float

    def __init__(self, mesh: Mesh, camera: Camera) -> None: ...

    def mask(self, X_CO: Pose) -> NDArray[np.bool_]:
        """The silhouette, (H, W)."""
        ...

    def depth(self, X_CO: Pose) -> NDArray[Any]:
        """The z-depth, (H, W), metres; 0 where nothing is."""
        ...


# Name, module and what the environment must say before the module is imported.
PEERS: dict[str, tuple[str, dict[str, str]]] = {
    "ours, Numba": ("benchmarks.peers.ours", {}),
    "ours, NumPy": ("benchmarks.peers.ours_numpy", {}),
    "pyrender (OSMesa)": ("benchmarks.peers.with_pyrender", {"PYOPENGL_PLATFORM": "osmesa"}),
    "MuJoCo segmentation (EGL)": ("benchmarks.peers.with_mujoco", {"MUJOCO_GL": "egl"}),
    "Open3D rays": ("benchmarks.peers.with_open3d", {}),
    "DEODR": ("benchmarks.peers.with_deodr", {}),
    "moderngl (EGL)": ("benchmarks.peers.with_moderngl", {}),
}
OURS = "ours, Numba"
