"""Estimators, policies and what fails in them, through compare."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from experiments.setup.experiment import ExperimentSpec, run_experiment
from experiments.setup.methods import known_method
from experiments.setup.policies import make_policy
from experiments.setup.thresholds import load_thresholds
from policies import POLICIES, Fuse, Patient, ThresholdPolicy
from sim.model.parts import load_part
from tests.experiments.command import Told, command, overriding
from tests.experiments.own import folder_with
from tests.fakes import policy_setup, run_cycle

OWN = '''
import time

import numpy as np

from cell.interfaces import Action, Decision, Detection, Image
from maskval import Pose


class Seeing:
    """Sees a square on the belt from the second frame on, and a pose in its middle."""

    inference_time, images = 0.1, frozenset()

    def __init__(self, setup):
        self.setup, self.detector, self.pose_estimators = setup, self, (self, self)

    def detect(self, frame):
        mask = np.zeros((frame.camera.height, frame.camera.width), dtype=bool)
        mask[200:280, 280:360] = True
        return [] if frame.index == 0 else [Detection(mask, 1.0)]

    def estimate(self, frame, detections):
        return [Pose.from_translation((0, 0, 0.6)) for _ in detections]


class Raising(Seeing):
    def estimate(self, frame, detections):
        return [[][len(detections)] for _ in detections]


class Hanging(Seeing):
    def detect(self, frame):
        time.sleep(60 if frame.index == 1 else 0)
        return super().detect(frame)


class Leaving(Seeing):
    def detect(self, frame):
        raise SystemExit("no GPU")


class Garbling(Seeing):
    def estimate(self, frame, detections):
        return [np.eye(4) for _ in detections]


class Unmade(Seeing):
    def __init__(self, setup):
        raise OSError(f"no weights for {setup.part.name}, experiment {setup.experiment}")


class Blind(Seeing):
    def __init__(self, setup):
        self.detector, self.pose_estimators = self, ()


class Deaf:
    def __init__(self, setup):
        self.detector = self.pose_estimators = (setup,)


class Doubting:
    u_grasp = 0.5

    def __call__(self, estimates):
        return 1.5 + np.zeros(len(estimates))


class Halting:
    def __init__(self, setup):
        pass

    def decide(self, observation):
        if observation.frame.index == 1:
            raise RuntimeError("no idea")
        return Decision(Action.SEARCH)


class Stuck(Halting):
    def decide(self, observation):
        while observation.frame.index == 1:
            pass
        return Decision(Action.SEARCH)


class Vague(Halting):
    def decide(self, observation):
        return "grasp it" if observation.frame.index == 1 else Decision(Action.SEARCH)
'''


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    with folder_with(tmp_path, {"own": OWN}, monkeypatch) as folder:
        yield folder


def compared(capsys: pytest.CaptureFixture[str], *arguments: object, jobs: int = 1) -> Told:
    cell = ("--objects", "handle", "--methods", "none", "--experiments", 2, "--parts", 1, "--speed", "fast")
    return command(capsys, "compare", *overriding(*cell, "--jobs", jobs, "--out", "out", *arguments))


def rows(table: str) -> list[dict[str, Any]]:
    read: list[dict[str, Any]] = pq.read_table(Path("out") / f"{table}.parquet").to_pylist()
    return read


FAILING = {  # what is named, which kind of party, and why the experiment failed
    "Raising": ("--estimator", "EstimatorError: Raising on frame 1: raised IndexError: list index out of"),
    "Hanging": ("--estimator", "EstimatorError: Hanging on frame 1: took longer than 1 s"),
    "Leaving": ("--estimator", "EstimatorError: Leaving on frame 0: raised SystemExit: no GPU"),
    "Garbling": (
        "--estimator",
        "EstimatorError: Garbling on frame 1: expected pose 0 to be a maskval.Pose, got ndarray",
    ),
    "Doubting": (
        "--methods",
        "UncertaintyError: Doubting on frame 1: expected 1 uncertainties in [0, 1], got float64 [1.5]",
    ),
    "Halting": ("--policy", "PolicyError: Halting on frame 1: raised RuntimeError: no idea"),
    "Stuck": ("--policy", "PolicyError: Stuck on frame 1: took longer than 1 s"),
    "Vague": ("--policy", "PolicyError: Vague on frame 1: expected a cell.interfaces.Decision, got str"),
}


@pytest.mark.parametrize("name", FAILING)
def test_who_fails_is_reported_by_name_and_frame_and_ends_nothing_but_its_experiments(
    capsys: pytest.CaptureFixture[str], name: str
) -> None:
    option, reason = FAILING[name]
    sees = () if option == "--estimator" else ("--estimator", "own:Seeing")
    told = compared(capsys, option, f"own:{name}", *sees, "--time-limit", 1)
    assert told.code == 3
    for experiment in (0, 1):
        assert f"experiment {experiment}: {reason}" in told.out
    assert [row["failure"].startswith(reason) for row in rows("experiments")] == [True, True]
    last = [row for row in rows("frames") if row["experiment"] == 1][-1]
    assert f"on frame {last['frame']}" in reason
    assert last["failure"] in rows("experiments")[1]["failure"]
    assert (last["detections"] is None) == (option != "--policy")
    assert [row["frame"] for row in rows("decisions") if row["experiment"] == 1] == list(range(last["frame"]))


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Unmade", "own:Unmade: called with (EstimatorSetup), it raised OSError: no weights for handle, experiment 0"),
        ("Blind", "own:Blind: expected at least one of its pose_estimators, got none"),
        ("Deaf", "detector of own:Deaf: expected an object with detect, inference_time, images; tuple lacks detect"),
        ("Halting", "own:Halting: expected an object with detector, pose_estimators; Halting lacks detector"),
    ],
)
def test_estimators_that_cannot_be_made_fail_their_experiment_with_the_reason(name: str, reason: str) -> None:
    spec = ExperimentSpec("handle", "none", f"own:{name}", load_thresholds("paper"), "fast", 1, 5, 0)
    result = run_experiment(spec)
    assert (result.count, (result.failure or "").startswith(f"UsageError: {reason}")) == (None, True), result.failure


def test_workers_find_modules_of_the_current_folder_and_outlive_one_that_hangs(
    capsys: pytest.CaptureFixture[str],
) -> None:
    told = compared(capsys, "--estimator", "own:Hanging", "--time-limit", 1, jobs=2)
    assert told.code == 3
    assert told.out.count("Hanging on frame 1: took longer than 1 s") == 2


def test_estimators_from_elsewhere_see_for_the_robot(capsys: pytest.CaptureFixture[str]) -> None:
    assert compared(capsys, "--estimator", "own:Seeing", "--experiments", 1).code == 0
    (experiment,) = rows("experiments")
    assert (experiment["estimator"], experiment["policy"]) == ("own:Seeing", "always")
    frame = rows("frames")[1]
    estimate = rows("estimates")[0]
    assert (frame["frame"], frame["detections"], estimate["frame"]) == (1, 1, 1)
    assert estimate["X_CO_est"] == [0, 0, 0.6, 1, 0, 0, 0]
    looked = [row["time_s"] for row in rows("transitions") if row["target"] == "decide"]
    assert looked[1] - frame["time_s"] == pytest.approx(0.1 + 0.1)  # the detector and one network


def test_run_tells_which_bound_was_missed_when_the_search_goes_on(capsys: pytest.CaptureFixture[str]) -> None:
    cell = ("--object", "handle", "--method", "maskval", "--parts", 1, "--speed", "fast")
    told = command(capsys, "run", *cell, "--estimator", "own:Seeing", "--out", "out")
    assert told.code == 0
    assert "decision: search\n" in told.out  # nothing is seen in the first frame
    assert "decision: search, best was detection 0, u > 0.6\n" in told.out
    first, second = rows("decisions")[:2]
    assert [first[name] for name in ("detection", "u", "threshold")] == 3 * [None]
    assert (second["action"], second["detection"], second["threshold"]) == ("search", 0, 0.6)
    assert second["u"] > 0.6


def test_a_policy_is_made_anew_for_every_experiment_and_the_methods_own_is_the_default() -> None:
    thresholds = load_thresholds("paper")
    handle, setup = load_part("handle").part, policy_setup()
    method = known_method("maskval", handle, thresholds)
    made = [make_policy("patient", method, setup.part, setup.layout, thresholds.refine) for _ in range(2)]
    assert all(isinstance(policy, Patient) for policy in made)
    assert made[0] is not made[1]
    assert make_policy(None, method, setup.part, setup.layout, 0.6) == ThresholdPolicy(0.55, 0.6)
    assert make_policy("threshold", method, setup.part, setup.layout, 0.9) == ThresholdPolicy(0.55, 0.6)
    unsure = known_method("none", handle, thresholds)
    assert make_policy("threshold", unsure, setup.part, setup.layout, 0.9) == ThresholdPolicy(0.0, 0.9)


@pytest.mark.parametrize("name", POLICIES)
def test_every_policy_of_the_package_runs_an_experiment(name: str) -> None:
    experiment = run_cycle(POLICIES[name](policy_setup()), u=[0.5, 0.4, 0.1])
    assert experiment.count.tp == 1
    assert isinstance(experiment.attempts[0].u, float)


def test_the_logs_of_a_policy_that_averages_have_the_pose_and_u_it_acted_upon(
    capsys: pytest.CaptureFixture[str],
) -> None:
    arguments = ("--methods", "maskval", "--experiments", 1, "--parts", 4, "--policy", "fuse", "--seed", 5)
    told = compared(capsys, *arguments)
    assert (told.code, told.out.splitlines()[0]) == (0, "policy: fuse")
    assert {row["policy"] for row in rows("experiments")} == {"fuse"}
    attempts = rows("attempts")
    assert attempts
    for attempt in attempts:
        (decision,) = (row for row in rows("decisions") if row["decision"] == attempt["decision"])
        assert attempt["X_BO_est"] == decision["X_BO_est"]
        assert attempt["u"] == decision["u"] <= attempt["threshold"]
    own = {(row["frame"], row["detection"]): row["u"] for row in rows("estimates")}
    fused = [row for row in attempts if row["u"] != own[row["frame"], row["detection"]]]
    assert fused, "no part was seen twice"
    assert isinstance(POLICIES["fuse"](policy_setup()), Fuse)
    assert np.isfinite([row["X_BO_est"] for row in fused]).all()
