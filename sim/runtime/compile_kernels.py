"""`python -m sim.runtime.compile_kernels`: has Numba compile all kernels, and keep them for the processes to come."""

import numpy as np

from cell.layout import Layout
from maskval import Camera, Mesh, Pose, depth_image, silhouette, silhouette_boxes, silhouette_iou
from maskval.rendering.z_buffer import ZBuffer
from sim.model.parts import load_part
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera

_AHEAD = Pose(rotation=np.eye(3), translation=np.array([0.0, 0.0, 0.5]))


def compile_for_networks(mesh: Mesh, camera: Camera) -> None:
    """Compiles what every picture needs, so that no network's time limit falls into it.

    Args:
        mesh: any.
        camera: any.
    """
    silhouette_iou(mesh, [_AHEAD], np.ones((1, camera.height, camera.width), dtype=np.bool_), camera)
    silhouette(mesh, _AHEAD, camera)


def compile_all() -> None:
    """Compiles every kernel that a command calls: one call of each."""
    layout, model = Layout(), load_part("handle")
    mesh, camera = model.part.mesh, layout.camera
    compile_for_networks(mesh, camera)
    silhouette_boxes(mesh, [_AHEAD], camera)
    depth_image(mesh, _AHEAD, camera)
    image = ZBuffer(camera)
    image.draw(mesh, _AHEAD, 0)
    image.depth()
    world = World(layout, model, 1)
    world.reset([Pose.from_translation((1.0, 0.0, 0.5))])
    WristCamera(world).instance_ids([_AHEAD])


if __name__ == "__main__":
    compile_all()
