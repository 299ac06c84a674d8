"""The silhouette of a mesh under a pose, and its overlap with masks."""

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from maskval.camera import Camera
from maskval.contour import ContourEdges
from maskval.errors import InvalidArgumentError, InvalidMaskError
from maskval.geometry import PoseLike, PosesLike
from maskval.masks import Implementation, PackedMasks
from maskval.mesh import Mesh
from maskval.rendering.lens import Floats
from maskval.rendering.views import Canvas, Frame, frame, stacked


@dataclass(frozen=True, slots=True, eq=False)
class Silhouette:
    """What a camera sees of a mesh.

    Args:
        mask: The pixels whose sampling points the mesh covers, (H, W).
        area_px: Pixels of the whole silhouette, those outside of the image included.
    """

    mask: NDArray[np.bool_]
    area_px: int

    def __post_init__(self) -> None:
        self.mask.setflags(write=False)

    @property
    def visibility(self) -> float:
        """Share of the whole silhouette that lies inside the image, in [0, 1]; 0 for an empty one."""
        return np.count_nonzero(self.mask) / self.area_px if self.area_px else 0.0


def silhouette(
    mesh: Mesh,
    X_CO: PoseLike,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    canvas: Canvas = "full",
    implementation: Implementation = "numba",
) -> Silhouette:
    """The silhouette of a mesh: the pixels i, j whose point (i, j) + pixel_center a face covers, exactly.

    Args:
        mesh: The object.
        X_CO: Pose of the object in the camera frame, or its matrix, (4, 4). What is nearer than 1 mm to the camera's
            plane is cut off.
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        canvas: Where the whole silhouette is counted: "full" (up to 16,384 px beyond the image, which only an
            object next to the camera reaches), or "3x3" images, as BOP does.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    seen = frame(camera, pixel_center=pixel_center, canvas=canvas)
    (rotation,), (translation,) = stacked([X_CO])
    mask = np.zeros((camera.height, camera.width), dtype=np.bool_)
    area_px = _kernel(implementation).draw(mesh.edges, seen, rotation, translation, mask)
    mask.setflags(write=False)
    return Silhouette(mask, area_px)


def silhouette_iou(
    mesh: Mesh,
    poses: PosesLike,
    masks: NDArray[Any] | PackedMasks,
    camera: Camera,
    *,
    paired: bool = False,
    pixel_center: float = 0.0,
    canvas: Canvas = "full",
    implementation: Implementation = "numba",
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Intersection over union of each silhouette with each mask, and the visibility of each silhouette.

    The intersection over union counts the pixels of the image only, and is 0 where silhouette and mask are both
    empty. The visibility is the share of the whole silhouette that lies inside the image, 0 for an empty one.

    Args:
        mesh: The object.
        poses: N poses X_CO, or their homogeneous matrices, (N, 4, 4).
        masks: K masks, (K, H, W), bool or uint8 of 0 and 1, or packed once for many calls.
        camera: Intrinsics and image size.
        paired: Compare pose i with mask i only.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        canvas: Where the whole silhouette is counted: "full", or "3x3" images, as BOP does.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.

    Returns:
        The intersections over union in [0, 1], (N, K), or (N,) when paired; the visibilities in [0, 1], (N,).

    Raises:
        InvalidMaskError: If masks are not binary, of another size than the image, or not as many as the poses
            when paired.
    """
    packed = masks if isinstance(masks, PackedMasks) else PackedMasks.pack(masks, implementation=implementation)
    if (packed.height, packed.width) != (camera.height, camera.width):
        raise InvalidMaskError(
            f"masks must have the image's size {camera.height} x {camera.width} (H x W), "
            f"but have {packed.height} x {packed.width}"
        )
    if paired and len(packed) != len(poses):
        raise InvalidMaskError(f"paired masks must be as many as the {len(poses)} poses, but are {len(packed)}")
    seen = frame(camera, pixel_center=pixel_center, canvas=canvas)
    kernel = _kernel(implementation)
    iou, visibility = kernel.measure(mesh.edges, seen, stacked(poses), (packed.words, packed.areas_px), paired)
    return (iou[:, 0] if paired else iou), visibility


def silhouette_areas(
    mesh: Mesh,
    poses: PosesLike,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    canvas: Canvas = "full",
    implementation: Implementation = "numba",
) -> NDArray[np.int64]:
    """Pixels of each whole silhouette, those outside of the image included, and of its part in the image, (N, 2).

    Args:
        mesh: The object.
        poses: N poses X_CO, or their homogeneous matrices, (N, 4, 4).
        camera: Intrinsics and image size.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        canvas: Where the whole silhouette is counted: "full", or "3x3" images, as BOP does.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    seen = frame(camera, pixel_center=pixel_center, canvas=canvas)
    return _kernel(implementation).areas(mesh.edges, seen, stacked(poses))


def silhouette_boxes(
    mesh: Mesh,
    poses: PosesLike,
    camera: Camera,
    *,
    inside_image: bool = False,
    pixel_center: float = 0.0,
    canvas: Canvas = "full",
    implementation: Implementation = "numba",
) -> NDArray[np.int64]:
    """The boxes around the silhouettes: left, top, width and height, (N, 4), pixels; width 0 for an empty one.

    Args:
        mesh: The object.
        poses: N poses X_CO, or their homogeneous matrices, (N, 4, 4).
        camera: Intrinsics and image size.
        inside_image: Box the part of the silhouette inside the image, not all of it.
        pixel_center: Where pixel i is sampled, u = i + pixel_center: 0 for OpenCV, 0.5 for OpenGL, MuJoCo and BOP.
        canvas: Where the whole silhouette is looked at: "full", or "3x3" images, as BOP does.
        implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.
    """
    view, kernel = frame(camera, pixel_center=pixel_center, canvas=canvas), _kernel(implementation)
    placed = stacked(poses)
    boxes = np.zeros((len(placed[0]), 4), dtype=np.int64)
    for n, pose in enumerate(zip(*placed, strict=True)):
        row, start, stop = kernel.spans(mesh.edges, view, *pose).T
        if inside_image:
            start, stop = np.maximum(start, 0), np.minimum(stop, camera.width)
            seen = (row >= 0) & (row < camera.height) & (start < stop)
            row, start, stop = row[seen], start[seen], stop[seen]
        if len(row):
            left, top = start.min(), row.min()
            boxes[n] = left, top, stop.max() - left, row.max() + 1 - top
    return boxes


class _Kernel(Protocol):
    """What both implementations offer."""

    def spans(self, edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats) -> NDArray[np.int64]: ...

    def draw(
        self, edges: ContourEdges, frame: Frame, rotation: Floats, translation: Floats, mask: NDArray[np.bool_]
    ) -> int: ...

    def areas(self, edges: ContourEdges, frame: Frame, poses: tuple[Floats, Floats]) -> NDArray[np.int64]: ...

    def measure(
        self,
        edges: ContourEdges,
        frame: Frame,
        poses: tuple[Floats, Floats],
        masks: tuple[NDArray[np.uint64], NDArray[np.int64]],
        paired: bool,
    ) -> tuple[Floats, Floats]: ...


@cache
def _kernel(implementation: Implementation) -> _Kernel:
    """The kernel's module, imported at its first use: Numba alone takes longer to import than this package."""
    modules = {"numba": "maskval.rendering.kernels", "numpy": "maskval.rendering.reference"}
    if implementation not in modules:
        raise InvalidArgumentError(f"implementation must be one of {sorted(modules)}, but is {implementation!r}")
    return cast(_Kernel, import_module(modules[implementation]))
