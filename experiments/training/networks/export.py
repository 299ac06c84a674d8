"""A trained network as an ONNX file."""

import warnings
from pathlib import Path

import torch
from torch import nn

from sim.learned.coordinates import CROP_SIZE
from sim.learned.estimators import DETECTOR_SIZE
from sim.learned.weights import DETECTOR

_POSE_OUTPUTS = ["coordinates", "log_scale", "visible", "head"]


def export(network: nn.Module, name: str, path: Path) -> None:
    """Writes a network that takes any number of images; one that is interrupted leaves the earlier file."""
    size = DETECTOR_SIZE if name == DETECTOR else (CROP_SIZE, CROP_SIZE)
    outputs = ["maps"] if name == DETECTOR else _POSE_OUTPUTS
    any_number = {key: {0: "n"} for key in ("images", *outputs)}
    new = path.with_suffix(".new")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the exporter's: it is the older of two, which needs no other package
        torch.onnx.export(
            network.to(memory_format=torch.contiguous_format),
            (torch.zeros(1, 3, *size),),
            new,
            input_names=["images"],
            output_names=outputs,
            dynamic_axes=any_number,
            dynamo=False,
        )
    new.replace(path)
