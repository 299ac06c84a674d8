"""The trained networks of a part: a folder with three ONNX files and a manifest."""

import json
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from maskval import InvalidFileError, Mesh
from maskval.inputs.files import read_input
from maskval.inputs.spelling import shown
from sim.errors import NetworkError

MANIFEST = "manifest.json"
FORMAT = 1
DETECTOR, STYLES = "detector", ("s1", "s2")
SHIPPED = Path(__file__).parents[1] / "assets" / "networks"
_MOST_BYTES = 50_000_000

Array = NDArray[np.float32]


class Network(Protocol):
    """A trained network: images in, arrays out."""

    def __call__(self, images: Array, /) -> tuple[Array, ...]:
        """Its outputs for N images, (N, 3, H, W) in [0, 1]."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """What is known of a part's networks beside their weights; the times and settings were measured.

    Attributes:
        part: its name.
        box_m: least and greatest coordinates of its mesh, (6,).
        detector_s: inference time of the detector, s per picture.
        pose_s: of a pose network, s per picture.
        correspondence_weight: of each pose network, see `sim.learned.pnp.solve`; found on held-out pictures.
        training: how they were trained, and on what; for people.
    """

    part: str
    box_m: tuple[float, ...]
    detector_s: float
    pose_s: float
    correspondence_weight: dict[str, float]
    training: dict[str, Any]

    def check_mesh(self, mesh: Mesh, folder: Path) -> None:
        """Raises NetworkError unless the networks were trained on this mesh."""
        box = np.concatenate((mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)))
        if not np.allclose(self.box_m, box, atol=1e-6):
            raise NetworkError(
                f"{folder}: expected networks of a part with the box {shown(box.tolist())} m, got "
                f"{shown(list(self.box_m))} m; `graspcell train` makes them anew"
            )


@dataclass(frozen=True, slots=True)
class TrainedNetworks:
    """A part's networks.

    Attributes:
        folder: where they are.
        manifest: what is known of them.
    """

    folder: Path
    manifest: Manifest

    def network(self, name: str) -> Network:
        """One of them: `DETECTOR`, or of `STYLES`.

        Raises:
            NetworkError: onnxruntime is missing, or the file cannot be read.
        """
        return open_network(self.folder / f"{name}.onnx")


def networks_of(part: str, folder: Path | None = None) -> TrainedNetworks:
    """The networks of a folder, or those that come along for a part.

    Raises:
        NetworkError: there are none, or the manifest is unfit.
    """
    return load_networks(SHIPPED / part if folder is None else folder)


def load_networks(folder: Path) -> TrainedNetworks:
    """The networks of a folder.

    Raises:
        NetworkError: there are none, or the manifest is unfit.
    """
    path = folder / MANIFEST
    if not path.is_file():
        shipped = ", ".join(sorted(entry.name for entry in SHIPPED.iterdir())) if SHIPPED.is_dir() else ""
        raise NetworkError(
            f"expected trained networks in {folder}, got no {MANIFEST} there; networks come along for "
            f"{shipped or 'no part'}, `graspcell train` makes those of another"
        )
    try:
        entries = json.loads(read_input(path))
        version = entries.pop("format")
        if version != FORMAT:
            raise NetworkError(f"{path}: expected format {FORMAT}, got {shown(version)}")
        manifest = Manifest(**entries)
        weights = manifest.correspondence_weight
        numbers = np.array((manifest.detector_s, manifest.pose_s, *manifest.box_m, *weights.values()), dtype=np.float64)
    except (ValueError, TypeError, KeyError, AttributeError, InvalidFileError) as error:
        raise NetworkError(f"{path}: expected what `graspcell train` writes, got {error}") from error
    if set(weights) != set(STYLES) or not np.isfinite(numbers).all() or len(manifest.box_m) != 6:
        raise NetworkError(f"{path}: expected settings for {', '.join(STYLES)} and finite numbers")
    return TrainedNetworks(folder, manifest)


@lru_cache(maxsize=8)
def open_network(path: Path) -> Network:
    """The network of an ONNX file; it runs in one thread.

    Raises:
        NetworkError: onnxruntime is missing, or the file cannot be read.
    """
    try:
        import onnxruntime  # noqa: PLC0415  # the extra `networks`
    except ImportError as error:
        raise NetworkError(
            "learned networks need onnxruntime, which is not installed: pip install 'graspcell[networks]'"
        ) from error
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        content = read_input(path, _MOST_BYTES)
        session = onnxruntime.InferenceSession(content, options, providers=["CPUExecutionProvider"])
    except InvalidFileError as error:
        raise NetworkError(str(error)) from error
    except Exception as error:  # onnxruntime's own classes derive from nothing else
        raise NetworkError(f"{path}: expected a network in ONNX, got {error}") from error

    def run(images: Array) -> tuple[Array, ...]:
        try:
            return tuple(session.run(None, {"images": images}))
        except Exception as error:
            raise NetworkError(
                f"{path}: expected a network that takes images as `graspcell train` writes it, got {error}"
            ) from error

    return run
