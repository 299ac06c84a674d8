"""Steps of training that can be stopped and go on: the same steps give the same weights on the same machine.

The learning rate rises, stays, and falls over the last quarter. What is kept on the way is the state before it falls:
a run that is to have more steps later goes on from there as if it had been asked for them at once.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Generic, TypeVar

import torch
from torch import Tensor, nn

from experiments.errors import UsageError
from experiments.progress import bar

WARM_UP = 200  # steps
FALLING_SHARE = 0.25  # of the steps
_WEIGHT_DECAY = 0.01
_LONGEST_GRADIENT = 20.0
_KEEP_EVERY = 250  # steps
_MEMORY = 0.995  # of the averaged weights, per step
Batch = TypeVar("Batch")


@dataclass(frozen=True)
class Course(Generic[Batch]):
    """What to train.

    Attributes:
        name: of the network, for people and files.
        network: to be trained, with its first weights.
        batch: the batch of a step.
        loss: terms of the loss, from the network's outputs and the batch.
        steps: how many in all.
        rate: the learning rate while it stays.
        of: what it is trained on and from, for a state that is kept to be of the same.
    """

    name: str
    network: nn.Module
    batch: Callable[[int], Batch]
    loss: Callable[[Any, Batch], dict[str, Tensor]]
    steps: int
    rate: float
    of: str = ""


def train(course: Course[Any], folder: Path) -> nn.Module:
    """The trained network, its weights averaged over the last steps; the state of the training is kept in a folder."""
    trainer = _Trainer(course)
    state, done = folder / f"{course.name}.pt", folder / f"{course.name}-falling.pt"
    falls = course.steps - round(FALLING_SHARE * course.steps)
    for path in (done, state):  # the later one first
        if trainer.load(path, falls):
            break
    with bar("step", course.name, course.steps, trainer.step) as progress:
        while trainer.step < course.steps:
            losses = trainer.advance(_rate(course, trainer.step))
            progress.update(1)
            progress.set_postfix_str(" ".join(f"{name} {value:.3f}" for name, value in losses.items()), refresh=False)
            if trainer.step % _KEEP_EVERY == 0 or trainer.step == falls:
                trainer.save(state if trainer.step <= falls else done)
    trainer.save(done)
    return trainer.averaged()


def _rate(course: Course[Any], step: int) -> float:
    falling = max(round(FALLING_SHARE * course.steps), 1)
    left = (course.steps - step) / falling
    return course.rate * min((step + 1) / WARM_UP, 1.0, max(left, 0.02))


def _tensors(batch: Any, device: torch.device) -> Any:
    """The batch with tensors in place of its arrays."""
    return replace(
        batch, **{field.name: torch.from_numpy(getattr(batch, field.name)).to(device) for field in fields(batch)}
    )


class _Trainer:
    """A network with its optimiser, its averaged weights and the number of steps done."""

    def __init__(self, course: Course[Any]) -> None:
        self._course, self.step = course, 0
        self._device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self._network = course.network.to(self._device, memory_format=torch.channels_last)
        self._average = {name: value.clone() for name, value in self._network.state_dict().items()}
        self._optimizer = torch.optim.AdamW(self._network.parameters(), lr=course.rate, weight_decay=_WEIGHT_DECAY)
        self._means: dict[str, float] = {}

    def advance(self, rate: float) -> dict[str, float]:
        """One step; returns the running means of the terms of the loss."""
        for group in self._optimizer.param_groups:
            group["lr"] = rate
        batch = _tensors(self._course.batch(self.step), self._device)
        self._network.train()
        images = batch.images.contiguous(memory_format=torch.channels_last)
        terms = self._course.loss(self._network(images), batch)
        total = torch.stack(list(terms.values())).sum()
        self._optimizer.zero_grad(set_to_none=True)
        total.backward()
        nn.utils.clip_grad_norm_(self._network.parameters(), _LONGEST_GRADIENT)
        self._optimizer.step()
        self.step += 1
        self._remember(terms)
        if not math.isfinite(total.item()):
            raise FloatingPointError(f"{self._course.name}: the loss left the finite numbers at step {self.step}")
        return self._means

    def averaged(self) -> nn.Module:
        """The network with the averaged weights, for use."""
        self._network.load_state_dict(self._average)
        return self._network.eval().cpu()

    def save(self, path: Path) -> None:
        """Keeps the state; a run that is killed meanwhile leaves the earlier one."""
        path.parent.mkdir(parents=True, exist_ok=True)
        new = path.with_suffix(".new")
        torch.save(
            {
                "step": self.step,
                "steps": self._course.steps,
                "of": self._course.of,
                "network": self._network.state_dict(),
                "average": self._average,
                "optimizer": self._optimizer.state_dict(),
            },
            new,
        )
        new.replace(path)

    def load(self, path: Path, falls: int) -> bool:
        """Goes on from a kept state if it lies on the way: from one of the fall only with the same number of steps."""
        if not path.exists():
            return False
        kept = torch.load(path, map_location=self._device, weights_only=True)
        if kept["of"] != self._course.of:
            raise UsageError(
                f"{path} is of {kept['of']}, expected {self._course.of}: delete it, or choose another --out"
            )
        if kept["step"] > falls and kept["steps"] != self._course.steps:
            return False
        self.step = kept["step"]
        try:
            self._network.load_state_dict(kept["network"])
        except RuntimeError as error:
            raise UsageError(f"{path} is of another network: delete it, or choose another --out") from error
        self._average = kept["average"]
        self._optimizer.load_state_dict(kept["optimizer"])
        return True

    def _remember(self, terms: dict[str, Tensor]) -> None:
        share = min(_MEMORY, (self.step + 1) / (self.step + 10))
        with torch.no_grad():
            for name, value in self._network.state_dict().items():
                kept = self._average[name]
                kept.lerp_(value, 1 - share) if value.is_floating_point() else kept.copy_(value)
        for name, value in terms.items():
            seen = float(value.detach())
            self._means[name] = 0.98 * self._means.get(name, seen) + 0.02 * seen
