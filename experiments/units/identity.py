"""What decides an experiment's result, spelled out, and the name that follows from it."""

# ruff: noqa: PLC0415  # the engine is loaded to describe an experiment: reading units does not wait for it

import hashlib
import json
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from functools import cache
from importlib import import_module
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.errors import UsageError
from maskval import InvalidFileError
from maskval.inputs.files import MOST_RESULTS, read_input

if TYPE_CHECKING:
    from experiments.setup.experiment import ExperimentSpec

LIBRARIES = ("mujoco", "numpy", "numba", "scipy", "opencv-python-headless", "ruckig", "trimesh")
_NETWORK_FILES = (".onnx", ".json")
_ROOT = Path(__file__).parents[2]
_DECIDING = ("maskval", "cell", "sim", "policies", "experiments/setup", "experiments/results")

Description = dict[str, Any]


def describe(spec: "ExperimentSpec") -> Description:
    """Everything that decides the experiment's result, as JSON has it: names, numbers and digests of files.

    `of` is what a cell of the table is about, `cell` what belongs to that cell alone, `common` what every experiment
    of one comparison shares, `experiment` its number, and `noise` its error model.
    """
    from experiments.setup.methods import known_method
    from experiments.setup.policies import policy_name
    from policies import ThresholdPolicy
    from sim.model.parts import load_part

    part = load_part(spec.part).part
    own = known_method(spec.method, part, spec.thresholds).policy
    u_grasp = own.u_grasp if isinstance(own, ThresholdPolicy) else None
    description = {
        "of": {
            "object": part.name,
            "method": spec.method,
            "policy": policy_name(spec.policy, spec.method),
        },
        "cell": {
            "own_policy": spec.policy is None,
            "part": part_digest(spec.part),
            "u_grasp": u_grasp,
            "caveat": None if u_grasp is None else spec.thresholds.caveat(part.name, spec.method),
            "ensemble_add_minimum_m": spec.thresholds.ensemble_add_minimum.get(part.name),
            "plug_ins": _plug_ins((spec.method, spec.policy)),
        },
        "common": {
            "versions": versions(),
            "seed": spec.seed,
            "parts": spec.parts,
            "speed": spec.speed,
            "estimator": spec.estimator,
            "estimator_plug_in": _plug_ins((spec.estimator,)),
            "recorded": None if spec.recorded is None else _digest(_contents(spec.recorded)),
            "networks": _networks(spec),
            "u_refine": spec.thresholds.refine,
            "conditions": asdict(spec.conditions),
            "refine_distance": spec.refine_distance,
            "fresh_look": spec.fresh_look,
            "time_limit": spec.time_limit,
        },
        "noise": spec.noise,
        "experiment": spec.experiment,
    }
    as_json: Description = json.loads(canonical(description))
    return as_json


def _networks(spec: "ExperimentSpec") -> str | None:
    """The digest of the trained networks that are used; None without such."""
    from sim.learned.weights import networks_of
    from sim.model.parts import load_part

    if spec.estimator != "networks":
        return None
    folder = networks_of(load_part(spec.part).part.name, spec.networks).folder
    return _digest((file.name, file.read_bytes()) for file in sorted(folder.iterdir()) if file.suffix in _NETWORK_FILES)


def unit_name(description: Mapping[str, Any]) -> str:
    """The hash of a description: 32 hexadecimal digits."""
    return hashlib.sha256(canonical(description)).hexdigest()[:32]


def canonical(content: object) -> bytes:
    """JSON in one spelling: equal content has equal bytes."""
    return json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode("utf-8")


def differences(one: Mapping[str, Any], other: Mapping[str, Any], prefix: str = "") -> list[str]:
    """What differs between two descriptions, a line per value: `conditions.light: 1.0, here 0.5`."""
    lines = []
    for key in sorted(one.keys() | other.keys()):
        a, b = one.get(key), other.get(key)
        if isinstance(a, Mapping) and isinstance(b, Mapping):
            lines += differences(a, b, f"{prefix}{key}.")
        elif a != b:
            lines.append(f"{prefix}{key}: {a} there, {b} here")
    return lines


@cache
def versions() -> dict[str, str]:
    """Versions of this package and of the libraries that decide numbers, and a digest of the code itself."""
    return {
        "graspcell": version("graspcell"),
        "code": _digest(
            (str(file.relative_to(_ROOT).as_posix()), file.read_bytes())
            for folder in _DECIDING
            for file in sorted((_ROOT / folder).rglob("*.py"))
        ),
        **{library: version(library) for library in LIBRARIES},
    }


@cache
def part_digest(part: str) -> str:
    """A digest of the files that a part is made from: its TOML file, its meshes and its error model."""
    from sim.model.parts import load_part

    own = part.endswith(".toml")
    text = (Path(part) if own else files("sim") / "assets" / "parts" / f"{part}.toml").read_bytes()
    mesh = tomllib.loads(text.decode("utf-8"))["mesh"]
    names = [mesh["file"], *mesh.get("pieces", ())] if "file" in mesh else []
    noise = load_part(part).noise
    model = Path(noise) if noise.endswith(".toml") else files("sim") / "assets" / "noise" / f"{noise}.toml"
    meshes = [(name, (Path(part).parent / name).read_bytes()) for name in names]
    return _digest([("part", text), *meshes, ("noise", model.read_bytes())])


def _plug_ins(names: Iterable[str | None]) -> dict[str, str]:
    """A digest of the source of each name that is `package.module:Class`."""
    return {name: _source_digest(name.partition(":")[0]) for name in names if name is not None and ":" in name}


def _source_digest(module: str) -> str:
    """Of the module's file; of a package's module, of all Python files of the package."""
    top = import_module(module.partition(".")[0])
    if hasattr(top, "__path__"):
        roots = [Path(root) for root in top.__path__]
        found = [(file.relative_to(root).as_posix(), file) for root in roots for file in sorted(root.rglob("*.py"))]
        return _digest((name, file.read_bytes()) for name, file in found)
    return _digest([(module, Path(str(top.__file__)).read_bytes())])


def _contents(folder: Path) -> Iterable[tuple[str, bytes]]:
    """The files of a recording, those that nobody reads left out.

    Raises:
        UsageError: one is no regular file, too large, or cannot be read.
    """
    kept = ("frames.parquet", "estimates.parquet", "masks.json", "poses.csv", "poses_2.csv")
    try:
        return [(name, read_input(folder / name, MOST_RESULTS)) for name in kept if (folder / name).exists()]
    except InvalidFileError as error:
        raise UsageError(str(error)) from error


def _digest(contents: Iterable[tuple[str, bytes]]) -> str:
    total = hashlib.sha256()
    for name, content in contents:
        total.update(f"{name}\0{len(content)}\0".encode() + content)
    return total.hexdigest()[:16]
