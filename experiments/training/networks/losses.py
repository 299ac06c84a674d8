"""What the networks are trained to make small."""

import torch
from torch import Tensor
from torch.nn import functional

from experiments.training.batches import DetectorBatch, PoseBatch

_COORDINATES_WEIGHT = (
    10.0  # with 1, the gradients of the other terms outweigh theirs: 3 times the error after 120 steps
)
_MASK_WEIGHT, _HEAD_WEIGHT, _SCALE_WEIGHT, _VOTE_WEIGHT = 0.5, 1.0, 0.05, 1.0
_CENTER_WEIGHT = 1.0


def pose_loss(outputs: tuple[Tensor, ...], batch: PoseBatch[Tensor]) -> dict[str, Tensor]:
    """The terms of the pose network's loss, which is their sum.

    The coordinates' error is that to the nearest of the poses that look alike, as a whole crop. What the network says
    of its own errors is fitted by the likelihood of Laplace's distribution; that does not reach the errors themselves.
    """
    coordinates, log_scale, visible_logit, head = outputs
    pixels = batch.visible.sum(dim=(1, 2)).clamp(min=1.0)
    errors = (coordinates[:, None] - batch.coordinates).abs().mean(dim=2)  # (N, S, h, w)
    of_each = (errors * batch.visible[:, None]).sum(dim=(2, 3)) / pixels[:, None]
    least, best = of_each.min(dim=1)
    own = errors[torch.arange(len(best)), best].detach()
    log_scale = log_scale.clamp(-6.0, 2.0)
    surprise = ((own * torch.exp(-log_scale) + log_scale) * batch.visible).sum(dim=(1, 2)) / pixels
    off = (head[:, :3] - batch.head).abs()
    log_sigma = head[:, 3].clamp(-6.0, 1.0)
    unlikely = off[:, 2].detach() * torch.exp(-log_sigma) + log_sigma
    return {
        "coordinates": _COORDINATES_WEIGHT * least.mean(),
        "visible": _MASK_WEIGHT * functional.binary_cross_entropy_with_logits(visible_logit, batch.visible),
        "head": _HEAD_WEIGHT * (off[:, :2].mean() + 3.0 * off[:, 2].mean()),
        "scale": _SCALE_WEIGHT * (surprise.mean() + unlikely.mean()),
    }


def detector_loss(outputs: Tensor, batch: DetectorBatch[Tensor]) -> dict[str, Tensor]:
    """The terms of the detector's loss, which is their sum; the centre's is CornerNet's focal loss."""
    part, center, votes = outputs[:, 0], outputs[:, 1], outputs[:, 2:4]
    counts = (batch.part >= 0).float()
    truth = batch.part.clamp(min=0.0)
    each = functional.binary_cross_entropy_with_logits(part, truth, reduction="none")
    area = truth.sum().clamp(min=1.0)
    probability = torch.sigmoid(center).clamp(1e-4, 1 - 1e-4)
    peak = (batch.center == 1.0).float()
    right = peak * (1 - probability) ** 2 * torch.log(probability)
    wrong = (1 - peak) * (1 - batch.center) ** 4 * probability**2 * torch.log(1 - probability)
    off = functional.smooth_l1_loss(votes, batch.votes, reduction="none", beta=0.05).sum(dim=1)
    return {
        "part": (each * counts).sum() / (4.0 * area),
        "center": -_CENTER_WEIGHT * (right + wrong).sum() / peak.sum().clamp(min=1.0) / 4.0,
        "votes": _VOTE_WEIGHT * (off * truth).sum() / area,
    }
