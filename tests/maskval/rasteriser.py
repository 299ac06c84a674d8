"""An independent silhouette: every triangle, in float64, against every sampling point of its box."""

import numpy as np
from numpy.typing import NDArray

from maskval import Camera, Pose


def rasterise(
    vertices_O: NDArray[np.float64],
    faces: NDArray[np.int64],
    X_CO: Pose,
    camera: Camera,
    *,
    pixel_center: float = 0.0,
    near: float = 1e-3,
) -> NDArray[np.bool_]:
    """The pixels that a triangle covers, by edge functions and the top-left rule."""
    homogeneous = X_CO.apply(vertices_O)[np.asarray(faces)] @ camera.K.T
    triangles = np.concatenate([_behind_cut(homogeneous, near)])
    corners = triangles[..., :2] / triangles[..., 2:] - pixel_center
    return _covered(corners, camera.width, camera.height)


def _behind_cut(triangles: NDArray[np.float64], near: float) -> NDArray[np.float64]:
    """The triangles' parts of depth >= near, as triangles."""
    whole = triangles[(triangles[..., 2] >= near).all(axis=1)]
    parts = [whole]
    inside = (triangles[..., 2] >= near).sum(axis=1)
    for triangle in triangles[(inside == 1) | (inside == 2)]:
        polygon = []
        for a, b in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            if a[2] >= near:
                polygon.append(a)
            if (a[2] >= near) != (b[2] >= near):
                low, high = (a, b) if a[2] < b[2] else (b, a)
                polygon.append(low + (high - low) * ((near - low[2]) / (high[2] - low[2])))
        parts.extend(np.array([[polygon[0], polygon[k], polygon[k + 1]]]) for k in range(1, len(polygon) - 1))
    return np.concatenate(parts)


def _covered(corners: NDArray[np.float64], width: int, height: int) -> NDArray[np.bool_]:
    a, b, c = np.moveaxis(corners, 1, 0)
    area = _cross(b - a, c - a)
    b, c = np.where(area[:, None] > 0, b, c), np.where(area[:, None] > 0, c, b)
    size = np.array((width, height))
    low = np.clip(np.ceil(corners.min(axis=1)), 0, size).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1)) + 1, low, size).astype(np.int64)
    across, down = (high - low).T
    image = np.zeros((height, width), dtype=np.bool_)
    seen = np.flatnonzero((area != 0) & (across > 0) & (down > 0))
    # A chunk at a time, so that large triangles do not fill the memory.
    for chunk in np.array_split(seen, 1 + int((across * down)[seen].sum()) // 2_000_000):
        pixels = across[chunk] * down[chunk]
        owner = np.repeat(chunk, pixels)
        step = np.arange(len(owner)) - np.repeat(np.cumsum(pixels) - pixels, pixels)
        i, j = low[owner, 0] + step % across[owner], low[owner, 1] + step // across[owner]
        point = np.stack((i, j), axis=1).astype(np.float64)
        inside = np.ones(len(owner), dtype=np.bool_)
        for start, stop in ((a, b), (b, c), (c, a)):
            along = (stop - start)[owner]
            side = _cross(along, point - start[owner])
            # With v downwards and a positive area, the inside is right of an edge that goes up: that is a left edge.
            top_left = (along[:, 1] < 0) | ((along[:, 1] == 0) & (along[:, 0] > 0))
            inside &= (side > 0) | ((side == 0) & top_left)
        image[j[inside], i[inside]] = True
    return image


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    result: NDArray[np.float64] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return result
