"""`python -m benchmarks.pictures`: where the processor time of a picture of `render-dataset` goes, at 1 sample."""

import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import cv2
import mujoco

from experiments.rendering import command
from experiments.rendering.config import RenderDataset
from sim.images import photo_renderer, pictures, randomization

# Nested stages are set in: their time is part of the one above.
STAGES: tuple[tuple[Any, str, str], ...] = (
    (pictures, "drop", "heap physics"),
    (randomization.SurfaceSampler, "with_surfaces", "surfaces of bodies"),
    (pictures, "room", "walls' pictures"),
    (pictures, "background", "background picture"),
    (photo_renderer, "build", "model of the scene"),
    (photo_renderer.PhotoRenderer, "_nearest", "depth and numbers"),
    (photo_renderer.OpenGLContext, "draw", "OpenGL"),
    (mujoco, "mjr_uploadTexture", "  textures"),
    (mujoco, "mjr_render", "  drawing"),
    (mujoco, "mjr_readPixels", "  waiting for it"),
    (pictures, "paste", "pasting"),
    (pictures, "expose", "blur and noise"),
    (command, "write_picture", "labels and files"),
    (cv2, "imwrite", "  encoding"),
)
IMAGES, VIEWS = 100, 20


def main() -> None:
    spent: Counter[str] = Counter()
    for owner, name, label in STAGES:
        setattr(owner, name, timed(getattr(owner, name), label, spent))
    print(f"ms of processor time per picture, {IMAGES} pictures, --samples 1 --rgb jpg --views-per-heap {VIEWS}")
    for style in sys.argv[1:] or ("s1", "s2"):
        with TemporaryDirectory() as folder:
            config = RenderDataset(
                style=style, object="handle", samples=1, rgb="jpg", views_per_heap=VIEWS, out=Path(folder)
            )
            command.render_batch(command.RenderTask(config, range(VIEWS)))  # opens OpenGL and finds the kernels
            spent.clear()
            begin = time.process_time()
            command.render_batch(command.RenderTask(config, range(VIEWS, VIEWS + IMAGES)))
            total = time.process_time() - begin
        print(f"\n{style:22}{1000 * total / IMAGES:6.1f}")
        for _, _, label in STAGES:
            if label in spent:
                print(f"{label:22}{1000 * spent[label] / IMAGES:6.1f}")


def timed(function: Callable[..., Any], label: str, spent: Counter[str]) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        begin = time.process_time()
        try:
            return function(*args, **kwargs)
        finally:
            spent[label] += time.process_time() - begin  # type: ignore[assignment]

    return call


if __name__ == "__main__":
    main()
