"""`graspcell video`: moving pictures of an experiment, several methods side by side."""

from experiments.commands.video_config import Video
from experiments.errors import UsageError
from experiments.setup.checks import FAILED, writable_folder
from experiments.video.make import make_video


def video(config: Video) -> int:
    """Runs the experiments again and writes the video; returns the exit code.

    Raises:
        UsageError: an invalid argument, or PyAV is missing.
    """
    specs, settings = config.specs(), config.settings()
    writable_folder(config.out.parent)
    if config.out.is_dir():
        raise UsageError(f"cannot write {config.out}: expected the path of a video, got a folder")
    results = make_video(specs, config.out, settings)
    for result in results:
        if result.failure is not None:
            print(f"failed: {result.spec.part} × {result.spec.method}: {result.failure}")
    print(f"video in {config.out}")
    return FAILED if any(result.failure is not None for result in results) else 0
