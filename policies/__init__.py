"""Decision rules: what to do with a detection, given how uncertain its pose is."""

from collections.abc import Callable

from cell.interfaces import Policy
from cell.setup import PolicySetup
from policies.always import Always
from policies.best_of_view import BestOfView
from policies.fuse import Fuse
from policies.next_best_view import NextBestView
from policies.patient import Patient
from policies.threshold import ThresholdPolicy

__all__ = ["POLICIES", "Always", "BestOfView", "Fuse", "NextBestView", "Patient", "ThresholdPolicy"]

POLICIES: dict[str, Callable[[PolicySetup], Policy]] = {
    "always": lambda _: Always(),
    "best-of-view": lambda _: BestOfView(),
    "threshold": lambda setup: ThresholdPolicy(setup.u_grasp, setup.u_refine),
    "patient": Patient,
    "next-best-view": NextBestView,
    "fuse": Fuse,
}
