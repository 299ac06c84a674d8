"""What the paper leaves open about its dataset figures: every choice has a name, and a default for all results."""

from dataclasses import dataclass
from typing import Literal

from maskval import Counting
from maskval.evaluation.metrics import Choice

Averaging = Literal["images", "pooled"]
EmptyImages = Literal["skip", "one"]
FalseNegatives = Literal["no true positive", "no pose"]
Visibility = Literal["total", "in view"]
Range = Literal["whole", "reached"]
Minimum = Literal["least", "zero"]

ANNOTATED_VISIBILITY = 0.1  # least visible share of a part that a detector is asked for, as in BOP's 2D tasks


@dataclass(frozen=True, slots=True)
class Rules:
    """How poses are counted, a threshold is chosen and figures are scaled; the first three as in `maskval.Counting`."""

    averaging: Averaging = "images"
    """AP and AR of each image and then their mean (images), or of all poses at once (pooled)."""
    empty_images: EmptyImages = "skip"
    """An image without remaining poses has no AP (skip), or AP 1 (one)."""
    false_negatives: FalseNegatives = "no true positive"
    """An eligible part is one when no true positive of it remains, or only when no pose of it remains."""
    visibility: Visibility = "total"
    """What makes a part eligible: all that hides it (total), or the image's border alone (in view)."""
    threshold: Choice = "largest"
    """u_t,g is the largest that reaches the AP, or the last one before the AP is first missed (first violation)."""
    auc_range: Range = "whole"
    """AUC AR over errors of 0 to 30 mm (whole), or from the first error threshold that reaches the AP (reached)."""
    ensemble_minimum: Minimum = "least"
    """Ensemble-ADD's scale begins at the least disagreement of the set (least), or at 0 (zero)."""

    @property
    def counting(self) -> Counting:
        """What of it `maskval.evaluation.metrics` knows."""
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
