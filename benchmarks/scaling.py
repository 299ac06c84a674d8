"""How the kernel's time grows, and how far it is from what the machine allows at all."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import trimesh

from benchmarks.workload import CAMERAS, load_mesh, poses, task_masks
from maskval import Camera, Mesh, PackedMasks, Pose, depth_crop, silhouette_iou
from maskval.rendering.reference import spans
from maskval.rendering.views import frame

VGA = CAMERAS["VGA"]
# Sections around and across a torus, for 1,000 to 1,000,000 triangles.
SECTIONS = ((32, 16), (54, 28), (78, 38), (100, 50), (220, 110), (452, 226), (1000, 500))
# A crossing of a row, or the end of a span, costs at least about this: it is computed, put in its row, and counted.
CROSSING_S = 2e-9


def best(call: Callable[[], Any], least_s: float = 0.2, rounds: int = 10) -> float:
    """The CPU seconds of one call in the best of some rounds: whatever else runs can only add to them."""
    call()
    begin = time.process_time()
    call()
    repeats = max(1, int(least_s / rounds / (time.process_time() - begin)))
    found = []
    for _ in range(rounds):
        begin = time.process_time()
        for _ in range(repeats):
            call()
        found.append((time.process_time() - begin) / repeats)
    return min(found)


def scaling() -> dict[str, Any]:
    """Times in microseconds over triangles, poses, masks and pixels."""
    return {
        "triangles": [_triangles(*sections) for sections in SECTIONS],
        "poses": [_poses(count) for count in (1, 8, 64, 512)],
        "masks": [_masks(count) for count in (1, 8, 64)],
        "pixels": [_pixels(depth) for depth in (3.0, 1.5, 0.8, 0.4, 0.25)],
    }


def _triangles(around: int, across: int) -> dict[str, float]:
    ring = trimesh.creation.torus(0.07, 0.025, major_sections=around, minor_sections=across)
    begin = time.perf_counter()
    mesh = Mesh(ring.vertices, ring.faces)
    prepared = time.perf_counter() - begin
    mine = poses("antenna", "VGA", 32)[:16]
    packed = PackedMasks.pack(task_masks("antenna", "VGA", 0.5)[:1])
    numba, numpy = (
        best(lambda kind=kind: silhouette_iou(mesh, mine, packed, VGA, implementation=kind))  # type: ignore[misc]
        for kind in ("numba", "numpy")
    )
    depth = best(lambda: [depth_crop(mesh, X_CO, VGA) for X_CO in mine])
    return {
        "triangles": len(ring.faces),
        "numba_us": numba / 16 * 1e6,
        "numpy_us": numpy / 16 * 1e6,
        "depth_crop_us": depth / 16 * 1e6,
        "mesh_ms": prepared * 1e3,
    }


def _poses(count: int) -> dict[str, float]:
    mesh, views_ = load_mesh("antenna"), poses("antenna", "VGA", count)
    packed = PackedMasks.pack(task_masks("antenna", "VGA", 0.5))
    return {"poses": count, "us_per_pose": best(lambda: silhouette_iou(mesh, views_, packed, VGA)) / count * 1e6}


def _masks(count: int) -> dict[str, float]:
    mesh, views_ = load_mesh("antenna"), poses("antenna", "VGA", 32)
    packed = PackedMasks.pack(np.resize(task_masks("antenna", "VGA", 0.5), (count, VGA.height, VGA.width)))
    return {"masks": count, "us_per_pose": best(lambda: silhouette_iou(mesh, views_, packed, VGA)) / 32 * 1e6}


def _pixels(depth: float) -> dict[str, float]:
    mesh = load_mesh("antenna")
    views_ = [Pose(X.rotation, np.array((0.0, 0.0, depth))) for X in poses("antenna", "VGA", 32)]
    packed = PackedMasks.pack(task_masks("antenna", "VGA", 0.5)[:1])
    seen = frame(VGA, pixel_center=0.5, canvas="full")
    pixels = np.mean([np.ptp(spans(mesh.edges, seen, X.rotation, X.translation)[:, 1:], axis=1).sum() for X in views_])
    return {
        "pixels": float(pixels),
        "us_per_pose": best(lambda: silhouette_iou(mesh, views_, packed, VGA)) / 32 * 1e6,
        "depth_crop_us": best(lambda: [depth_crop(mesh, X, VGA) for X in views_]) / 32 * 1e6,
    }


def floor(name: str, camera: str) -> dict[str, float]:
    """An estimate of the least time of the task: what must be read, at the rate of this machine, and each crossing.

    The masks are read once (NumPy's count of their ones is taken as the rate), each pose reads planes and sides once
    (at the rate of a dot product of as many bytes), and each crossing of a contour and a row costs 2 ns.
    """
    mesh, mine, masks = load_mesh(name), poses(name, camera), task_masks(name, camera, 0.5)
    size: Camera = CAMERAS[camera]
    edges = mesh.edges
    streamed = edges.planes_M.nbytes + edges.lefts.nbytes + edges.rights.nbytes
    numbers = np.ones(max(1, streamed // 4), dtype=np.float32)
    read_pose = best(lambda: np.dot(numbers, numbers))
    read_masks = best(lambda: np.count_nonzero(masks))
    seen = frame(size, pixel_center=0.5, canvas="3x3")
    crossings = sum(2 * len(spans(edges, seen, X.rotation, X.translation)) for X in mine)
    # Each span is also counted in each mask.
    counted = crossings / 2 * len(masks)
    task = read_masks + len(mine) * read_pose + (crossings + counted) * CROSSING_S
    return {
        "read_masks_us": read_masks * 1e6,
        "read_pose_us": read_pose * 1e6,
        "crossings_per_pose": crossings / len(mine),
        "task_us": task * 1e6,
    }
