"""`graspcell train`: pictures, three networks, their settings, and a manifest."""

from contextlib import closing
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from experiments.errors import UsageError
from experiments.rendering.command import render_dataset
from experiments.rendering.config import RenderDataset
from experiments.results.provenance import write_json
from experiments.setup.pool import run_all
from experiments.training.config import Train
from experiments.training.held_out import Found, measure
from experiments.training.pictures import looks_alike, read_pictures
from sim.learned.weights import DETECTOR, FORMAT, MANIFEST, STYLES
from sim.model.parts import load_part

NETWORKS = (*STYLES, DETECTOR)  # in the order in which they are begun: the longest first
HELD_OUT = "held-out"
# The cell's wrist camera looks from above, from 0.40 to 0.65 m. Wide heaps: most parts lie as on a belt, some lean.
_VIEWS: dict[str, Any] = {"distance_m": (0.35, 0.80), "elevation_deg": (50.0, 90.0)}
_HEAPS: dict[str, Any] = {"parts": (2, 5), "clutter": (0, 5), "spread_m": (0.15, 0.45), "textured": 0.25}


@dataclass(frozen=True, slots=True)
class Task:
    """A network to train."""

    config: Train
    network: str


def train(config: Train) -> int:
    """Trains and writes the networks; returns the exit code.

    Raises:
        UsageError: an invalid argument.
    """
    config.check()
    for needed in _sets(config):
        _render(needed)
    # Apart: PyTorch dies in a process in which Mesa's OpenGL has drawn.
    with closing(run_all(train_network, [Task(config, name) for name in NETWORKS], config.workers, apart=True)) as done:
        list(done)
    model = load_part(config.object)
    pictures = list(read_pictures(config.pictures_folder / HELD_OUT, HELD_OUT))
    found = measure(config.out, pictures, model, looks_alike(model))
    write_json(config.out / MANIFEST, _manifest(config, found))
    _report(config, found)
    return 0


def train_network(task: Task) -> None:
    """Trains one network and writes it as ONNX."""
    from experiments.training.networks.courses import course  # noqa: PLC0415  # PyTorch takes seconds, in a worker only
    from experiments.training.networks.export import export  # noqa: PLC0415
    from experiments.training.networks.loop import train as run  # noqa: PLC0415

    style = task.network if task.network in STYLES else STYLES[0]
    trained = run(course(task.network, task.config, task.config.pictures_folder / style), task.config.out / "state")
    export(trained, task.network, task.config.out / f"{task.network}.onnx")


def _sets(config: Train) -> list[RenderDataset]:
    """The sets of pictures that the networks are trained and measured on."""
    common: dict[str, Any] = {"object": config.object, "samples": 1, "rgb": "jpg", "jobs": config.jobs, **_VIEWS}
    common["seed"] = config.seed
    train: dict[str, Any] = {"split": "train", "images": config.images, "views_per_heap": 5, **common}
    folder = config.pictures_folder
    return [
        RenderDataset(style="s1", out=folder / "s1", **train, **_HEAPS),
        RenderDataset(style="s2", out=folder / "s2", **train),
        RenderDataset(style="s1", split=HELD_OUT, images=config.held_out, out=folder / HELD_OUT, **common, **_HEAPS),
    ]


def _render(pictures: RenderDataset) -> None:
    """Renders a set unless it is there.

    Raises:
        UsageError: what is there is not complete, or has another number of pictures.
    """
    folder = pictures.out
    if not (folder / MANIFEST).is_file():
        if folder.is_dir() and any(folder.iterdir()):
            raise UsageError(f"{folder} holds pictures that are not complete: delete the folder, then try again")
        if render_dataset(pictures) != 0:
            raise UsageError(f"the pictures of {folder} could not be rendered")
        return
    there = sum(1 for _ in folder.glob(f"{pictures.split}/*/rgb/*"))
    if there != pictures.images:
        raise UsageError(
            f"{folder} holds {there} pictures, expected {pictures.images}: choose another folder for --pictures, or "
            f"another number of pictures"
        )


def _manifest(config: Train, found: Found) -> dict[str, Any]:
    mesh = load_part(config.object).part.mesh
    hashes = {name: sha256((config.out / f"{name}.onnx").read_bytes()).hexdigest() for name in NETWORKS}
    steps = {"pose": config.pose_steps, "detector": config.detector_steps}
    return {
        "format": FORMAT,
        "part": load_part(config.object).part.name,
        "box_m": np.concatenate((mesh.vertices.min(axis=0), mesh.vertices.max(axis=0))).tolist(),
        "detector_s": found.detector_s,
        "pose_s": found.pose_s,
        "correspondence_weight": found.weights,
        "training": {
            "pictures": config.images,
            "steps": steps,
            "seed": config.seed,
            "sha256": hashes,
            "held_out": found.figures,
        },
    }


def _report(config: Train, found: Found) -> None:
    for name, figures in found.figures.items():
        print(f"{name}: " + ", ".join(f"{key} {value:.3g}" for key, value in figures.items()))
    print(f"networks in {config.out}; try: graspcell compare --estimator networks --networks {config.out}")
