"""What a person is told of an error that ends a command: one line, and the exit code."""

import errno
import re
import traceback
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from experiments.errors import ExperimentsFailedError, UsageError
from sim.errors import GraphicsError

USAGE = 2  # exit code of a wrong argument, of a full disk, or of a machine without OpenGL
_ROOT = Path(__file__).parents[1]
_PACKAGES = ("experiments", "sim", "policies", "cell", "maskval")


def explained(error: BaseException) -> tuple[str, int]:
    """The line and the exit code; an error that nobody thought of is named as such, with its place."""
    match error:
        case UsageError() | GraphicsError():
            return str(error), USAGE
        case ExperimentsFailedError():
            return str(error), 1
        case BrokenProcessPool():
            return "a worker process died (out of memory?)", 1
        case KeyboardInterrupt():
            return "interrupted", 130
        case OSError(errno=errno.ENOSPC | errno.EDQUOT):
            return f"cannot write the results: {error.strerror}", USAGE
    return (
        f"unexpected {type(error).__name__}: {error} ({_place(error)}); graspcell --debug COMMAND shows the traceback",
        1,
    )


def _place(error: BaseException) -> str:
    """File and line where it was raised: the innermost of this package, in a worker process too."""
    worker = str(error.__cause__) if type(error.__cause__).__name__ == "_RemoteTraceback" else ""
    frames = re.findall(r'File "(.+)", line (\d+)', worker)
    frames = frames or [(frame.filename, frame.lineno) for frame in traceback.extract_tb(error.__traceback__)]
    own = [(path.relative_to(_ROOT), line) for name, line in frames if _is_own(path := Path(name))]
    path, line = (own or frames)[-1]
    return f"{path}:{line}"


def _is_own(path: Path) -> bool:
    return path.is_relative_to(_ROOT) and path.relative_to(_ROOT).parts[0] in _PACKAGES
