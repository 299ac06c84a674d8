"""The root of all random numbers of an experiment: a stream for each part and purpose."""

from dataclasses import dataclass
from zlib import crc32

import numpy as np


@dataclass(frozen=True, slots=True)
class Streams:
    """The root of all random numbers of one experiment with one part.

    Attributes:
        seed: the root seed, ≥ 0.
        experiment: number of the experiment, ≥ 0; another one draws anew.
        part_name: name of the part.
    """

    seed: int
    experiment: int
    part_name: str

    def generator(self, part: int, purpose: str, *numbers: int) -> np.random.Generator:
        """A fresh generator, the same for the same arguments."""
        key = (crc32(self.part_name.encode()), self.experiment, part, crc32(purpose.encode()), *numbers)
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=key))
