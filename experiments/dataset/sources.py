"""Test images with what networks make of them: generated ones with simulated networks, pictures with trained ones."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cell.interfaces import Detection, Frame
from cell.layout import default_camera
from cell.perception import by_score
from experiments.errors import UsageError
from maskval import Correspondences, Mesh, Pose, bop
from maskval.bop.images import mask_path, read_mask
from sim.images.generated import GeneratedImage, Recipe, draw_nearest, make_image
from sim.instance_ids import NO_INSTANCE
from sim.learned.coordinates import ObjectCoordinates
from sim.learned.estimators import LearnedMasks, LearnedPoses, learned_estimators
from sim.learned.weights import networks_of
from sim.model.parts import PartModel
from sim.networks.ground_truth import FrameTruth
from sim.networks.image_estimates import estimate_image
from sim.networks.noise_model import load_noise
from sim.networks.random_streams import Streams


@dataclass(frozen=True, slots=True, eq=False)
class SeenImage:
    """A test image and what the networks make of it.

    Attributes:
        truth: about the image.
        detections: what the detector found.
        parts: the part that each of them shows, or `NO_INSTANCE`.
        poses: poses[e][i] is X_CO_est of detection i by network e.
        depth: gives the z-depth, (H, W) m; None where there is none.
        correspondences: of network 0's poses, if it tells them.
        rgb: the picture, (H, W, 3), if there is one.
    """

    truth: FrameTruth
    detections: tuple[Detection, ...]
    parts: tuple[int, ...]
    poses: tuple[tuple[Pose, ...], ...]
    depth: Callable[[], NDArray[np.float32]] | None = None
    correspondences: tuple[Correspondences, ...] | None = None
    rgb: NDArray[np.uint8] | None = None


@dataclass(frozen=True, slots=True)
class PictureSet:
    """Rendered pictures and the trained networks that look at them.

    Attributes:
        folder: a BOP dataset.
        split: its split.
        networks: the folder of the networks; None for those that come along.
    """

    folder: Path
    split: str
    networks: Path | None

    def numbers(self) -> list[tuple[int, int]]:
        """Scene and image of each picture, in order.

        Raises:
            UsageError: there is no such set, or it is without true poses.
        """
        return _read(self)[1]

    def check(self, images: int) -> None:
        """Raises UsageError unless there are so many pictures."""
        there = len(self.numbers())
        if there < images:
            raise UsageError(f"{self.folder}: expected {images} pictures in the split {self.split}, got {there}")


def generated(model: PartModel, seed: int, images: range) -> Iterator[SeenImage]:
    """Images of geometry alone, seen by the simulated networks with the part's error model."""
    camera, noise, mesh = default_camera(), load_noise(model.noise), model.part.mesh
    for number in images:
        streams = Streams(seed, number, model.part.name)
        image = make_image(mesh, camera, Recipe(), streams)
        found = estimate_image(image.truth, noise, streams)
        yield SeenImage(image.truth, found.detections, found.parts, found.poses, depth=partial(_depth, image))


def _depth(image: GeneratedImage) -> NDArray[np.float32]:
    return draw_nearest(image.bodies, image.truth.camera)[1]


def photographed(model: PartModel, pictures: PictureSet, images: range) -> Iterator[SeenImage]:
    """Rendered pictures, seen by trained networks."""
    detector, networks = learned_estimators(networks_of(model.part.name, pictures.networks), model.part)
    dataset, numbers = _read(pictures)
    for number in images:
        scene_id, im_id = numbers[number]
        rgb = dataset.photo(scene_id, im_id)
        if rgb is None:
            raise UsageError(f"{pictures.folder}: expected a picture of image {im_id} of scene {scene_id}, got none")
        yield _seen(_truth(dataset, (scene_id, im_id), rgb.shape[:2], model.part.mesh, number), rgb, detector, networks)


def poses_alike(model: PartModel, pictures: PictureSet | None) -> tuple[Pose, ...]:
    """The poses in which a part looks alike to its networks; trained ones know symmetries that no file lists."""
    if pictures is None:
        return model.part.symmetries
    return ObjectCoordinates.of(model.part.mesh, model.part.symmetries).alike


def _seen(
    truth: FrameTruth, rgb: NDArray[np.uint8], detector: LearnedMasks, networks: tuple[LearnedPoses, ...]
) -> SeenImage:
    frame = Frame(truth.frame, 0.0, truth.camera, Pose.identity(), rgb=rgb)
    detections = tuple(sorted(detector.detect(frame), key=by_score))
    estimates = [network.estimate(frame, detections) for network in networks]
    points = tuple(one.correspondences for one in estimates[0] if one.correspondences is not None)
    poses = tuple(tuple(one.X_CO_est for one in each) for each in estimates)
    parts = tuple(truth.shown_by(detection.mask) for detection in detections)
    return SeenImage(truth, detections, parts, poses, correspondences=points, rgb=rgb)


@lru_cache(maxsize=2)
def _read(pictures: PictureSet) -> tuple[bop.Dataset, list[tuple[int, int]]]:
    dataset = bop.Dataset(pictures.folder, split=pictures.split)
    numbers = []
    for scene_id in dataset.scene_ids:
        truths = dataset.scene(scene_id).truths
        if truths is None:
            raise UsageError(f"{pictures.folder}: expected true poses (scene_gt.json) in scene {scene_id}, got none")
        numbers += [(scene_id, im_id) for im_id in truths]
    return dataset, numbers


def _truth(dataset: bop.Dataset, where: tuple[int, int], size: tuple[int, int], mesh: Mesh, number: int) -> FrameTruth:
    (scene_id, im_id), (height, width) = where, size
    scene = dataset.scene(scene_id)
    assert scene.truths is not None  # `_read` has made sure
    ids = np.full((height, width), NO_INSTANCE, dtype=np.int8)
    for part in range(len(scene.truths[im_id])):
        ids[read_mask(mask_path(scene.folder, im_id, part))] = part
    poses = tuple(truth.X_CO for truth in scene.truths[im_id])
    return FrameTruth(number, ids, poses, scene.cameras[im_id].camera(width, height), mesh)
