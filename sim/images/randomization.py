"""Random surfaces, rooms and lamps for pictures."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from maskval import Pose
from sim.images.generated import Body
from sim.images.photo_scene import Light, Surface, SurfacedBody, Wall
from sim.images.textures import between, noise, random_color, texture
from sim.instance_ids import NO_INSTANCE
from sim.model.parts import PartModel

_BODY_TEXELS, _WALL_TEXELS = 64, 256
_PART_GRAIN = 0.03  # standard deviation of a part's own colour over its surface
ROOM_HALF_SIZE = (1.6, 2.4)  # m: how small and how large
_WALL_HEIGHT = 2.0  # m
_AMBIENT = (0.20, 0.45)
_LAMPS = (1, 3)
_LAMP_LIGHT = (0.5, 1.1)  # of all lamps together
_LAMP_ELEVATION_DEG = 25.0  # the least
_LAMP_DISTANCE = (0.8, 2.0)  # m, of a spot
_FAR_LAMP = 2.0  # m from the middle of its shadows to where they begin

Array = NDArray[np.float64]


class SurfaceSampler:
    """Gives bodies their surfaces, in the order of the calls.

    Args:
        model: the kind of part, with its own colour.
        textured: share of parts with a random texture instead, in [0, 1].
        rng: what surfaces are drawn from.
    """

    def __init__(self, model: PartModel, textured: float, rng: np.random.Generator) -> None:
        self._model, self._textured, self._rng = model, textured, rng

    def with_surfaces(self, bodies: Sequence[Body]) -> list[SurfacedBody]:
        """Bodies with surfaces: `part`'s for parts, `other`'s for clutter."""
        return [SurfacedBody(*body, self.other() if body[2] == NO_INSTANCE else self.part()) for body in bodies]

    def part(self) -> Surface:
        """The surface of a part: its own colour and gloss, a little varied, or a random texture."""
        if self._rng.uniform() < self._textured:
            return self.other()
        color = np.array(self._model.rgba[:3]) * self._rng.uniform(0.8, 2.0) * self._rng.uniform(0.9, 1.1, 3)
        grain = noise((6 * _BODY_TEXELS, _BODY_TEXELS), 1.0, self._rng)
        dark, pale = (color * (1 + 4 * sign * _PART_GRAIN) for sign in (-1, 1))
        picture = between(0.5 + grain / 8, dark, pale)
        gloss = self._rng.uniform(0.4, 1.2, 2) * (self._model.specular, self._model.shininess)
        return Surface(picture, *np.clip(gloss, 0.0, 1.0).tolist())

    def other(self) -> Surface:
        """A random texture with random gloss."""
        picture = texture(6 * _BODY_TEXELS, _BODY_TEXELS, self._rng)
        return Surface(picture, *self._rng.uniform(0.0, 0.8, 2).tolist())


def room(X_CW: Pose, half_size: Array, rng: np.random.Generator) -> list[Wall]:
    """A floor and four walls, each of which goes on behind the next one.

    Args:
        X_CW: pose of the floor's middle, z up.
        half_size: of the floor along W's x and y, (2,) m.
        rng: what their pictures are drawn from.
    """
    longest = ROOM_HALF_SIZE[1]
    walls = [Wall(X_CW, (longest, longest), _wall_surface(rng))]
    paper = _wall_surface(rng)
    for side, distance in enumerate((*half_size.tolist(), *half_size.tolist())):
        turn = Pose.from_rotvec((0.0, 0.0, side * math.pi / 2))
        # A plane that faces the room: its z axis along −x of the turned frame.
        upright = Pose.from_rotvec((0.0, -math.pi / 2, 0.0), (distance, 0.0, _WALL_HEIGHT / 2))
        walls.append(Wall(X_CW @ turn @ upright, (_WALL_HEIGHT / 2, longest), paper))
    return walls


def lamps(X_CW: Pose, rng: np.random.Generator) -> tuple[Sequence[Light], float]:
    """Lamps above the origin of W, the first one with shadows, and the ambient light.

    Args:
        X_CW: pose of W, z up.
        rng: what they are drawn from.
    """
    count = int(rng.integers(*_LAMPS, endpoint=True))
    shares = rng.dirichlet(np.ones(count)) * rng.uniform(*_LAMP_LIGHT)
    lights = []
    for index, share in enumerate(shares):
        height = rng.uniform(math.sin(math.radians(_LAMP_ELEVATION_DEG)), 1.0)
        azimuth, away = rng.uniform(-math.pi, math.pi), math.sqrt(1 - height**2)
        up_C = X_CW.rotation @ (away * math.cos(azimuth), away * math.sin(azimuth), height)
        spot = rng.uniform() < 0.5
        position = X_CW.translation + (rng.uniform(*_LAMP_DISTANCE) if spot else _FAR_LAMP) * up_C
        warmth = rng.uniform(-0.12, 0.12)
        lights.append(Light(-up_C, share * np.array((1 + warmth, 1.0, 1 - warmth)), position, spot, index == 0))
    return lights, float(rng.uniform(*_AMBIENT))


def _wall_surface(rng: np.random.Generator) -> Surface:
    if rng.uniform() < 0.15:
        picture = np.broadcast_to(np.rint(255 * random_color(rng)).astype(np.uint8), (8, 8, 3)).copy()
    else:
        quarter = texture(_WALL_TEXELS, _WALL_TEXELS, rng)
        half = np.concatenate((quarter, quarter[::-1]))
        picture = np.concatenate((half, half[:, ::-1]), axis=1)  # mirrored: repeated, it has no seams
    return Surface(picture, float(rng.uniform(0.0, 0.3)), float(rng.uniform(0.0, 0.5)))
