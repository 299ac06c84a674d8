"""`python -m sim.runtime.compile_kernels`: has Numba compile all kernels, and keep them for the processes to come."""

import numpy as np

from cell.layout import Layout
from maskval import Camera, Pose, depth_image, silhouette, silhouette_boxes, silhouette_iou
from maskval.rendering.z_buffer import ZBuffer
from sim.instance_ids import PIXEL_CENTER
from sim.model.parts import PartModel, load_part
from sim.model.placement import place_parts
from sim.networks.ground_truth import FrameTruth
from sim.networks.image_estimates import estimate_image
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams
from sim.runtime.world import World
from sim.runtime.wrist_camera import WristCamera

_AHEAD = Pose(rotation=np.eye(3), translation=np.array([0.0, 0.0, 0.5]))
_IMAGES = 4  # enough for each kind of error to occur


def compile_for_networks(model: PartModel, camera: Camera) -> None:
    """Compiles what every picture needs, so that no network's time limit falls into it.

    Args:
        model: any part.
        camera: any.
    """
    mesh, image = model.part.mesh, ZBuffer(camera, pixel_center=PIXEL_CENTER)
    image.draw(mesh, _AHEAD, 0)
    truth = FrameTruth(0, image.numbers, (_AHEAD,), camera, mesh)
    for number in range(_IMAGES):
        estimate_image(truth, load_noise(model.noise), Streams(0, number, model.part.name))
    silhouette_iou(mesh, [_AHEAD], np.ones((1, camera.height, camera.width), dtype=np.bool_), camera)
    silhouette(mesh, _AHEAD, camera)


def compile_all() -> None:
    """Compiles every kernel that a command calls: one call of each."""
    layout, model = Layout(), load_part("handle")
    mesh, camera = model.part.mesh, layout.camera
    compile_for_networks(model, camera)
    silhouette_boxes(mesh, [_AHEAD], camera)
    depth_image(mesh, _AHEAD, camera)
    ZBuffer(camera).depth()
    place_parts(model, 2, layout.belt, np.random.default_rng(0))
    world = World(layout, model, 1)
    world.reset([Pose.from_translation((1.0, 0.0, 0.5))])
    WristCamera(world).instance_ids([_AHEAD])


if __name__ == "__main__":
    compile_all()
