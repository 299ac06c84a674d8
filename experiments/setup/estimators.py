"""The estimators of an experiment: the simulated ones, a recording, or ones from elsewhere."""

from pathlib import Path

from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from experiments.setup.plugins import check_members, chosen, make_object
from experiments.setup.replay import load_recording
from sim.networks.estimators import Kind
from sim.runtime.episode import Estimators

SIMULATED: tuple[Kind, ...] = ("noisy", "oracle")
KNOWN = (*SIMULATED, "replay")
_NETWORK = ("inference_time", "images")  # what every network states


def check_estimator(name: str, recorded: Path | None) -> None:
    """Raises UsageError unless there is such an estimator, and a recording if and only if it is replayed."""
    chosen("--estimator", name, dict.fromkeys(KNOWN))
    if name == "replay" and recorded is None:
        raise UsageError("--estimator replay: expected --recorded FOLDER, the output of compare or run, got none")
    if recorded is not None and name != "replay":
        raise UsageError(f"--recorded {recorded} is only for --estimator replay, got --estimator {name}")
    if recorded is not None and not recorded.is_dir():
        raise UsageError(f"expected --recorded to be an existing folder, got {recorded}")


def check_not_recorded(out: Path, recorded: Path | None) -> None:
    """Raises UsageError if results in `out` would replace the recording that is replayed, through links too."""
    if recorded is None:
        return
    if out.resolve() in {recorded.resolve(), *(file.resolve().parent for file in recorded.iterdir())}:
        raise UsageError(f"--out {out} would replace the recording in {recorded}: expected another folder")


def choose_estimators(
    name: str, setup: EstimatorSetup, recorded: Path | None, method: str, time_limit: float
) -> Kind | Estimators:
    """What `begin_episode` takes: the name of simulated estimators, or a detector and pose networks.

    Args:
        name: one of `KNOWN`, or `package.module:Class`.
        setup: what estimators from elsewhere are made with.
        recorded: the folder of a recording.
        method: name of the method whose experiment is replayed.
        time_limit: s of the wall clock that making them may take.

    Raises:
        UsageError: they cannot be made, take too long, or lack required members.
    """
    if name in SIMULATED:
        return name
    if name == "replay":
        assert recorded is not None  # `check_estimator` has made sure
        recording = load_recording(recorded, setup, method)
        return recording, recording.networks
    factory = chosen("--estimator", name, {})
    made = make_object(name, factory, ("detector", "pose_estimators"), setup, time_limit=time_limit)
    networks = tuple(made.pose_estimators)
    if not networks:
        raise UsageError(f"{name}: expected at least one of its pose_estimators, got none")
    check_members(f"detector of {name}", made.detector, ("detect", *_NETWORK))
    for network in networks:
        check_members(f"pose_estimators of {name}", network, ("estimate", *_NETWORK))
    return made.detector, networks
