"""What surfaces look like: colours, gloss, and textures made in code."""

from typing import NamedTuple

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.model.apply_conditions import BELT_MATERIAL
from sim.model.fixtures import FLOOR_MATERIAL

_SIZE = 512  # px of a texture's side
_SEED = 0  # of the textures' grain


class Look(NamedTuple):
    """Colour, share of the light in highlights, how small these are (both 0 to 1), and the texture's name, if any."""

    rgb: tuple[float, float, float]
    specular: float
    shininess: float
    texture: str | None = None


LOOKS = {
    "aluminium": Look((0.74, 0.75, 0.77), 0.35, 0.35),
    "brushed": Look((0.74, 0.75, 0.77), 0.35, 0.3, "brushed"),
    "lid": Look((0.40, 0.57, 0.69), 0.4, 0.6),
    "seal": Look((0.07, 0.07, 0.08), 0.3, 0.3),
    "anodised": Look((0.16, 0.17, 0.19), 0.5, 0.4),
    "steel": Look((0.55, 0.57, 0.60), 0.9, 0.5),
    "rubber": Look((0.06, 0.06, 0.06), 0.15, 0.1),
    "glass": Look((0.02, 0.03, 0.06), 1.0, 0.9),
    "paint": Look((0.26, 0.29, 0.33), 0.35, 0.4),
    "plastic": Look((0.12, 0.30, 0.56), 0.2, 0.5),
    "laminate": Look((0.80, 0.80, 0.78), 0.15, 0.3),
    "tape": Look((0.80, 0.64, 0.12), 0.0, 0.1),
    "motor": Look((0.16, 0.36, 0.44), 0.4, 0.4),
}
_GROUND = {  # of the materials of the cell's own geoms: what one repeat measures in m, and the look
    BELT_MATERIAL: (0.20, Look((0.36, 0.47, 0.41), 0.12, 0.15, "rubber")),
    FLOOR_MATERIAL: (1.60, Look((0.72, 0.72, 0.72), 0.0, 0.2, "concrete")),
}


def add_materials(spec: mujoco.MjSpec) -> None:
    """Adds the materials of `LOOKS`, and gives belt and floor of the cell a texture."""
    for name, picture in {"brushed": _brushed(), "rubber": _rubber(), "concrete": _concrete()}.items():
        image = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=_SIZE, height=_SIZE, nchannel=3)
        image.data = np.repeat(picture[..., None], 3, axis=2).tobytes()
    for name, look in LOOKS.items():
        material = spec.add_material(name=f"look_{name}", reflectance=0.0, texrepeat=[4.0, 1.0])
        _set(material, look)
    for name, (metres, look) in _GROUND.items():
        material = spec.material(name)
        material.texuniform, material.texrepeat = True, [1.0 / metres] * 2
        _set(material, look)


def _set(material: mujoco.MjsMaterial, look: Look) -> None:
    material.rgba, material.specular, material.shininess = [*look.rgb, 1.0], look.specular, look.shininess
    if look.texture is not None:
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = look.texture


def _brushed() -> NDArray[np.uint8]:
    """Fine streaks along the second direction."""
    rng = np.random.default_rng(_SEED)
    streaks = cv2.blur(rng.normal(size=(_SIZE, _SIZE)), (1, 127), borderType=cv2.BORDER_REFLECT)
    return _grey(0.88 + 0.05 * streaks / streaks.std())


def _rubber() -> NDArray[np.uint8]:
    """A woven belt: fine crossed ribs with a little grain."""
    rng = np.random.default_rng(_SEED)
    v, u = np.indices((_SIZE, _SIZE)) * 2 * np.pi / _SIZE
    ribs = np.sin(40 * (u + v)) * np.sin(40 * (u - v))
    grain = cv2.GaussianBlur(rng.normal(size=(_SIZE, _SIZE)), (0, 0), 1.0, borderType=cv2.BORDER_REFLECT)
    return _grey(0.90 + 0.05 * ribs + 0.03 * grain / grain.std())


def _concrete() -> NDArray[np.uint8]:
    """A sealed floor: clouds and grain."""
    rng = np.random.default_rng(_SEED)
    total = np.zeros((_SIZE, _SIZE))
    for cells, weight in ((4, 0.4), (16, 0.3), (64, 0.3), (256, 0.4)):
        grid = np.tile(rng.normal(size=(cells, cells)), (3, 3))  # so that its repeats join
        whole = cv2.resize(grid, (3 * _SIZE, 3 * _SIZE), interpolation=cv2.INTER_CUBIC)
        total += weight * whole[_SIZE : 2 * _SIZE, _SIZE : 2 * _SIZE]
    return _grey(0.93 + 0.025 * total)


def _grey(share: NDArray[np.float64]) -> NDArray[np.uint8]:
    return np.clip(np.rint(255 * share), 0, 255).astype(np.uint8)
