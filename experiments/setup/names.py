"""Names for help texts, without loading what they name: `--help` does not wait. A test compares both."""

from maskval import METHODS as _OF_THE_LIBRARY
from maskval import NETWORK_METHODS as _OF_NETWORKS

METHOD_NAMES = (
    *_OF_THE_LIBRARY,
    "random",
    "oracle-mask",
    "oracle-mdd",
    *_OF_NETWORKS,
)  # the keys of experiments.setup.methods.METHODS
POLICY_NAMES = ("always", "best-of-view", "threshold", "patient", "next-best-view", "fuse")  # of policies.POLICIES
OWN = "or your own as package.module:Class"
VIEWS = WINDOW, WEB = "window", "web"  # where `graspcell run --view` shows an experiment

_SINGULAR = {"--objects": "--object", "--methods": "--method", "--policies": "--policy"}
NAMES_IN_BOTH_NUMBERS = {*_SINGULAR, *_SINGULAR.values()}  # every command takes both, as it has one of them


def option_name(argument: str) -> str:
    """One spelling of an option, whichever an argument has: --fresh_look, --no-fresh-look, --objects=handle."""
    name = argument.partition("=")[0].replace("_", "-")
    name = f"--{name.removeprefix('--no-')}" if name.startswith("--no-") else name
    return _SINGULAR.get(name, name)
