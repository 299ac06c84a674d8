"""The maker's meshes of the UR10, from the optional extra `graspcell[meshes]`, converted once and kept in a cache."""

import os
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from sim.errors import MeshesMissingError

_PACKAGE = "example-robot-data"
_FILES = {  # by link, as ur_description names them
    "base": "base",
    "shoulder": "shoulder",
    "upper_arm": "upperarm",
    "forearm": "forearm",
    "wrist_1": "wrist1",
    "wrist_2": "wrist2",
    "wrist_3": "wrist3",
}


@dataclass(frozen=True, slots=True, eq=False)
class MakerMesh:
    """One piece of a link's surface in one colour: (V, 3) m in the link's frame, (F, 3), RGBA in [0, 1]."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    rgba: tuple[float, float, float, float]


def maker_meshes() -> dict[str, list[MakerMesh]]:
    """The pieces of every link by its name; read from the cache, or converted and put there.

    Raises:
        MeshesMissingError: the extra is not installed.
    """
    try:
        package = distribution(_PACKAGE)
    except PackageNotFoundError:
        raise MeshesMissingError(
            "the UR10's maker's meshes are not installed; expected the extra: pip install 'graspcell[meshes]'"
        ) from None
    cache = _cache_file(package.version)
    if not cache.is_file():
        meshes = {file.stem: file for file in map(Path, package.files or ()) if "meshes/ur10/visual" in str(file)}
        pieces = {link: _convert(Path(str(package.locate_file(meshes[name])))) for link, name in _FILES.items()}
        _write(cache, pieces)
    return _read(cache)


def _cache_file(version: str) -> Path:
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "graspcell" / f"ur10-{version}.npz"


def _convert(path: Path) -> list[MakerMesh]:
    pieces: Any = trimesh.load_scene(path).dump()
    return [
        MakerMesh(
            vertices=np.asarray(piece.vertices, dtype=np.float64),
            faces=np.asarray(piece.faces, dtype=np.int32),
            rgba=_rgba(piece.visual.material.main_color),
        )
        for piece in pieces
    ]


def _rgba(color: NDArray[np.uint8]) -> tuple[float, float, float, float]:
    red, green, blue, alpha = (int(channel) / 255.0 for channel in color)
    return red, green, blue, alpha


def _write(cache: Path, links: dict[str, list[MakerMesh]]) -> None:
    """Writes aside and renames, so that another process never reads half a file."""
    arrays: dict[str, NDArray[np.generic]] = {}
    for link, pieces in links.items():
        for index, piece in enumerate(pieces):
            key = f"{link}:{index}"
            arrays[f"{key}:vertices"], arrays[f"{key}:faces"] = piece.vertices, piece.faces
            arrays[f"{key}:rgba"] = np.array(piece.rgba)
    cache.parent.mkdir(parents=True, exist_ok=True)
    aside = cache.with_suffix(f".{os.getpid()}.npz")
    np.savez_compressed(aside, allow_pickle=False, **arrays)
    aside.replace(cache)


def _read(cache: Path) -> dict[str, list[MakerMesh]]:
    links: dict[str, list[MakerMesh]] = {link: [] for link in _FILES}
    with np.load(cache, allow_pickle=False) as arrays:
        keys = sorted({name.rsplit(":", 1)[0] for name in arrays.files})
        for key in keys:
            rgba = tuple(float(value) for value in arrays[f"{key}:rgba"])
            links[key.split(":")[0]].append(
                MakerMesh(arrays[f"{key}:vertices"], arrays[f"{key}:faces"], (rgba[0], rgba[1], rgba[2], rgba[3]))
            )
    return links
