"""Names for help texts, without loading what they name: `--help` does not wait. A test compares both."""

from maskval import METHODS as _OF_THE_LIBRARY

METHOD_NAMES = (
    *_OF_THE_LIBRARY,
    "random",
    "oracle-mask",
    "oracle-mdd",
)  # the keys of experiments.setup.methods.METHODS
POLICY_NAMES = ("always", "best-of-view", "threshold", "patient", "next-best-view", "fuse")  # of policies.POLICIES
OWN = "or your own as package.module:Class"
VIEWS = WINDOW, WEB = "window", "web"  # where `graspcell run --view` shows an experiment
