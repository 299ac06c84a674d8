"""A run as a BOP dataset: a scene per experiment with frames and truth, and the results of each method."""

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from cell.interfaces import Frame
from cell.layout import default_camera
from cell.records import DecisionRecord, FailedFrame
from experiments.exporting.frame_camera import FrameCamera
from experiments.reading.resimulation import resimulate
from experiments.rendering.files import (
    DEPTH_SCALE,
    Labels,
    targets,
    write_models,
    write_parts,
    write_rgb,
    write_scene,
)
from experiments.results.provenance import write_json
from experiments.setup.experiment import ExperimentSpec, kept_cell
from experiments.units.unit import Unit
from maskval import Camera, Pose, bop
from sim.model.parts import load_part
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.runtime.episode import SimCell

SPLIT = "test"
_UNSAFE = re.compile(r"[^A-Za-z0-9.+-]")  # of a name, in BOP's name of a results file, which an underscore divides
_UNKNOWN_TIME = -1.0  # BOP's


def export_bop(
    out: Path, specs: Sequence[ExperimentSpec], pairs: Iterable[tuple[ExperimentSpec, Unit]], *, rgb: bool, depth: bool
) -> str:
    """Writes the dataset; returns what it holds, in words.

    Args:
        out: an empty folder.
        specs: the experiments.
        pairs: the same in the same order, each with its unit.
        rgb: whether to write pictures.
        depth: whether to write depth images.

    Raises:
        UsageError: an experiment does not come to the same again; the dataset is then not complete.
        GraphicsError: pictures are asked for without OpenGL.
    """
    models = {spec.part: load_part(spec.part) for spec in specs}
    numbers = {model.part.name: number for number, model in enumerate(models.values(), start=1)}
    camera = default_camera()
    write_models(out, {numbers[model.part.name]: model for model in models.values()}, camera)
    results, scenes, asked, frames = _Results(camera), [], [], 0
    for scene_id, (spec, unit) in enumerate(pairs):
        of = unit.description["of"]
        number = numbers[of["object"]]
        scene = _Scene(out / SPLIT / f"{scene_id:06d}", number)
        scene.write(spec, unit, rgb=rgb, depth=depth)
        asked += targets(scene_id, scene.labels, number=number)
        results.add(scene_id, number, unit)
        named = {name: of[name] for name in ("object", "method", "policy")}
        scenes.append({"scene_id": scene_id, **named, "experiment": spec.experiment, "parts": scene.parts})
        frames += len(scene.labels)
    bop.write_targets(out / f"{SPLIT}_targets_bop19.json", asked)
    results.write(out / "results")
    write_json(out / "scenes.json", scenes)
    return f"{len(scenes)} scenes with {frames} frames"


class _Scene:
    """A scene that is being written.

    Attributes:
        labels: what BOP's files say of each frame.
        parts: of each frame, the numbers in the experiment of the parts that BOP's files list.
    """

    def __init__(self, folder: Path, number: int) -> None:
        self._folder, self._number = folder, number
        self.labels: dict[int, Labels] = {}
        self.parts: dict[int, list[int]] = {}

    def write(self, spec: ExperimentSpec, unit: Unit, *, rgb: bool, depth: bool) -> None:
        """Simulates the experiment again and writes its frames."""
        for name in ["rgb"] * rgb + ["depth"] * depth:
            (self._folder / name).mkdir(parents=True)
        world = kept_cell(*spec.cell).world
        with closing(FrameCamera(world, rgb=rgb, depth=depth)) as camera:

            def tell(record: object, latest_truth: LatestTruth) -> None:
                match record:
                    case DecisionRecord():
                        frame = record.observation.frame
                    case FailedFrame():
                        frame = record.frame
                    case _:
                        return
                self._write_frame(frame, latest_truth.of(frame), camera)

            resimulate(spec, unit, tell, SimCell(world, camera))
        write_scene(self._folder, self.labels)

    def _write_frame(self, frame: Frame, truth: FrameTruth, camera: FrameCamera) -> None:
        taken, name = camera.newest, f"{frame.index:06d}.png"
        if taken.rgb is not None:
            write_rgb(self._folder / "rgb" / name, taken.rgb)
        if taken.depth is not None:
            bop.write_depth(self._folder / "depth" / name, taken.depth, DEPTH_SCALE)
        measured = np.zeros_like(truth.instance_ids, bool) if taken.depth is None else taken.depth > 0
        shown = truth.visible_parts()
        labelled = write_parts(self._folder, frame.index, truth, shown, number=self._number, measured=measured)
        believed = bop.ImageCamera(frame.camera.K, DEPTH_SCALE, taken.X_WC.inverse())
        self.labels[frame.index], self.parts[frame.index] = Labels(believed, *labelled), shown


class _Results:
    """The detections and poses of each method and policy, from the tables."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._masks: dict[str, list[bop.DetectionResult]] = defaultdict(list)
        self._poses: dict[str, list[bop.PoseResult]] = defaultdict(list)

    def add(self, scene_id: int, number: int, unit: Unit) -> None:
        """Adds those of an experiment."""
        of = unit.description["of"]
        name = _UNSAFE.sub("-", f"{of['method']}+{of['policy']}")
        times = {row["frame"]: row["inference_s"] for row in unit.tables["frames"]}
        for row in unit.tables["estimates"]:
            time = times[row["frame"]]
            ids = scene_id, row["frame"], number
            seconds = _UNKNOWN_TIME if time is None else time
            size = self._camera.height, self._camera.width
            self._masks[name].append(bop.DetectionResult(*ids, row["score"], tuple(row["mask_rle"]), *size, seconds))
            for column, network in (("X_CO_est", name), ("X_CO_est_2", f"{name}+second")):
                if row[column] is not None:
                    self._poses[network].append(bop.PoseResult(*ids, 1.0 - row["u"], _pose(row[column]), seconds))

    def write(self, folder: Path) -> None:
        """Writes a file of masks for each method, and one of poses for each of its networks."""
        folder.mkdir()
        for name, masks in self._masks.items():
            bop.write_detections(folder / f"{name}_graspcell-{SPLIT}.json", masks)
        for name, poses in self._poses.items():
            bop.write_results(folder / f"{name}_graspcell-{SPLIT}.csv", poses)


def _pose(numbers: Sequence[Any]) -> Pose:
    return Pose.from_quaternion_wxyz(numbers[3:], numbers[:3])
