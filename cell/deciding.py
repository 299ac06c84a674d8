"""Asks a policy what to do, and refuses what is no decision."""

import math
from numbers import Integral, Real

from cell.asking import ask
from cell.errors import PolicyError
from cell.interfaces import Action, Decision, Observation, Policy
from maskval import Pose


def ask_policy(policy: Policy, observation: Observation, time_limit: float) -> Decision:
    """The policy's decision.

    Args:
        policy: whom to ask.
        observation: about what.
        time_limit: s of the wall clock, see `ask`.

    Raises:
        PolicyError: the policy raised, or took too long.
    """
    return ask(
        lambda: policy.decide(observation),
        time_limit,
        lambda what: PolicyError(f"{_who(policy, observation)}: {what}"),
    )


def check_decision(decision: object, observation: Observation, policy: Policy | None) -> None:
    """Raises PolicyError unless it is a decision, and about a detection that exists."""
    who = _who(policy, observation)
    if not isinstance(decision, Decision):
        raise PolicyError(f"{who}: expected a cell.interfaces.Decision, got {type(decision).__name__}")
    if not isinstance(decision.action, Action):
        raise PolicyError(f"{who}: expected a cell.interfaces.Action, got {decision.action!r}")
    count, chosen = len(observation.detections), decision.detection
    none_is_due = chosen is None and decision.action is Action.SEARCH
    if not (none_is_due or (isinstance(chosen, Integral) and 0 <= chosen < count)):
        raise PolicyError(f"{who}: expected a detection in 0..{count - 1} to {decision.action}, got {chosen}")
    for name in ("threshold", "u"):
        number = getattr(decision, name)
        if not (number is None or (isinstance(number, Real) and math.isfinite(number))):
            raise PolicyError(f"{who}: expected {name} to be a finite number or None, got {number!r}")
    for name in ("X_BO_est", "X_BC"):
        pose = getattr(decision, name)
        if not (pose is None or isinstance(pose, Pose)):
            raise PolicyError(f"{who}: expected {name} to be a maskval.Pose or None, got {type(pose).__name__}")


def _who(policy: Policy | None, observation: Observation) -> str:
    name = "the decision" if policy is None else type(policy).__name__
    return f"{name} on frame {observation.frame.index}"
