"""`graspcell run`: one experiment, reported step by step."""

from cell.interfaces import Action, Decision
from cell.part import Part, pose_error
from cell.records import AttemptRecord, DecisionRecord, State, TimeSlot, Transition
from experiments.commands.config import Run
from experiments.results.store import LogWriter
from experiments.setup.checks import FAILED, writable_folder
from experiments.setup.experiment import run_experiment
from experiments.setup.options_file import write_manifest
from experiments.viewing.watch import watched
from sim.model.parts import load_part
from sim.networks.ground_truth import LatestTruth

_TOLD = (State.RETREAT, State.REFINE)  # changes of state whose reason says more than their name


def run(config: Run) -> int:
    """Runs the experiment and prints what happens as it happens; returns the exit code.

    Raises:
        UsageError: an invalid argument.
    """
    spec = config.spec()
    folder = None if config.out is None else writable_folder(config.out)
    if config.rerun is not None:
        writable_folder(config.rerun.parent)
    kind, where = load_part(spec.part).part, config.where

    title = (
        f"{spec.part} × {spec.method}, experiment {spec.experiment} of seed {spec.seed}, {spec.estimator} estimators"
    )
    with watched(spec, where, config.rerun, lambda line: print(line, flush=True), title) as shown:

        def tell(record: object, latest_truth: LatestTruth) -> None:
            for line in lines(record, latest_truth, kind):
                print(line, flush=True)
            shown(record, latest_truth)

        result = run_experiment(spec, tell)
    if folder is not None:
        with LogWriter(folder) as logs:
            logs.write(result.tables)
        write_manifest(folder, "run", config, seed=config.seed)
    if result.count is None:
        print(f"failed: {result.failure}")
        return FAILED
    count = result.count
    print(
        f"{count.tp} placed (TP), {count.fp} failed (FP), {count.fn} left on the belt (FN), {count.void} void, "
        f"{count.unreachable} unreachable, {count.timeouts} time-outs, in {count.duration:.1f} s"
    )
    return 0


def lines(record: object, latest_truth: LatestTruth, kind: Part) -> list[str]:
    """The lines printed for a record; errors against the truth are marked as such."""
    match record:
        case DecisionRecord():
            return _seen_lines(record, latest_truth, kind)
        case AttemptRecord():
            cause = f" ({record.contact.force:.0f} N in {record.last_state})" if record.contact else ""
            grasp = f"grasp {record.grasp}" if record.grasp else "no grasp"
            return [f"{record.end:7.2f} s  attempt on detection {record.detection}, {grasp}: {record.outcome}{cause}"]
        case TimeSlot():
            outcome = "time-out" if record.outcome is None else record.outcome
            return [f"{record.end:7.2f} s  time slot {record.index}: {outcome} after {record.end - record.start:.1f} s"]
        case Transition() if record.target in _TOLD or _is_second_thought(record):
            return [f"{record.time:7.2f} s  {record.target}: {record.reason}"]
    return []


def _is_second_thought(change: Transition) -> bool:
    """Whether the decision was already printed: what a second look has changed, or why there is none."""
    return change.target is State.DECIDE and change.source is not State.LOOK


def _seen_lines(seen: DecisionRecord, latest_truth: LatestTruth, kind: Part) -> list[str]:
    observation, decision = seen.observation, seen.decision
    frame = observation.frame
    truth = latest_truth.of(frame)
    what = "second look" if observation.refining else "look"
    told = [f"{frame.time:7.2f} s  {what}, frame {frame.index}: {len(observation.detections)} detections"]
    for index, detection in enumerate(observation.detections):
        part = truth.part_of(detection)
        error = "shows no part"
        if part is not None:
            distance = pose_error(observation.poses[0][index], truth.X_CO_true[part], kind.mesh, kind.symmetries)
            error = f"part {part}, true error {1000 * distance:.1f} mm"
        told.append(
            f"             detection {index}: {int(detection.mask.sum())} px, score {detection.score:.2f}, "
            f"u = {observation.uncertainties[index]:.3f} ({error})"
        )
    told.append(f"             decision: {_in_words(decision)}")
    return told


def _in_words(decision: Decision) -> str:
    if decision.detection is None:
        return decision.action.value
    missed = decision.action is Action.SEARCH
    bound = "" if decision.threshold is None else f", u {'>' if missed else '≤'} {decision.threshold:g}"
    return f"{decision.action}{', best was' if missed else ''} detection {decision.detection}{bound}"
