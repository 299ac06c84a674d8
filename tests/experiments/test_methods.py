from dataclasses import replace

import pytest

from experiments.errors import UsageError
from experiments.methods import METHODS, make_method
from experiments.thresholds import load_thresholds
from maskval import EnsembleAdd, MaskVal, NoUncertainty
from policies import Always, Threshold

PAPER = load_thresholds("paper")


def test_the_methods_are_those_of_the_papers_robot_table() -> None:
    assert list(METHODS) == ["none", "ensemble-add", "maskval"]


def test_none_grasps_whatever_is_seen() -> None:
    method = make_method("none", "antenna", PAPER)
    assert isinstance(method.uncertainty, NoUncertainty)
    assert method.policy == Always()


def test_none_needs_no_threshold() -> None:
    assert make_method("none", "mug", PAPER).policy == Always()


def test_maskval_decides_with_the_two_thresholds_of_its_object() -> None:
    method = make_method("maskval", "handle", PAPER)
    assert isinstance(method.uncertainty, MaskVal)
    assert method.policy == Threshold(u_grasp=0.55, u_refine=0.6)


def test_ensemble_add_decides_with_its_thresholds_on_a_scale_that_begins_at_its_minimum() -> None:
    method = make_method("ensemble-add", "antenna", replace(PAPER, ensemble_add_minimum={"antenna": 0.003}))
    assert method.uncertainty == EnsembleAdd(minimum_m=0.003)
    assert method.policy == Threshold(u_grasp=0.10, u_refine=0.6)


@pytest.mark.parametrize(
    ("name", "part", "words"),
    [
        ("mask-val", "antenna", r"unknown method 'mask-val': expected one of none, ensemble-add, maskval"),
        ("maskval", "mug", r"paper have no grasp\.mug\.maskval; they have antenna × "),
        ("ensemble-add", "mug", r"paper have no ensemble_add_minimum_m\.mug"),
    ],
)
def test_what_has_no_method_or_no_threshold_is_refused(name: str, part: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        make_method(name, part, PAPER)
