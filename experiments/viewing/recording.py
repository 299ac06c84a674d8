"""An experiment as a file for the Rerun viewer: bodies, camera, pictures, masks, poses, u and decisions over time."""

import shutil
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from cell.records import DecisionRecord
from experiments.observing.drawing import MASK, MODEL
from experiments.observing.looks import Looks
from experiments.observing.take import Take
from experiments.observing.words import in_words, named
from experiments.progress import counted
from experiments.results.files import replacing
from experiments.viewing.extras import load_rerun
from experiments.viewing.layout import faceted, layout, log_colours
from experiments.viewing.moments import moments
from sim.runtime.bodies import Bodies

TIMELINE = "cell"  # s of the cell's clock
_QUALITY = 85  # of JPEG
_FRUSTUM = 0.12  # m: how far in front of the camera its picture is drawn


def write_recording(taken: Take, path: Path, *, span: tuple[float, float], interval: float) -> None:
    """Writes the file.

    Args:
        taken: the experiment.
        path: the file.
        span: begin and end of what is shown, s of the cell's clock.
        interval: between two poses of a body, s.

    Raises:
        UsageError: rerun-sdk is missing, or the file cannot be written.
        GraphicsError: there is no off-screen OpenGL for the pictures.
    """
    rerun = load_rerun()
    stream = rerun.RecordingStream("graspcell", recording_id=path.stem)
    with TemporaryDirectory() as folder:
        made = Path(folder) / "made.rrd"
        stream.save(made, default_blueprint=layout(rerun, TIMELINE))
        spec = taken.spec
        stream.send_recording_name(f"{taken.part.name} × {spec.method}, experiment {spec.experiment}")
        with closing(Looks(taken.world)) as looks:
            _Recording(rerun, stream, taken, span).write(looks, interval)
        stream.flush()
        stream.disconnect()
        with replacing(path) as file, made.open("rb") as content:
            shutil.copyfileobj(content, file)


class _Recording:
    def __init__(self, rerun: Any, stream: Any, taken: Take, span: tuple[float, float]) -> None:
        self._rerun, self._stream, self._taken, self._span = rerun, stream, taken, span
        self._drawn = 0  # estimates of the look before

    def write(self, looks: Looks, interval: float) -> None:
        self._stream.log("world", self._rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        log_colours(self._rerun, self._stream)
        self._log_bodies(interval)
        begin, end = self._span
        for decided in counted(self._taken.observer.decisions(), "look", "recording"):
            if begin - 1e-6 <= decided.observation.frame.time <= end + 1e-6:
                self._log_look(decided, looks)
        self._log_words()

    def _log_bodies(self, interval: float) -> None:
        """Shapes once, and where each body is at equal times."""
        rerun, stream, bodies = self._rerun, self._stream, Bodies(self._taken.world)
        for number, shape in enumerate(bodies.shapes):
            corners, normals = faceted(shape.vertices, shape.faces)
            mesh = rerun.Mesh3D(vertex_positions=corners, vertex_normals=normals, albedo_factor=[*shape.rgb, 255])
            stream.log(f"world/{shape.body}/{number}", mesh, static=True)
        times = moments(self._span, interval)
        found = [bodies.at(self._taken.film.at(time)) for time in times]
        tracks = {name: np.array([places[name] for places, _ in found]) for name in found[0][0]}
        tracks["wrist"] = np.array([[*X_WC.translation, *X_WC.quaternion_wxyz] for _, X_WC in found])
        clock = rerun.TimeColumn(TIMELINE, duration=np.array(times))
        for name, track in tracks.items():
            columns = rerun.Transform3D.columns(translation=track[:, :3], quaternion=track[:, [4, 5, 6, 3]])
            stream.send_columns(f"world/{name}", indexes=[clock], columns=columns)

    def _log_look(self, decided: DecisionRecord, looks: Looks) -> None:
        """The camera as the robot believes it, its picture, the masks, the model at each estimated pose, and u."""
        rerun, stream, taken, observation = self._rerun, self._stream, self._taken, decided.observation
        frame = observation.frame
        stream.set_time(TIMELINE, duration=frame.time)
        X_WC = taken.world.layout.X_WB @ frame.X_BC
        stream.log("world/look", self._pose(X_WC.translation, X_WC.quaternion_wxyz))
        camera = frame.camera
        lens = rerun.Pinhole(
            image_from_camera=camera.K, width=camera.width, height=camera.height, image_plane_distance=_FRUSTUM
        )
        stream.log("world/look/camera", lens)
        positions = taken.film.at(frame.time)
        stream.log("world/look/camera/picture", rerun.Image(looks.picture(positions)).compress(jpeg_quality=_QUALITY))
        stream.log("look", rerun.Image(looks.overlaid(decided, positions)).compress(jpeg_quality=_QUALITY))
        numbered = np.zeros((camera.height, camera.width), np.uint8)
        for index, detection in enumerate(observation.detections):
            numbered[detection.mask] = index + 1
        stream.log("world/look/camera/masks", rerun.SegmentationImage(numbered))
        self._log_estimates(decided)
        chosen = decided.decision.detection
        if chosen is not None:
            stream.log("u/decided", rerun.Scalars(observation.u(decided.decision, chosen)))
            if decided.decision.threshold is not None:
                stream.log("u/threshold", rerun.Scalars(decided.decision.threshold))

    def _log_estimates(self, decided: DecisionRecord) -> None:
        rerun, stream, taken, observation = self._rerun, self._stream, self._taken, decided.observation
        mesh, X_WC = taken.part.mesh, taken.world.layout.X_WB @ observation.frame.X_BC
        for index, X_CO in enumerate(observation.poses[0]):
            name, X_WO = f"world/estimated/{index}", X_WC @ X_CO
            color = MODEL if index == decided.decision.detection else MASK
            stream.log(name, self._pose(X_WO.translation, X_WO.quaternion_wxyz))
            stream.log(
                f"{name}/model",
                rerun.Mesh3D(vertex_positions=mesh.vertices, triangle_indices=mesh.faces, albedo_factor=[*color, 128]),
            )
        for index in range(len(observation.poses[0]), self._drawn):
            stream.log(f"world/estimated/{index}", rerun.Clear(recursive=True))
        self._drawn = len(observation.poses[0])

    def _log_words(self) -> None:
        """Changes of state, decisions, attempts and time slots, in words."""
        begin, end = self._span
        before = None
        for now in self._taken.observer.history:
            told = []
            if before is None or now.state != before.state:
                told.append(f"{now.state}: {now.reason}" if now.reason else f"{now.state}")
            if now.decided is not None and (before is None or now.decided is not before.decided):
                told.append(in_words(now.decided))
            if now.attempt is not None and (before is None or now.attempt is not before.attempt):
                told.append(f"attempt: {now.attempt.outcome}")
            if before is not None and len(now.slots) > len(before.slots):
                told.append(f"time slot {len(before.slots)}: {named(now.slots[-1])}")
            before = now
            if begin - 1e-6 <= now.time <= end + 1e-6:
                self._stream.set_time(TIMELINE, duration=now.time)
                for line in told:
                    self._stream.log("decisions", self._rerun.TextLog(line))

    def _pose(self, translation: Any, wxyz: Any) -> Any:
        return self._rerun.Transform3D(translation=translation, quaternion=np.roll(wxyz, -1))
