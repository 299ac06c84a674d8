"""Pictures of parts with ground truth: a settled heap in a room (S1), or parts pasted over a background (S2)."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Pose
from sim.images.generated import Recipe, elevation, looking_down, scatter, truth_of
from sim.images.heap import Heap, drop
from sim.images.photo_renderer import Photograph, PhotoRenderer
from sim.images.randomization import ROOM_HALF_SIZE, SurfaceSampler, lamps, room
from sim.images.textures import Picture, background, noise
from sim.instance_ids import NO_INSTANCE
from sim.model.parts import PartModel
from sim.networks.ground_truth import FrameTruth
from sim.networks.random_streams import Streams

HEAP = Recipe(parts=(2, 7), clutter=(4, 12))  # denser than what is scattered in the air, for occlusion
_HEAP_RADIUS = (0.05, 0.30)  # m
_ELEVATION_DEG = (25.0, 90.0)  # of the camera's axis over the floor
_MARGIN = 0.2  # of the image at each border, where the middle of the part aimed at does not lie
_LOWEST_CAMERA, _NEAREST_BODY = 0.15, 0.25  # m: the camera stands in nothing

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Shot:
    """How pictures are taken.

    Attributes:
        textured: share of parts with a random texture instead of their own colour, in [0, 1].
        views_per_heap: how many pictures, whose numbers follow one another, show the same heap (S1); room, surfaces,
            lamps and camera are each one's own.
        distance: least and greatest z of a part's middle, m.
        elevation_deg: least and greatest angle between the camera's axis and the floor; None for S1's 25° to 90°.
            S2 has no floor: its parts have the rotations that they would have on one, and any rotation with None.
        parts: least and greatest number of parts; None for the style's own.
        clutter: of other bodies, likewise.
        spread: least and greatest radius of the circle that the bodies of a heap fall into (S1), m.
    """

    textured: float = 0.5
    views_per_heap: int = 1
    distance: tuple[float, float] = HEAP.distance
    elevation_deg: tuple[float, float] | None = None
    parts: tuple[int, int] | None = None
    clutter: tuple[int, int] | None = None
    spread: tuple[float, float] = _HEAP_RADIUS


@dataclass(frozen=True, slots=True, eq=False)
class LabelledPicture:
    """A picture and the truth about it.

    Attributes:
        rgb: (H, W, 3).
        depth: z-depth, (H, W) m; 0 where there is only a background picture.
        truth: parts, poses and visibility.
        X_CW: the world, its floor z = 0, in the camera frame; None if there is no world.
    """

    rgb: Picture
    depth: NDArray[np.float32]
    truth: FrameTruth
    X_CW: Pose | None


def heap_picture(model: PartModel, renderer: PhotoRenderer, streams: Streams, shot: Shot) -> LabelledPicture:
    """S1: parts and clutter that fell onto the floor of a room, seen from random directions.

    Args:
        model: the kind of part.
        renderer: takes the picture.
        streams: the root of the picture's random numbers; the experiment is the picture's number.
        shot: how it is taken.

    Raises:
        DivergenceError: no heap came to rest.
        GraphicsError: there is no off-screen OpenGL.
    """
    rng, camera = streams.generator(0, "heap picture"), renderer.camera
    heap = _heap(model, Streams(streams.seed, streams.experiment // shot.views_per_heap, streams.part_name), shot)
    half_size = rng.uniform(*ROOM_HALF_SIZE, size=2)
    X_CW = _viewpoint(heap, model.part.mesh.center, camera, half_size, shot=shot, rng=rng)
    bodies = (
        *((model.part.mesh, X_CW @ X, part) for part, X in enumerate(heap.X_WO)),
        *((mesh, X_CW @ X, NO_INSTANCE) for mesh, X in heap.clutter),
    )
    dressed = SurfaceSampler(model, shot.textured, rng).with_surfaces(bodies)
    photo = renderer.photograph(dressed, room(X_CW, half_size, rng), *lamps(X_CW, rng))
    truth = truth_of(bodies, photo.instance_ids, model.part.mesh, camera, streams.experiment)
    return LabelledPicture(expose(photo.rgb, rng), photo.depth, truth, X_CW)


@lru_cache(maxsize=1)
def _heap(model: PartModel, streams: Streams, shot: Shot) -> Heap:
    """The heap of these streams; the last one is kept."""
    rng = streams.generator(0, "heap")
    spans = shot.parts or HEAP.parts, shot.clutter or HEAP.clutter
    parts, clutter = (int(rng.integers(*span, endpoint=True)) for span in spans)
    return drop(model, parts, clutter, rng.uniform(*shot.spread), rng)


def pasted_picture(model: PartModel, renderer: PhotoRenderer, streams: Streams, shot: Shot) -> LabelledPicture:
    """S2: parts and clutter in the air, scattered as in `sim.images.generated`, pasted over a background picture.

    Args:
        model: the kind of part.
        renderer: takes the picture.
        streams: the root of the picture's random numbers; the experiment is the picture's number.
        shot: how it is taken.

    Raises:
        GraphicsError: there is no off-screen OpenGL.
    """
    rng, camera = streams.generator(0, "pasted picture"), renderer.camera
    usual = Recipe()
    recipe = Recipe(shot.parts or usual.parts, shot.clutter or usual.clutter, shot.distance)
    if shot.elevation_deg is not None:
        recipe = replace(recipe, resting=model.resting_poses, elevation_deg=shot.elevation_deg)
    bodies = scatter(model.part.mesh, camera, recipe, streams)
    dressed = SurfaceSampler(model, shot.textured, rng).with_surfaces(bodies)
    photo = renderer.photograph(dressed, [], *lamps(_TOWARDS_CAMERA, rng))
    pasted = paste(photo, background(camera.height, camera.width, rng), rng.uniform(0.2, 0.8))
    truth = truth_of(bodies, photo.instance_ids, model.part.mesh, camera, streams.experiment)
    return LabelledPicture(expose(pasted, rng), photo.depth, truth, None)


STYLES = {"s1": heap_picture, "s2": pasted_picture}
# A frame like W, 0.8 m before the camera, whose z axis points up and, by half, back at it: where lamps hang.
_TOWARDS_CAMERA = Pose.from_rotvec((math.radians(120.0), 0.0, 0.0), (0.0, 0.0, 0.8))


def paste(photo: Photograph, behind: Picture, blur_px: float) -> NDArray[np.float32]:
    """The photograph pasted over another picture, (H, W, 3) in [0, 255], with a blurred border.

    Args:
        photo: what is in front.
        behind: (H, W, 3).
        blur_px: standard deviation of the blur, px.
    """
    front = cv2.GaussianBlur(photo.rgb, (0, 0), blur_px)
    share = cv2.GaussianBlur(photo.coverage, (0, 0), blur_px)[..., None]
    pasted: NDArray[np.float32] = front + (1.0 - share) * behind
    return pasted


def expose(rgb: NDArray[np.float32], rng: np.random.Generator) -> Picture:
    """The picture as a sensor gives it, (H, W, 3): a little blur, gain, tint and noise."""
    blurred = cv2.GaussianBlur(rgb, (0, 0), rng.uniform(0.2, 0.7))
    gain = rng.uniform(0.8, 1.25) * rng.uniform(0.95, 1.05, 3)
    exposed = noise(rgb.shape, rng.uniform(0.5, 4.0), rng)
    exposed += cv2.multiply(blurred, np.array((*gain, 0.0)))
    np.rint(exposed, out=exposed)
    picture: Picture = np.clip(exposed, 0, 255, out=exposed).astype(np.uint8)
    return picture


def _viewpoint(
    heap: Heap, center_O: Array, camera: Camera, half_size: Array, *, shot: Shot, rng: np.random.Generator
) -> Pose:
    """X_CW of a camera whose axis looks down, with the middle of one part somewhere in the image."""
    middles_W = np.array([X.apply(center_O) for X in heap.X_WO])
    others_W = np.array([X.apply(mesh.center) for mesh, X in heap.clutter]).reshape(-1, 3)
    size = np.array((camera.width, camera.height))
    while True:
        z = rng.uniform(*shot.distance)
        u, v = rng.uniform(_MARGIN * size, (1 - _MARGIN) * size)
        p_C = np.array(((u - camera.cx) / camera.fx * z, (v - camera.cy) / camera.fy * z, z))
        tilt = elevation(shot.elevation_deg or _ELEVATION_DEG, rng)
        azimuth, roll = rng.uniform(-math.pi, math.pi, 2)
        R_WC = looking_down(azimuth, tilt, roll)
        p_WC = middles_W[rng.integers(len(middles_W))] - R_WC @ p_C
        nearest = np.linalg.norm(np.concatenate((middles_W, others_W)) - p_WC, axis=1).min()
        inside = (np.abs(p_WC[:2]) < half_size - 0.1).all()
        if p_WC[2] >= _LOWEST_CAMERA and nearest >= _NEAREST_BODY and inside:
            return Pose(R_WC, p_WC).inverse()
