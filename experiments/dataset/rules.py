"""What the paper leaves open about its dataset figures: every choice has a name, and a default for all results."""

from dataclasses import dataclass
from typing import Literal

from maskval import Counting

Averaging = Literal["images", "pooled"]
EmptyImages = Literal["skip", "one"]
FalseNegatives = Literal["no true positive", "no pose"]
Visibility = Literal["total", "in view"]
Choice = Literal["largest", "first violation"]
Range = Literal["whole", "reached"]
Minimum = Literal["least", "zero"]


@dataclass(frozen=True, slots=True)
class Rules:
    """How poses are counted, a threshold is chosen and figures are scaled.

    Args:
        averaging: see `maskval.Counting`.
        empty_images: see `maskval.Counting`.
        false_negatives: see `maskval.Counting`.
        visibility: whether a part is eligible by all that hides it, or by the image's border alone.
        threshold: the largest u_T that reaches the AP, or the last one before the AP is first missed.
        auc_range: AUC AR over all error thresholds, or from the first one that reaches the AP.
        ensemble_minimum: Ensemble-ADD's scale begins at the least disagreement of the set, or at 0.
    """

    averaging: Averaging = "images"
    empty_images: EmptyImages = "skip"
    false_negatives: FalseNegatives = "no true positive"
    visibility: Visibility = "total"
    threshold: Choice = "largest"
    auc_range: Range = "whole"
    ensemble_minimum: Minimum = "least"

    @property
    def counting(self) -> Counting:
        """What of it `maskval.metrics` knows."""
        return Counting(self.averaging, self.empty_images, self.false_negatives)


ALTERNATIVES: dict[str, Rules] = {  # each differs from the defaults in one thing
    "pooled poses": Rules(averaging="pooled"),
    "empty images have AP 1": Rules(empty_images="one"),
    "FN only without any pose": Rules(false_negatives="no pose"),
    "visibility in view only": Rules(visibility="in view"),
    "first violation": Rules(threshold="first violation"),
    "AUC from the first reached": Rules(auc_range="reached"),
    "Ensemble-ADD from 0": Rules(ensemble_minimum="zero"),
}
