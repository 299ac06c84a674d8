"""A process in which one contender runs, so that the environment, threads and contexts of others do not touch it."""

import importlib
import os
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.workload import CAMERAS, OBJECTS, TASK_POSES, load_mesh, poses, task_masks, three_by_three
from maskval import Camera, Pose

# What is timed lasts at least this long: calls are repeated until it does.
LEAST_S = 0.004


def serve(module: str, environment: dict[str, str], connection: Connection) -> None:
    """Answers ("time", object, camera, job) with seconds and ("masks", object, camera) with packed silhouettes."""
    os.environ.update(environment)
    try:
        contender = importlib.import_module(module).Contender
        jobs = Jobs(contender)
        jobs.masks(OBJECTS[0], next(iter(CAMERAS)))
    except Exception as error:  # whatever a missing library or context raises
        connection.send(f"{type(error).__name__}: {error}")
        return
    connection.send(None)
    while (request := connection.recv()) is not None:
        kind, *arguments = request
        connection.send(getattr(jobs, kind)(*arguments))


class Jobs:
    """What a contender is timed at; it is built once for each mesh and camera."""

    def __init__(self, contender: Any) -> None:
        self._type = contender
        self._built: dict[tuple[str, str, bool], Any] = {}
        self._repeats: dict[tuple[str, str, str], int] = {}

    @property
    def pixel_center(self) -> float:
        return float(self._type.PIXEL_CENTER)

    def masks(self, name: str, camera: str) -> tuple[float, NDArray[np.uint8]]:
        """Where pixels are sampled, and the silhouettes of all poses, packed."""
        contender = self._contender(name, camera)
        return self.pixel_center, np.packbits([contender.mask(X_CO) for X_CO in poses(name, camera)], axis=-1)

    def table(self, name: str, camera: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Intersections over union and visibilities of the task."""
        return self._task(name, camera)()

    def time(self, name: str, camera: str, job: str) -> float:
        """Seconds that the job takes once: a "mask" or a "depth" of one pose, or the "task"."""
        call, count = self._job(name, camera, job)
        key = name, camera, job
        if key not in self._repeats:
            call()
            begin = time.perf_counter()
            call()
            self._repeats[key] = max(1, int(LEAST_S / (time.perf_counter() - begin)))
        repeats = self._repeats[key]
        begin = time.perf_counter()
        for _ in range(repeats):
            call()
        return (time.perf_counter() - begin) / (repeats * count)

    def _job(self, name: str, camera: str, job: str) -> tuple[Callable[[], Any], int]:
        if job == "task":
            return self._task(name, camera), 1
        draw = getattr(self._contender(name, camera), job)
        views = poses(name, camera)

        def call() -> None:
            for X_CO in views:
                draw(X_CO)

        return call, len(views)

    def _task(self, name: str, camera: str) -> Callable[[], tuple[NDArray[np.float64], NDArray[np.float64]]]:
        views, masks = poses(name, camera)[:TASK_POSES], task_masks(name, camera, self.pixel_center)
        if hasattr(self._type, "iou_and_visibility"):
            contender = self._contender(name, camera)
            return lambda: contender.iou_and_visibility(views, masks)
        return lambda: iou_and_visibility(self._contender(name, camera, wide=True), CAMERAS[camera], views, masks)

    def _contender(self, name: str, camera: str, *, wide: bool = False) -> Any:
        key = name, camera, wide
        if key not in self._built:
            size = three_by_three(CAMERAS[camera]) if wide else CAMERAS[camera]
            self._built[key] = self._type(load_mesh(name), size)
        return self._built[key]


def iou_and_visibility(
    contender: Any, camera: Camera, views: list[Pose], masks: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The task with a renderer, as BOP does it: draw on 3 x 3 images, and compare the rows of the middle one."""
    height, width = camera.height, camera.width
    iou, visibility = np.zeros((len(views), len(masks))), np.zeros(len(views))
    areas = [np.count_nonzero(mask) for mask in masks]
    for n, X_CO in enumerate(views):
        whole = contender.mask(X_CO)
        inside = whole[height : 2 * height, width : 2 * width]
        total, area = np.count_nonzero(whole), np.count_nonzero(inside)
        visibility[n] = area / total if total else 0.0
        rows = np.flatnonzero(inside.any(axis=1))
        if len(rows) == 0:
            continue
        band = slice(rows[0], rows[-1] + 1)
        for k, mask in enumerate(masks):
            overlap = np.count_nonzero(inside[band] & mask[band])
            iou[n, k] = overlap / (area + areas[k] - overlap)
    return iou, visibility
