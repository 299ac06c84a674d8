"""The estimators of an experiment: the simulated ones, a recording, or ones from elsewhere."""

from pathlib import Path

from cell.setup import EstimatorSetup
from experiments.errors import UsageError
from experiments.setup.plugins import check_members, chosen, make_object
from experiments.setup.replay import load_recording
from sim.errors import NetworkError
from sim.learned.estimators import learned_estimators
from sim.learned.weights import networks_of
from sim.model.parts import load_part
from sim.networks.estimators import Kind
from sim.runtime.episode import Estimators

SIMULATED: tuple[Kind, ...] = ("noisy", "oracle")
LEARNED = "networks"
KNOWN = (*SIMULATED, LEARNED, "replay")
_NETWORK = ("inference_time", "images")  # what every network states


def check_estimator(name: str, recorded: Path | None, networks: Path | None = None) -> None:
    """Raises UsageError unless there is such an estimator, and a recording if and only if it is replayed."""
    chosen("--estimator", name, dict.fromkeys(KNOWN))
    if name == "replay" and recorded is None:
        raise UsageError("--estimator replay: expected --recorded FOLDER, the output of compare or run, got none")
    if recorded is not None and name != "replay":
        raise UsageError(f"--recorded {recorded} is only for --estimator replay, got --estimator {name}")
    if networks is not None and name != LEARNED:
        raise UsageError(f"--networks {networks} is only for --estimator {LEARNED}, got --estimator {name}")
    if recorded is not None and not recorded.is_dir():
        raise UsageError(f"expected --recorded to be an existing folder, got {recorded}")


def check_networks(folder: Path | None, part: str) -> None:
    """Raises UsageError unless there are networks for a part, which exists."""
    model = load_part(part)
    try:
        learned_estimators(networks_of(model.part.name, folder), model.part)
    except NetworkError as error:
        raise UsageError(f"--estimator {LEARNED}: {error}") from error


def check_not_recorded(out: Path, recorded: Path | None) -> None:
    """Raises UsageError if results in `out` would replace the recording that is replayed, through links too."""
    if recorded is None:
        return
    if out.resolve() in {recorded.resolve(), *(file.resolve().parent for file in recorded.iterdir())}:
        raise UsageError(f"--out {out} would replace the recording in {recorded}: expected another folder")


def choose_estimators(
    name: str,
    setup: EstimatorSetup,
    method: str,
    time_limit: float,
    *,
    recorded: Path | None = None,
    networks: Path | None = None,
) -> Kind | Estimators:
    """What `begin_episode` takes: the name of simulated estimators, or a detector and pose networks.

    Args:
        name: one of `KNOWN`, or `package.module:Class`.
        setup: what estimators from elsewhere are made with.
        method: name of the method whose experiment is replayed.
        time_limit: s of the wall clock that making them may take.
        recorded: the folder of a recording.
        networks: the folder of trained networks; None for those that come along.

    Raises:
        UsageError: they cannot be made, take too long, or lack required members.
    """
    if name in SIMULATED:
        return name
    if name == LEARNED:
        return learned_estimators(networks_of(setup.part.name, networks), setup.part)
    if name == "replay":
        assert recorded is not None  # `check_estimator` has made sure
        recording = load_recording(recorded, setup, method)
        return recording, recording.networks
    factory = chosen("--estimator", name, {})
    made = make_object(name, factory, ("detector", "pose_estimators"), setup, time_limit=time_limit)
    poses = tuple(made.pose_estimators)
    if not poses:
        raise UsageError(f"{name}: expected at least one of its pose_estimators, got none")
    check_members(f"detector of {name}", made.detector, ("detect", *_NETWORK))
    for network in poses:
        check_members(f"pose_estimators of {name}", network, ("estimate", *_NETWORK))
    return made.detector, poses
