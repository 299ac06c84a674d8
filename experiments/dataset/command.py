"""`graspcell dataset`: the paper's dataset tables, on test images made here."""

from collections.abc import Iterator
from contextlib import closing

from experiments.dataset.batch import BatchTask, Judged, run_batch
from experiments.dataset.coco import Matches
from experiments.dataset.config import Dataset
from experiments.dataset.metrics import Figures
from experiments.dataset.report import format_alternatives, format_tables
from experiments.dataset.score import Scored, alternatives, score
from experiments.dataset.thresholds import thresholds_toml
from experiments.progress import bar
from experiments.results.files import write_text
from experiments.results.provenance import write_json
from experiments.setup.checks import writable_folder
from experiments.setup.options_file import write_manifest
from experiments.setup.pool import run_all
from sim.images.generated import Recipe
from sim.model.parts import load_part


def dataset(config: Dataset) -> int:
    """Makes and judges all images, prints the tables and writes the results; returns the exit code.

    Raises:
        UsageError: an invalid argument.
        BrokenProcessPool: a worker died; nothing is written.
    """
    config.check()
    folder = writable_folder(config.out)
    sets: list[Scored] = []
    others: dict[str, dict[str, dict[str, Figures]]] = {}
    for part, judged, matches in _judged_sets(config):
        name = load_part(part).part.name
        sets.append(score(name, judged, matches, config.rules, seed=config.seed, resamples=config.resamples))
        if config.alternatives:
            others[name] = alternatives(judged)
    write_json(folder / "dataset.json", {"objects": [one.as_json() for one in sets]})
    write_text(folder / "thresholds.toml", thresholds_toml(sets, config.command))
    write_manifest(folder, "dataset", config, seed=config.seed, recipe=Recipe())
    if config.figures:
        from experiments.dataset.figures import draw_curves, draw_errors  # noqa: PLC0415  # needs an extra

        draw_curves(sets, folder / "curves.png")
        draw_errors(sets, folder / "errors.png")
    print(format_tables(sets))
    if others:
        print(format_alternatives(others))
    print(f"results in {folder}")
    return 0


def _judged_sets(config: Dataset) -> Iterator[tuple[str, Judged, Matches]]:
    """Each part with its judged set."""
    batches = config.batches
    pictures = {part: config.picture_set(load_part(part).part.name) for part in config.objects}
    tasks = [
        BatchTask(part, config.seed, batch, config.annotated_visibility, config.named_methods, pictures[part])
        for part in config.objects
        for batch in batches
    ]
    with (
        bar("image", total=len(config.objects) * config.images) as progress,
        closing(run_all(run_batch, tasks, config.workers)) as stream,
    ):
        for part in config.objects:
            runs = []
            for batch, run in zip(batches, stream, strict=False):
                runs.append(run)
                progress.update(len(batch))
            yield part, Judged.join([judged for judged, _ in runs]), Matches.join([matches for _, matches in runs])
