"""Names for help texts, without what they stand for: `--help` does not wait for it. A test holds both together."""

from maskval import METHODS as _OF_THE_LIBRARY

METHOD_NAMES = (
    *_OF_THE_LIBRARY,
    "random",
    "oracle-mask",
    "oracle-mdd",
)  # the keys of experiments.setup.methods.METHODS
POLICY_NAMES = ("always", "best-of-view", "threshold", "patient", "next-best-view", "fuse")  # of policies.POLICIES
OWN = "or your own as package.module:Class"
