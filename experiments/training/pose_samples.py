"""Crops of parts for the pose networks, each time cut, lit and hidden a little differently."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from experiments.training.batches import PoseBatch
from experiments.training.lighting import relit
from experiments.training.pictures import TruePicture
from maskval import Camera, Mesh, Pose
from maskval.rendering.depth import depth_image
from sim.learned.coordinates import CROP_SIZE, MAP_SIZE, ObjectCoordinates
from sim.learned.crops import PIXEL_CENTER, CropView, Square, cut

LEAST_VISIBILITY, FEWEST_PX = 0.3, 400  # of the parts that are learned from
_STORED, _STORED_SIZE = 1.6, 128  # sides of a square, and px, that are kept of a picture
_SHIFT, _TURN, _SCALE = 0.06, 0.10, 0.12  # standard deviations: share of a side, rad, of the logarithm
_MOST_SHIFT, _MOST_TURN, _MOST_SCALE = 0.08, 0.15, 0.15
_HIDDEN_SHARE = 0.3  # of the crops have a patch in front

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class StoredCrop:
    """A part as it is kept: more of the picture than a crop shows.

    Attributes:
        image: RGB, (s, s, 3).
        mask: what is visible of the part, (s, s), 0 to 255.
        square: what a crop shows if nothing is changed.
        camera: of the whole picture.
        X_CO: the part's pose.
    """

    image: NDArray[np.uint8]
    mask: NDArray[np.uint8]
    square: Square
    camera: Camera
    X_CO: Pose


def stored_crops(pictures: Iterable[TruePicture]) -> list[StoredCrop]:
    """The crops of all parts that are visible enough to learn from."""
    crops = []
    for picture in pictures:
        for part in picture.parts:
            if part.visibility < LEAST_VISIBILITY or np.count_nonzero(part.mask) < FEWEST_PX:
                continue
            square = Square.around(part.mask)
            wide = square.moved(0.0, 0.0, 0.0, _STORED)
            mask = cut(part.mask.astype(np.uint8) * 255, wide, _STORED_SIZE)
            image = cut(picture.rgb, wide, _STORED_SIZE)
            crops.append(StoredCrop(image, mask, square, picture.camera, part.X_CO))
    return crops


class PoseSamples:
    """Batches of crops; the one of a step is a function of seed and step.

    Args:
        crops: to draw from.
        mesh: the part.
        alike: the poses X_OO that the part looks alike in, the identity among them.
        size: crops in a batch.
        seed: root of all random numbers.
    """

    def __init__(self, crops: list[StoredCrop], mesh: Mesh, alike: tuple[Pose, ...], *, size: int, seed: int) -> None:
        self._crops, self._mesh, self._size, self._seed = crops, mesh, size, seed
        self._alike = alike
        self._coordinates = ObjectCoordinates.of(mesh)

    def batch(self, step: int) -> PoseBatch[NDArray[np.float32]]:
        """The batch of a step."""
        rng = np.random.default_rng((self._seed, step))
        chosen = rng.integers(len(self._crops), size=self._size)
        samples = [self._sample(self._crops[index], rng) for index in chosen]
        images, coordinates, visible, heads = (np.stack(arrays) for arrays in zip(*samples, strict=True))
        arrays = images.transpose(0, 3, 1, 2), coordinates, visible, heads
        return PoseBatch(*(np.ascontiguousarray(array, dtype=np.float32) for array in arrays))

    def _sample(self, crop: StoredCrop, rng: np.random.Generator) -> tuple[Floats, Floats, Floats, Floats]:
        view = CropView(_shaken(crop.square, rng), crop.camera, CROP_SIZE)
        wide = crop.square.moved(0.0, 0.0, 0.0, _STORED)
        image = _warped(crop.image, wide, view.square, CROP_SIZE)
        visible = _warped(crop.mask, wide, view.square, MAP_SIZE) > 127
        image, patch = _partly_hidden(image, rng)
        visible &= ~patch
        coordinates, rendered = self._true_coordinates(view, crop.X_CO)
        return relit(image, rng), coordinates, (visible & rendered).astype(np.float64), self._true_head(view, crop.X_CO)

    def _true_coordinates(self, view: CropView, X_CO: Pose) -> tuple[Floats, NDArray[np.bool_]]:
        """Normalised coordinates of all poses that look alike, (S, 3, h, w), and where the part would be seen."""
        small = CropView(view.square, view.image_camera, MAP_SIZE)
        X_VO = small.X_VC @ X_CO
        depth = depth_image(self._mesh, X_VO, small.camera, pixel_center=PIXEL_CENTER)
        points_O = X_VO.inverse().apply(small.points(depth))
        alike = [self._coordinates.normalised(turn.inverse().apply(points_O)) for turn in self._alike]
        return np.stack(alike).transpose(0, 3, 1, 2), depth > 0

    def _true_head(self, view: CropView, X_CO: Pose) -> Floats:
        center_V = (view.X_VC @ X_CO).apply(self._coordinates.center_O)
        offset = view.camera.project(center_V) / (CROP_SIZE / 2.0) - 1.0
        return np.array((*offset, np.log(center_V[2] / self._coordinates.depth_unit(view.camera))))


def _shaken(square: Square, rng: np.random.Generator) -> Square:
    du, dv, turn, scale = rng.normal(size=4) * (_SHIFT, _SHIFT, _TURN, _SCALE)
    most = (_MOST_SHIFT, _MOST_SHIFT, _MOST_TURN, _MOST_SCALE)
    du, dv, turn, scale = np.clip((du, dv, turn, scale), np.negative(most), most)
    half_turn = np.pi * rng.integers(2)
    return square.moved(du, dv, turn + half_turn, float(np.exp(scale)))


def _warped(stored: NDArray[np.uint8], wide: Square, square: Square, size: int) -> NDArray[np.uint8]:
    """What a square of the picture shows, from what was stored of it."""
    to_picture = wide.inverse_affine(_STORED_SIZE)
    affine = square.affine(size)
    turn = affine[:, :2] @ to_picture[:, :2]
    shift = affine[:, :2] @ to_picture[:, 2] + affine[:, 2]
    shift += turn @ (PIXEL_CENTER, PIXEL_CENTER) - PIXEL_CENTER  # OpenCV counts from the middle of the first pixel
    return np.asarray(cv2.warpAffine(stored, np.column_stack((turn, shift)), (size, size), flags=cv2.INTER_LINEAR))


def _partly_hidden(image: NDArray[np.uint8], rng: np.random.Generator) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """The image, in some cases behind a patch of one colour, and where that is in the map."""
    patch = np.zeros((CROP_SIZE, CROP_SIZE), dtype=np.uint8)
    if rng.uniform() < _HIDDEN_SHARE:
        corners = rng.uniform(0, CROP_SIZE, 2) + rng.uniform(-0.3, 0.3, (4, 2)) * CROP_SIZE
        cv2.fillConvexPoly(patch, cv2.convexHull(np.rint(corners).astype(np.int32)), 1)
        image = np.where(patch[..., None] > 0, rng.integers(0, 256, 3, dtype=np.uint8), image)
    small = cv2.resize(patch, (MAP_SIZE, MAP_SIZE), interpolation=cv2.INTER_AREA)
    return image, small > 0
