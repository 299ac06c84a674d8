"""What is drawn: the cell's parts, one of them also finer, at two image sizes, in the same poses for everyone."""

from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from maskval import Camera, Mesh, Pose, silhouette
from sim.model.parts import load_part

CAMERAS = {
    "VGA": Camera(600.0, 600.0, 320.0, 240.0, 640, 480),
    "HD": Camera(900.0, 900.0, 640.0, 360.0, 1280, 720),
}
# The parts as they are, and the antenna with each triangle cut into 16 and rounded (Loop subdivision).
OBJECTS = ("antenna", "handle", "antenna, fine")
POSES = 8
TASK_POSES = 8


@cache
def load_mesh(name: str) -> Mesh:
    part, _, fine = name.partition(", ")
    mesh = load_part(part).part.mesh
    if not fine:
        return mesh
    return Mesh(*trimesh.remesh.subdivide_loop(mesh.vertices, mesh.faces, iterations=2))


@cache
def poses(name: str, camera: str, count: int = POSES) -> list[Pose]:
    """Any rotation at 0.4 to 0.8 m, of which about one in seven reaches beyond the image."""
    seed = np.random.SeedSequence((7, OBJECTS.index(name), list(CAMERAS).index(camera)))
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        q, depth = rng.normal(size=4), rng.uniform(0.4, 0.8)
        size = np.array((CAMERAS[camera].width, CAMERAS[camera].height))
        across, down = rng.uniform(-0.45, 0.45, size=2) * size / CAMERAS[camera].fx * depth
        found.append(Pose.from_quaternion_wxyz(q / np.linalg.norm(q), (across, down, depth)))
    return found


@cache
def task_masks(name: str, camera: str, pixel_center: float) -> NDArray[np.bool_]:
    """A detector's masks of the poses, each 3 px to the right and a row lower than it should be, (K, H, W)."""
    drawn = [
        silhouette(load_mesh(name), X_CO, CAMERAS[camera], pixel_center=pixel_center).mask
        for X_CO in poses(name, camera)
    ]
    return np.roll(drawn, (1, 3), axis=(1, 2))


def three_by_three(camera: Camera) -> Camera:
    """The camera of an image three times as wide and high, around this one's."""
    width, height = camera.width, camera.height
    return Camera(camera.fx, camera.fy, camera.cx + width, camera.cy + height, 3 * width, 3 * height)
