from dataclasses import asdict, replace

from experiments.commands.config import Compare
from experiments.reporting.data.command_lines import changes, object_of, repeat, replay
from experiments.results.provenance import config_as_json
from experiments.setup.actors import Actors

OPTIONS = config_as_json(asdict(Compare(methods=("none", "maskval"), actors=Actors(gap="fitted"), seed=7)))
OF = {"object": "handle", "method": "maskval", "policy": "threshold"}


def test_a_run_is_repeated_with_the_options_that_are_not_the_defaults() -> None:
    assert repeat(OPTIONS, 3) == "graspcell compare --seed 7 --gap fitted --methods none maskval --experiments 3"


def test_a_replay_names_the_attempt_and_a_policy_that_is_not_the_methods_own() -> None:
    told = "graspcell video --object handle --methods maskval --experiment 12 --attempt 3 --seed 7 --gap fitted"
    assert replay(OPTIONS, OF, 12, 3, own_policy=True) == told
    assert "--policy threshold --experiment 12 --seed 7" in replay(OPTIONS, OF, 12, None, own_policy=False)


def test_a_replay_has_the_threshold_that_was_told_for_its_method_alone() -> None:
    options = {**OPTIONS, "u_grasp": ["maskval=0.3", "none=0.9"]}
    assert replay(options, OF, 0, None, own_policy=True).count("--u-grasp maskval=0.3 ") == 1
    assert "none=0.9" not in replay(options, OF, 0, None, own_policy=True)


def test_a_part_of_ones_own_is_named_by_its_file_and_quoted_for_the_shell() -> None:
    options = {**OPTIONS, "objects": ["my parts/clip.toml", "handle"]}
    assert object_of(options, "clip") == "my parts/clip.toml"
    assert "'my parts/clip.toml'" in replay(options, {**OF, "object": "clip"}, 0, None, own_policy=True)


def test_what_differs_between_two_runs_is_spelled_as_options() -> None:
    other = config_as_json(asdict(replace(Compare(), methods=("none", "maskval"), actors=Actors(gap="fitted"))))
    assert changes(OPTIONS, other) == ["--seed", "7"]
    assert changes(OPTIONS, OPTIONS) == []
