from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import maskval
from experiments.errors import UsageError
from experiments.setup.methods import METHODS, Context, Method, make_method, make_uncertainty, named_methods
from experiments.setup.thresholds import Thresholds, load_thresholds
from maskval import (
    Correspondences,
    Ensemble,
    Estimates,
    MaskVal,
    Needs,
    NoUncertainty,
    Pose,
    TemporalConsistency,
    needs_of,
)
from policies import Always, ThresholdPolicy
from sim.networks.ground_truth import FrameTruth, LatestTruth
from sim.networks.random_streams import Streams
from tests.fakes import brick, small_layout

PAPER = load_thresholds("paper")


def context(part: str, thresholds: Thresholds = PAPER, experiment: int = 0) -> Context:
    return Context(replace(brick(), name=part), thresholds, Streams(0, experiment, part), LatestTruth())


def made(name: str, part: str, thresholds: Thresholds = PAPER) -> Method:
    return make_method(name, context(part, thresholds))


def test_none_grasps_whatever_is_seen_and_needs_no_threshold() -> None:
    for part in ("antenna", "mug"):
        method = made("none", part)
        assert isinstance(method.uncertainty, NoUncertainty)
        assert method.policy == Always()


def test_maskval_decides_with_the_two_thresholds_of_its_object() -> None:
    method = made("maskval", "handle")
    assert isinstance(method.uncertainty, MaskVal)
    assert method.policy == ThresholdPolicy(u_grasp=0.55, u_refine=0.6)


def test_ensemble_add_decides_with_its_thresholds_on_a_scale_that_begins_at_its_minimum() -> None:
    method = made("ensemble-add", "antenna", replace(PAPER, ensemble_add_minimum={"antenna": 0.003}))
    assert method.uncertainty == Ensemble("add", minimum=0.003)
    assert method.policy == ThresholdPolicy(u_grasp=0.10, u_refine=0.6)


def test_temporal_brings_its_threshold_along_and_a_derived_or_a_told_one_goes_before_it() -> None:
    assert made("temporal", "antenna").policy == ThresholdPolicy(u_grasp=0.3, u_refine=0.6)
    derived = replace(PAPER, grasp={"antenna": {"temporal": 0.2}})
    assert made("temporal", "antenna", derived).policy == ThresholdPolicy(u_grasp=0.2, u_refine=0.6)
    told = derived.with_told(["temporal=0.1"], ["temporal"])
    assert made("temporal", "antenna", told).policy == ThresholdPolicy(u_grasp=0.1, u_refine=0.6)


def test_every_method_judges_estimates_and_says_what_it_needs() -> None:
    layout = small_layout()
    size = (layout.camera.height, layout.camera.width)
    mask = np.zeros(size, dtype=bool)
    mask[8:16, 10:22] = True
    pose = Pose.from_translation((0.0, 0.0, 0.5))
    estimates = Estimates(
        layout.camera,
        brick().mesh,
        mask[None],
        ((pose,), (pose,)),
        np.ones(1),
        0.5,
        np.full(size, 0.5),
        Pose.identity(),
        (Correspondences(brick().mesh.vertices, np.full((len(brick().mesh.vertices), 2), 9.0), np.ones(8)),),
        np.zeros((*size, 3), dtype=np.uint8),
    )
    needs = {}
    for name in METHODS:
        of = context("antenna")
        of.latest_truth.keep(FrameTruth(0, np.where(mask, 0, -1).astype(np.int8), (pose,), layout.camera, brick().mesh))
        method = make_uncertainty(name, of)
        u = method(estimates)
        assert u.shape == (1,)
        assert 0.0 <= u[0] <= 1.0
        needs[name] = needs_of(method)
    assert {name for name, one in needs.items() if one.depth} == {"depth"}
    assert {name for name, one in needs.items() if one.X_BC} == {"temporal"}
    assert {name for name, one in needs.items() if one.rgb} == {"render-ncc"}
    assert {name for name, one in needs.items() if one.correspondences} == {"inliers", "pnp-covariance"}
    two = {"ensemble-add", "ensemble-mdd", "ensemble-translation", "ensemble-rotation", "maskval-ensemble"}
    assert {name for name, one in needs.items() if one.estimators == 2} == two


def test_a_method_with_a_memory_is_a_new_one_in_every_experiment() -> None:
    first, second = (make_uncertainty("temporal", context("antenna")) for _ in range(2))
    assert isinstance(first, TemporalConsistency)
    assert first is not second


def test_the_librarys_methods_are_compared_under_their_names_before_those_that_need_more_than_estimates() -> None:
    assert list(METHODS) == [*maskval.METHODS, "random", "oracle-mask", "oracle-mdd", *maskval.NETWORK_METHODS]


def test_chance_is_another_in_every_experiment_and_the_same_in_one() -> None:
    one, same, other = (make_uncertainty("random", context("antenna", experiment=i)) for i in (0, 0, 1))
    assert one == same
    assert one != other


def test_all_stands_for_every_method() -> None:
    assert named_methods(["all"], networks=True) == tuple(METHODS)
    assert set(METHODS) - set(named_methods(["all"])) == {"inliers", "pnp-covariance", "render-ncc"}
    assert named_methods(["score", "mine:Own"]) == ("score", "mine:Own")


OWN = """
import numpy as np
from maskval import Needs

class Own:
    u_grasp = 0.4
    needs = Needs(estimators=2)
    def __call__(self, estimates):
        return np.zeros(len(estimates))

class Greedy(Own):
    needs = 3

class Plain:
    def __call__(self, estimates):
        return np.zeros(len(estimates))
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own_methods.py").write_text(OWN)
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.usefixtures("own")
def test_a_class_of_ones_own_is_a_method_by_its_name() -> None:
    method = made("own_methods:Own", "antenna")
    assert needs_of(method.uncertainty) == Needs(estimators=2)
    assert method.policy == ThresholdPolicy(u_grasp=0.4, u_refine=0.6)
    derived = replace(PAPER, grasp={"antenna": {"own_methods:Own": 0.2}})
    assert made("own_methods:Own", "antenna", derived).policy == ThresholdPolicy(u_grasp=0.2, u_refine=0.6)


@pytest.mark.usefixtures("own")
@pytest.mark.parametrize(
    ("name", "part", "words"),
    [
        ("mask-val", "antenna", r"unknown method 'mask-val': expected one of none, maskval, .*package\.module:Class"),
        ("maskval", "mug", r"paper have no grasp\.mug\.maskval; they have antenna × .*--u-grasp maskval=U"),
        ("ensemble-add", "mug", r"paper have no ensemble_add_minimum_m\.mug"),
        ("own_methods:Plain", "antenna", r"no grasp\.antenna\.own_methods:Plain; .*--u-grasp own_methods:Plain=U"),
        ("own_methods:Greedy", "antenna", r"own_methods:Greedy: Greedy\.needs must be a maskval\.Needs, but is 3"),
    ],
)
def test_what_has_no_method_or_no_threshold_is_refused(name: str, part: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        made(name, part)
