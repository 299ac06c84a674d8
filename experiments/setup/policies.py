"""The policy of an experiment: the method's own, one of the package's, or one from elsewhere."""

from cell.interfaces import Policy
from cell.layout import Layout
from cell.part import Part
from cell.setup import PolicySetup
from experiments.setup.methods import Method, known_method
from experiments.setup.plugins import chosen, make_object
from experiments.setup.thresholds import Thresholds
from policies import POLICIES, ThresholdPolicy
from sim.model.parts import load_part


def policy_name(name: str | None, method: str) -> str:
    """The policy's name in the logs; None stands for the method's own policy."""
    return name or ("always" if method == "none" else "threshold")


def make_policy(name: str | None, method: Method, part: Part, layout: Layout, refine: float) -> Policy:
    """A new policy, which remembers nothing.

    Args:
        name: a key of `POLICIES`, `package.module:Class`, or None for the method's own.
        method: whose uncertainties it uses.
        part: the kind of part.
        layout: the cell.
        refine: u_t,r of a method without thresholds.

    Raises:
        UsageError: there is no such policy, or it cannot be made.
    """
    if name is None:
        return method.policy
    own = method.policy
    u_grasp, u_refine = (own.u_grasp, own.u_refine) if isinstance(own, ThresholdPolicy) else (0.0, refine)
    factory = chosen("--policy", name, POLICIES)
    policy: Policy = make_object(name, factory, ("decide",), PolicySetup(part, layout, u_grasp, u_refine))
    return policy


def check_policy(name: str | None, part: str, method: str, thresholds: Thresholds) -> None:
    """Raises UsageError unless there is such a policy; part and method exist."""
    known = load_part(part).part
    make_policy(name, known_method(method, known, thresholds), known, Layout(), thresholds.refine)
