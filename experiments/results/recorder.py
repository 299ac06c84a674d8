"""Turns the records of one experiment into rows of the logs, with the truth beside what was believed."""

from dataclasses import dataclass, field
from typing import Any

from cell.interfaces import Frame, Observation
from cell.part import Part, pose_error
from cell.records import AttemptRecord, DecisionRecord, FailedFrame, Tally, TimeSlot, Transition
from maskval import Pose, rle_counts
from sim.networks.ground_truth import FrameTruth, LatestTruth

Row = dict[str, Any]


def pose_row(X_AB: Pose) -> list[float]:
    """Seven numbers: translation (m), then quaternion w, x, y, z."""
    return [*map(float, X_AB.translation), *map(float, X_AB.quaternion_wxyz)]


@dataclass
class Recorder:
    """A listener of the cycle that keeps rows.

    Attributes:
        key: columns that name the experiment, put in front of every row.
        part: the kind of part, for its error against the truth.
        latest_truth: the truth about the newest frame.
        tables: rows by the name of their table.
    """

    key: Row
    part: Part
    latest_truth: LatestTruth
    tables: dict[str, list[Row]] = field(
        default_factory=lambda: {
            name: [] for name in ("experiments", "slots", "transitions", "frames", "estimates", "decisions", "attempts")
        }
    )

    def __call__(self, record: object) -> None:
        """Keeps one record."""
        match record:
            case Transition():
                self._add(
                    "transitions",
                    time_s=record.time,
                    source=record.source.value,
                    target=record.target.value,
                    reason=record.reason,
                )
            case DecisionRecord():
                self._add_seen(record)
            case FailedFrame():
                self._add_frame(record.frame, record.refining, record.observation, record.reason)
            case AttemptRecord():
                self._add_attempt(record)
            case TimeSlot():
                outcome = None if record.outcome is None else record.outcome.value
                self._add("slots", slot=record.index, start_s=record.start, end_s=record.end, outcome=outcome)
            case _:
                raise TypeError(f"a record of unknown kind: {type(record).__name__}")

    def finish(self, seed: int, estimator: str, count: Tally | None, failure: str | None) -> None:
        """Adds the experiment's own row; of an experiment without a result only the reason is kept."""
        counted = (
            {}
            if count is None
            else {
                "parts": count.parts,
                "tp": count.tp,
                "fp": count.fp,
                "fn": count.fn,
                "void": count.void,
                "unreachable": count.unreachable,
                "timeouts": count.timeouts,
                "duration_s": count.duration,
            }
        )
        self._add("experiments", seed=seed, estimator=estimator, failure=failure, **counted)

    def _add(self, table: str, **values: Any) -> None:
        self.tables[table].append({**self.key, **values})

    def _add_seen(self, seen: DecisionRecord) -> None:
        observation, decision = seen.observation, seen.decision
        self._add_frame(observation.frame, observation.refining, observation, None)
        chosen = decision.detection
        self._add(
            "decisions",
            decision=seen.decision_index,
            slot=seen.slot,
            frame=observation.frame.index,
            action=decision.action.value,
            detection=chosen,
            u=None if chosen is None else observation.u(decision, chosen),
            threshold=decision.threshold,
            X_BO_est=None if decision.X_BO_est is None else pose_row(decision.X_BO_est),
            X_BC=None if decision.X_BC is None else pose_row(decision.X_BC),
        )

    def _add_frame(self, frame: Frame, refining: bool, observation: Observation | None, failure: str | None) -> None:
        self._add(
            "frames",
            frame=frame.index,
            time_s=frame.time,
            refining=refining,
            X_BC=pose_row(frame.X_BC),
            inference_s=None if observation is None else observation.inference_time,
            detections=None if observation is None else len(observation.detections),
            failure=failure,
        )
        if observation is not None:
            truth = self.latest_truth.of(frame)
            for index in range(len(observation.detections)):
                self._add("estimates", frame=frame.index, detection=index, **self._estimate(observation, index, truth))

    def _estimate(self, observation: Observation, index: int, truth: FrameTruth) -> Row:
        detection = observation.detections[index]
        poses = [of_estimator[index] for of_estimator in observation.poses]
        part = truth.part_of(detection)
        row: Row = {
            "score": detection.score,
            "mask_rle": rle_counts(detection.mask),
            "u": float(observation.uncertainties[index]),
            "X_CO_est": pose_row(poses[0]),
            "X_CO_est_2": pose_row(poses[1]) if len(poses) > 1 else None,
            "true_part": part,
        }
        if part is not None:
            errors = [pose_error(pose, truth.X_CO_true[part], self.part.mesh, self.part.symmetries) for pose in poses]
            row["true_visibility"] = float(truth.visibility[part])
            row["true_mdd_m"] = errors[0]
            row["true_mdd_2_m"] = errors[1] if len(errors) > 1 else None
        return row

    def _add_attempt(self, attempt: AttemptRecord) -> None:
        contact = attempt.contact
        self._add(
            "attempts",
            attempt=len(self.tables["attempts"]),
            slot=attempt.slot,
            decision=attempt.decision_index,
            frame=attempt.frame,
            detection=attempt.detection,
            u=attempt.u,
            threshold=attempt.threshold,
            X_BO_est=pose_row(attempt.X_BO_est),
            grasp=attempt.grasp,
            container_slot=attempt.container_slot,
            start_s=attempt.start,
            end_s=attempt.end,
            last_state=attempt.last_state.value,
            contact_with=None if contact is None else contact.touch.value,
            contact_force_N=None if contact is None else contact.force,
            contact_time_s=None if contact is None else contact.time,
            outcome=attempt.outcome.value,
        )
