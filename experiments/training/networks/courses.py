"""How each network is trained."""

from pathlib import Path
from typing import Any

import torch

from experiments.training.config import Train
from experiments.training.detector_samples import DetectorSamples, stored_pictures
from experiments.training.networks.layers import DetectorNetwork, PoseNetwork
from experiments.training.networks.loop import Course
from experiments.training.networks.losses import detector_loss, pose_loss
from experiments.training.pictures import looks_alike, read_pictures
from experiments.training.pose_samples import PoseSamples, stored_crops
from sim.learned.weights import DETECTOR
from sim.model.parts import load_part

POSE_BATCH, DETECTOR_BATCH = 32, 8
_POSE_RATE, _DETECTOR_RATE = 8e-4, 1e-3


def course(network: str, config: Train, pictures: Path) -> Course[Any]:
    """How a network is trained on a set of pictures; PyTorch then uses one thread and the seed of the configuration."""
    torch.set_num_threads(1)
    torch.manual_seed(config.seed)
    seen = read_pictures(pictures, "train")
    of = f"{config.object}, {config.images} pictures, seed {config.seed}"
    if network == DETECTOR:
        samples = DetectorSamples(stored_pictures(seen), size=DETECTOR_BATCH, seed=config.seed)
        return Course(
            network, DetectorNetwork(), samples.batch, detector_loss, config.detector_steps, _DETECTOR_RATE, of
        )
    model = load_part(config.object)
    poses = PoseSamples(stored_crops(seen), model.part.mesh, looks_alike(model), size=POSE_BATCH, seed=config.seed)
    return Course(network, PoseNetwork(), poses.batch, pose_loss, config.pose_steps, _POSE_RATE, of)
