"""`graspcell video`: an experiment shown again, as a video, a page in 3D or a Rerun file."""

from collections.abc import Sequence

from experiments.errors import UsageError
from experiments.progress import saying
from experiments.setup.checks import FAILED, writable_folder
from experiments.setup.experiment import ExperimentResult
from experiments.video.config import REPLAY, VIDEO, Video
from experiments.video.make import VideoSettings, make_video, span
from experiments.video.shots import Shot
from experiments.viewing.extras import load_rerun, load_viser
from experiments.viewing.recording import write_recording
from experiments.viewing.replay import write_replay

_OPENED_WITH = {".mp4": "a player or a browser", ".html": "a browser", ".rrd": "rerun, which the extra has installed"}


def video(config: Video) -> int:
    """Runs the experiments again and writes what is asked for; returns the exit code.

    Raises:
        UsageError: an invalid argument, an extra is missing, or an experiment does not come to the same again.
    """
    settings, shots = config.settings(), config.shots()
    writable_folder(config.out.parent)
    if config.out.is_dir():
        raise UsageError(f"cannot write {config.out}: expected the path of a video, got a folder")
    if config.out.suffix == VIDEO:
        results = make_video(shots, config.out, settings)
    else:
        results = [_write_3d(shots, config, settings)]
    for result in results:
        if result.failure is not None:
            print(f"failed: {result.spec.part} × {result.spec.method}: {result.failure}")
    print(f"{config.out}: open it with {_OPENED_WITH[config.out.suffix]}")
    return FAILED if any(result.failure is not None for result in results) else 0


def _write_3d(shots: Sequence[Shot], config: Video, settings: VideoSettings) -> ExperimentResult:
    """Writes the page or the recording of one experiment."""
    is_page = config.out.suffix == REPLAY
    (load_viser if is_page else load_rerun)()  # before an experiment has been run in vain
    if len(shots) > 1:
        methods = ", ".join(dict.fromkeys(shot.spec.method for shot in shots))
        raise UsageError(f"expected one of --methods {methods} for {config.out.suffix}, got {len(shots)} experiments")
    with saying("run again"):
        taken = shots[0].take()
    write = write_replay if is_page else write_recording
    interval = settings.speed_up / settings.frames_per_second
    write(taken, config.out, span=span(taken, settings.attempt), interval=interval)
    assert taken.result is not None
    return taken.result
