import pytest

from cell.layout import Layout
from experiments.errors import UsageError
from experiments.setup.methods import Method
from experiments.setup.policies import make_policy, policy_name
from maskval import MaskVal
from policies import Always, Patient, ThresholdPolicy
from tests.fakes import brick

OWN = Method(MaskVal(), ThresholdPolicy(0.3, 0.7))


def made(name: str | None, method: Method = OWN) -> object:
    return make_policy(name, method, brick(), Layout(), 0.6)


@pytest.mark.parametrize(
    ("name", "method", "written"),
    [
        (None, "none", "always"),
        (None, "maskval", "threshold"),
        ("fuse", "maskval", "fuse"),
        ("fuse", "none", "fuse"),
        ("mine:Bold", "none", "mine:Bold"),
    ],
)
def test_a_policy_is_written_down_by_its_name_or_by_that_of_the_methods_own(
    name: str | None, method: str, written: str
) -> None:
    assert policy_name(name, method) == written


def test_without_a_name_it_is_the_methods_own() -> None:
    assert made(None) is OWN.policy


def test_a_named_one_acts_upon_the_methods_thresholds_and_is_a_fresh_one() -> None:
    policy = made("threshold")
    assert isinstance(policy, ThresholdPolicy)
    assert (policy.u_grasp, policy.u_refine) == (0.3, 0.7)
    assert isinstance(made("patient"), Patient)
    assert made("patient") is not made("patient")


def test_for_a_method_without_thresholds_it_grasps_at_u_of_0_and_refines_at_the_tables() -> None:
    policy = made("threshold", Method(MaskVal(), Always()))
    assert isinstance(policy, ThresholdPolicy)
    assert (policy.u_grasp, policy.u_refine) == (0.0, 0.6)


def test_what_is_no_policy_is_refused() -> None:
    with pytest.raises(UsageError, match=r"unknown policy 'bold': expected one of always, best-of-view, "):
        made("bold")
    with pytest.raises(UsageError, match=r"lacks decide"):
        made("builtins:repr")
