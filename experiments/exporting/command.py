"""`graspcell export`: a run in a format of others."""

from experiments.exporting.bop import export_bop
from experiments.exporting.config import Export
from experiments.exporting.lerobot import export_lerobot
from experiments.progress import counted
from experiments.reading.resimulation import Choice, finished
from experiments.results.provenance import manifest, write_json
from experiments.units.run_folder import RunFolder


def export(config: Export) -> int:
    """Simulates the experiments again and writes the dataset; returns the exit code.

    Raises:
        UsageError: an invalid argument, a folder without a run, or an experiment that does not come to the same again.
        GraphicsError: pictures are asked for without OpenGL.
    """
    run = RunFolder.read(config.run)
    choice = Choice(config.objects, config.methods, config.policies, config.experiments)
    specs, pairs = finished(run, choice)
    out = config.out
    shown = counted(pairs, "experiment", total=len(specs))
    if config.bop is not None:
        told = export_bop(out, specs, shown, rgb=config.rgb, depth=config.depth)
    else:
        told = export_lerobot(out, shown, fps=config.fps, rgb=config.rgb)
    write_json(out / "manifest.json", manifest(config))
    print(f"{told} in {out}")
    return 0
