"""`graspcell part`: a part of the user's own from a mesh, or a check of part files."""

from collections.abc import Sequence
from pathlib import Path

from cell.layout import Layout
from experiments.errors import UsageError
from experiments.part.config import MakePart
from experiments.part.draft import draft_of
from experiments.part.files import Draft, write_meshes, write_part
from experiments.part.noise import scaled_noise
from experiments.part.report import check_lines, next_lines, report_lines
from experiments.part.search import GraspSearch
from experiments.part.trials import Tried, try_grasps
from experiments.progress import counted
from experiments.results.files import write_text
from experiments.setup.checks import FAILED, writable_folder
from experiments.setup.options_file import write_manifest
from maskval import Mesh
from sim.errors import SimError

ROUNDS = 3  # of trials: grasps that do not hold are replaced twice
HOLDS = 0.75  # share of trials that a grasp must hold to stay


def part(config: MakePart) -> int:
    """Makes the part or checks the files; returns the exit code.

    Raises:
        UsageError: an invalid argument, or a mesh that no part can be made from.
    """
    config.refuse_invalid()
    if config.check:
        return _check(config.check)
    try:
        return _make(config)
    except SimError as error:
        raise UsageError(str(error)) from error


def _check(paths: Sequence[Path]) -> int:
    wrong = False
    for path in paths:
        lines, refused = check_lines(path)
        print("\n".join(lines))
        wrong |= refused
    return FAILED if wrong else 0


def _make(config: MakePart) -> int:
    draft = draft_of(config, tell=lambda line: print(line, flush=True))
    folder = writable_folder(config.out or Path("out/parts") / draft.name)
    if config.preview:
        from experiments.dataset.figures import check_matplotlib  # noqa: PLC0415  # an extra

        check_matplotlib()
    search = GraspSearch(draft, Layout(), config.seed)
    draft = search.chosen()
    if not draft.chosen:
        print("\n".join(report_lines(draft, [])))
        print("no part was written: this gripper holds it in none of its stable poses")
        return FAILED
    mesh = Mesh(draft.mesh.vertices, draft.mesh.faces)
    write_text(folder / "noise.toml", scaled_noise(draft.name, mesh, draft.turns))
    write_meshes(folder, draft)
    draft, tried = _tried(config, folder, draft, search)
    path = write_part(folder, draft, tried)
    write_manifest(folder, "part", config, skip=("mesh", "check"), seed=config.seed)
    print("\n".join(report_lines(draft, tried)))
    if config.preview:
        from experiments.part.preview import draw_preview  # noqa: PLC0415  # an extra

        draw_preview(draft, folder / "preview.png")
    print("\n".join(next_lines(path, draft)))
    return 0


def _tried(config: MakePart, folder: Path, draft: Draft, search: GraspSearch) -> tuple[Draft, list[Tried]]:
    """The part with grasps that hold: those that do not are replaced, and what replaces them is tried again."""
    tried: list[Tried] = []
    slots = max(1, draft.slot.reached)
    for left in reversed(range(ROUNDS if config.trials else 0)):
        path = write_part(folder, draft, [])
        uses = [(number, pose) for number, one in enumerate(draft.chosen) for pose in one.poses]
        outcomes = try_grasps(str(path), uses, slots=slots, trials=config.trials, seed=config.seed, jobs=config.workers)
        tried = list(counted(outcomes, "grasp", total=len(uses)))
        failed = [(draft.chosen[one.grasp], one.pose) for one in tried if one.held < HOLDS * one.trials]
        better = search.without(failed) if failed and left else None
        if better is None:
            break
        draft = better
    return draft, tried
