"""Decision rules: what to do with a detection, given how uncertain its pose is."""

from policies.always import Always
from policies.threshold import Threshold

__all__ = ["Always", "Threshold"]
