"""Where numbers come from: versions, commit, configuration and seed, written beside every result."""

import json
import platform
import subprocess
from dataclasses import asdict, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from experiments.results.files import write_text

_PACKAGES = (
    "graspcell",
    "mujoco",
    "numpy",
    "numba",
    "scipy",
    "opencv-python-headless",
    "ruckig",
    "trimesh",
    "pyarrow",
    "pycocotools",
)


def manifest(config: object) -> dict[str, Any]:
    """Versions, commit and configuration of a run; `dirty` says that the working tree differed from the commit."""
    commit = _git("rev-parse", "HEAD")
    return {
        "versions": {"python": platform.python_version(), **{package: version(package) for package in _PACKAGES}},
        "platform": f"{platform.system()} {platform.machine()}",
        "commit": commit,
        "dirty": None if commit is None else bool(_git("status", "--porcelain", "--untracked-files=no")),
        "config": config_as_json(config),
    }


def config_as_json(config: object) -> Any:
    """A command's options as JSON has them."""
    return json.loads(json.dumps(config, default=_plain))


def write_json(path: Path, content: object) -> None:
    """Writes UTF-8 JSON with a final newline; refuses NaN, which JSON does not know.

    Raises:
        UsageError: it cannot be written.
    """
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False, default=_plain) + "\n")


def _plain(value: object) -> Any:
    """Records as objects, paths as text."""
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else str(value)


def _git(*arguments: str) -> str | None:
    """Git's answer about the folder of this source; None outside of a checkout or without git."""
    here = Path(__file__).parent
    try:
        answer = subprocess.run(["git", "-C", str(here), *arguments], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return answer.stdout.strip()
