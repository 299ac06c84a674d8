"""The networks: plain convolutions that run on a CPU, a map at half of the input's size."""

import itertools

import torch
from torch import Tensor, nn
from torch.nn import functional

HEAD = 4  # u, v, logarithm of depth, logarithm of its error
MAPS = 5  # three coordinates, logarithm of their error, visible


class Block(nn.Sequential):
    """Convolution, batch norm, ReLU."""

    def __init__(self, inputs: int, outputs: int, stride: int = 1, kernel: int = 3) -> None:
        super().__init__(
            nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False),
            nn.BatchNorm2d(outputs),
            nn.ReLU(inplace=True),
        )


class Pyramid(nn.Module):
    """A feature pyramid: down to a small map with much context, and back up to half of the input's size.

    Args:
        widths: channels at 1/2, 1/4, … of the input's size.
    """

    def __init__(self, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.stem = Block(3, widths[0], 2, 5)
        pairs = list(itertools.pairwise(widths))
        self.down = nn.ModuleList(nn.Sequential(Block(a, b, 2), Block(b, b)) for a, b in pairs)
        self.lateral = nn.ModuleList(Block(b, a, kernel=1) for a, b in pairs)
        self.merge = nn.ModuleList(Block(a, a) for a, _ in pairs)

    def forward(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """The map at half size, and the smallest one."""
        levels = [self.stem(2.0 * torch.sqrt(images) - 1.0)]  # the root tells dark levels apart
        for down in self.down:
            levels.append(down(levels[-1]))
        features = levels[-1]
        for index in reversed(range(len(self.merge))):
            finer = levels[index]
            features = functional.interpolate(self.lateral[index](features), finer.shape[-2:], mode="bilinear")
            features = self.merge[index](finer + features)
        return features, levels[-1]


class DetectorNetwork(nn.Module):
    """Part, centre and two votes for every second pixel; see `sim.learned.grouping`."""

    def __init__(self) -> None:
        super().__init__()
        self.pyramid = Pyramid((8, 24, 48, 64, 64))
        self.maps = nn.Conv2d(8, 4, 1)
        nn.init.constant_(self.maps.bias[:2], -3.0)  # most pixels show nothing  # type: ignore[index]

    def forward(self, images: Tensor) -> Tensor:
        """(N, 4, H/2, W/2)."""
        features, _ = self.pyramid(images)
        maps: Tensor = self.maps(features)
        return maps


class PoseNetwork(nn.Module):
    """Object coordinates of a crop, and a head that reads place and depth from them; see `sim.learned.coordinates`."""

    def __init__(self) -> None:
        super().__init__()
        self.pyramid = Pyramid((32, 64, 96, 128))
        self.maps = nn.Sequential(Block(32, 32), nn.Conv2d(32, MAPS, 1))
        self.head_maps = nn.Sequential(Block(32 + MAPS + 2, 32, 2), Block(32, 48, 2), Block(48, 64, 2))
        self.context = Block(128, 32, kernel=1)
        self.head = nn.Sequential(
            nn.Flatten(), nn.Linear((64 + 32) * 16, 128), nn.ReLU(inplace=True), nn.Linear(128, HEAD)
        )
        line = torch.linspace(-1.0, 1.0, 32)
        self.register_buffer("grid", torch.stack(torch.meshgrid(line, line, indexing="xy"))[None])

    def forward(self, images: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Coordinates (N, 3, h, w), logarithm of their error and logit of being visible (N, h, w), head (N, 4)."""
        features, smallest = self.pyramid(images)
        maps = self.maps(features)
        grid = self.grid + torch.zeros_like(maps[:, :2])  # for any number of images, in ONNX too
        seen = self.head_maps(torch.cat((features, maps, grid), dim=1))
        head = self.head(torch.cat((seen.flatten(1), self.context(smallest).flatten(1)), dim=1))
        return maps[:, :3], maps[:, 3], maps[:, 4], head
