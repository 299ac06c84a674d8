"""`graspcell render-dataset`: pictures of parts as a BOP dataset."""

import sys
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cell.layout import default_camera
from experiments.progress import bar
from experiments.rendering.config import IMAGES_PER_SCENE, RenderDataset
from experiments.rendering.files import OBJECT, Labels, targets, write_models, write_picture, write_scene
from experiments.setup.options_file import write_manifest
from experiments.setup.pool import run_all
from maskval import bop
from sim.errors import DivergenceError
from sim.images.photo_renderer import PhotoRenderer
from sim.images.pictures import STYLES
from sim.model.parts import load_part
from sim.networks.random_streams import Streams

FAILED = 1  # the exit code


@dataclass(frozen=True, slots=True)
class RenderTask:
    """A run of pictures of one scene.

    Attributes:
        config: what they are to be.
        images: their numbers in the dataset.
    """

    config: RenderDataset
    images: range


def render_dataset(config: RenderDataset) -> int:
    """Renders and writes the dataset; returns the exit code.

    Raises:
        UsageError: an invalid argument.
    """
    config.check()
    write_models(config.out, {OBJECT: load_part(config.object)}, default_camera())
    asked: list[bop.EvaluationTarget] = []
    try:
        for scene_id, labels in _scenes(config):
            write_scene(_scene_folder(config, scene_id), labels)
            asked += targets(scene_id, labels)
    except (BrokenProcessPool, DivergenceError, OSError) as error:
        reason = "a worker process died (out of memory?)" if isinstance(error, BrokenProcessPool) else error
        print(f"graspcell: error: {reason}; the dataset in {config.out} is not complete", file=sys.stderr)
        return FAILED
    bop.write_targets(config.out / f"{config.split}_targets_bop19.json", asked)
    write_manifest(config.out, "render-dataset", config)
    shown = sum(target.inst_count for target in asked)
    print(f"{config.images} pictures with {shown} parts of at least 10 % visibility in {config.out}")
    return 0


def render_batch(task: RenderTask) -> dict[int, Labels]:
    """Renders and writes the images of a task; returns their labels by number in the scene."""
    config, model, renderer = task.config, load_part(task.config.object), _renderer(task.config.samples)
    scene = _scene_folder(config, task.images[0] // IMAGES_PER_SCENE)
    (scene / "rgb").mkdir(parents=True, exist_ok=True)
    labels = {}
    for number in task.images:
        streams = Streams(config.seed, number, f"{model.part.name} {config.split}")
        picture = STYLES[config.style](model, renderer, streams, config.shot)
        im_id = number % IMAGES_PER_SCENE
        labels[im_id] = write_picture(scene, im_id, picture, config.rgb)
    return labels


@cache
def _renderer(samples: int) -> PhotoRenderer:
    """The process's own: to open OpenGL takes as long as some pictures."""
    return PhotoRenderer(default_camera(), samples)


def _scenes(config: RenderDataset) -> Iterator[tuple[int, dict[int, Labels]]]:
    """Each scene's labels once its images are written."""
    tasks = [RenderTask(config, batch) for batch in config.batches]
    labels: dict[int, Labels] = {}
    with (
        bar("image", total=config.images) as progress,
        closing(run_all(render_batch, tasks, config.workers)) as stream,
    ):
        for task, batch in zip(tasks, stream, strict=True):
            labels |= batch
            progress.update(len(batch))
            last = task.images[-1]
            if last % IMAGES_PER_SCENE == IMAGES_PER_SCENE - 1 or last == config.images - 1:
                yield last // IMAGES_PER_SCENE, labels
                labels = {}


def _scene_folder(config: RenderDataset, scene_id: int) -> Path:
    return config.out / config.split / f"{scene_id:06d}"
