"""Training itself: needs the extra `train`, which CI does not install. `pytest -m study tests/experiments/training`."""

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.training.batches import DetectorBatch, PoseBatch
from experiments.training.config import Train
from sim.learned.weights import load_networks, open_network

pytestmark = pytest.mark.study


def batch_of(step: int) -> DetectorBatch:
    rng = np.random.default_rng(step)
    images = rng.uniform(size=(2, 3, 32, 32)).astype(np.float32)
    part = (images.mean(axis=1)[:, ::2, ::2] > 0.5).astype(np.float32)
    return DetectorBatch(images, part, part * 0.5, np.zeros((2, 2, 16, 16), dtype=np.float32))


class StoppedError(Exception):
    pass


def trained(folder: Path, steps: int, stop: int | None = None) -> dict[str, np.ndarray]:
    import torch  # noqa: PLC0415

    from experiments.training.networks.layers import DetectorNetwork  # noqa: PLC0415
    from experiments.training.networks.loop import Course, train  # noqa: PLC0415
    from experiments.training.networks.losses import detector_loss  # noqa: PLC0415

    def batch(step: int) -> DetectorBatch:
        if step == stop:
            raise StoppedError
        return batch_of(step)

    torch.set_num_threads(1)
    torch.manual_seed(0)
    network = train(Course("detector", DetectorNetwork(), batch, detector_loss, steps, 1e-3), folder)
    return {name: value.numpy().copy() for name, value in network.state_dict().items()}


def equal(one: dict[str, np.ndarray], other: dict[str, np.ndarray]) -> bool:
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


def test_a_training_that_was_stopped_comes_to_the_same_weights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from experiments.training.networks import loop  # noqa: PLC0415

    monkeypatch.setattr(loop, "_KEEP_EVERY", 4)
    whole = trained(tmp_path / "whole", 24)
    for stop in (10, 22):  # before and while the learning rate falls
        with pytest.raises(StoppedError):
            trained(tmp_path / "parts", 24, stop)
    assert equal(trained(tmp_path / "parts", 24), whole)


def test_more_steps_go_on_as_if_they_had_been_asked_for_at_once(tmp_path: Path) -> None:
    trained(tmp_path / "longer", 16)
    longer = trained(tmp_path / "longer", 24)
    assert equal(longer, trained(tmp_path / "at once", 24))
    assert not equal(longer, trained(tmp_path / "shorter", 16))


def test_a_training_reduces_its_loss() -> None:
    import torch  # noqa: PLC0415

    from experiments.training.networks.layers import PoseNetwork  # noqa: PLC0415
    from experiments.training.networks.losses import pose_loss  # noqa: PLC0415

    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    images = rng.uniform(size=(4, 3, 64, 64)).astype(np.float32)
    flat = images[:, :, ::2, ::2][:, None] * 2 - 1  # coordinates that are the colours
    ones, head = np.ones((4, 32, 32), dtype=np.float32), np.zeros((4, 3), dtype=np.float32)
    batch = PoseBatch(*map(torch.from_numpy, (images, np.ascontiguousarray(flat), ones, head)))
    network, losses = PoseNetwork(), []
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-3)
    for _ in range(30):
        terms = pose_loss(network(batch.images), batch)
        losses.append(float(terms["coordinates"].detach()))
        optimizer.zero_grad()
        torch.stack(list(terms.values())).sum().backward()
        optimizer.step()
    assert losses[-1] < 0.6 * losses[0]


def test_the_loss_of_coordinates_is_that_to_the_nearest_pose_that_looks_alike() -> None:
    import torch  # noqa: PLC0415

    from experiments.training.networks.losses import pose_loss  # noqa: PLC0415

    one, other = torch.full((1, 3, 4, 4), 0.5), torch.full((1, 3, 4, 4), -0.5)
    batch = PoseBatch(torch.zeros(1), torch.stack((one, other), dim=1), torch.ones(1, 4, 4), torch.zeros(1, 3))
    rest = torch.zeros(1, 4, 4), torch.zeros(1, 4, 4), torch.zeros(1, 4)
    assert float(pose_loss((other, *rest), batch)["coordinates"]) == 0.0
    assert float(pose_loss((one, *rest), batch)["coordinates"]) == 0.0
    assert float(pose_loss((torch.zeros(1, 3, 4, 4), *rest), batch)["coordinates"]) > 0.0


def test_a_network_in_onnx_says_what_it_said_in_pytorch(tmp_path: Path) -> None:
    import torch  # noqa: PLC0415

    from experiments.training.networks.export import export  # noqa: PLC0415
    from experiments.training.networks.layers import DetectorNetwork, PoseNetwork  # noqa: PLC0415

    for name, network, size in (("s1", PoseNetwork(), (64, 64)), ("detector", DetectorNetwork(), (240, 320))):
        images = np.random.default_rng(0).uniform(size=(3, 3, *size)).astype(np.float32)
        network.eval()
        with torch.no_grad():
            said = network(torch.from_numpy(images))
        export(network, name, tmp_path / f"{name}.onnx")
        told = open_network(tmp_path / f"{name}.onnx")(images)
        for one, other in zip(told, said if isinstance(said, tuple) else (said,), strict=True):
            assert one == pytest.approx(other.numpy(), abs=2e-4)


def test_the_command_trains_from_nothing_and_writes_what_the_cell_reads(tmp_path: Path) -> None:
    from experiments.training.command import train  # noqa: PLC0415

    config = Train(object="handle", images=5, held_out=3, pose_steps=4, detector_steps=4, jobs=1, out=tmp_path)
    assert train(config) == 0
    found = load_networks(tmp_path).manifest
    assert found.part == "handle"
    assert json.loads((tmp_path / "manifest.json").read_text())["training"]["steps"] == {"pose": 4, "detector": 4}
    first = (tmp_path / "s1.onnx").read_bytes()
    assert train(config) == 0
    assert (tmp_path / "s1.onnx").read_bytes() == first
