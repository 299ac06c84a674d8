"""BOP's images: masks of 0 and 255, and depth of 16 bits in steps of `depth_scale` millimetres."""

import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from maskval.bop.fields import M_PER_MM
from maskval.errors import InvalidArgumentError, InvalidFileError
from maskval.inputs.files import MOST_IMAGE, check_input, read_input
from maskval.masks import MAXIMUM_PIXELS

_PNG = b"\x89PNG\r\n\x1a\n"  # then the size of a block, IHDR, and the image's width and height
_LOSSY = (".jpg", ".jpeg")
_PNG_HEADER = 24  # bytes of these


def mask_path(scene: Path, im_id: int, part: int, *, visible: bool = True) -> Path:
    """Where the mask of a part is.

    Args:
        scene: Folder of the scene.
        im_id: Image in the scene.
        part: Index of the part in the image's list of `scene_gt.json`.
        visible: The mask of what is visible of it, not of all of it.
    """
    return scene / ("mask_visib" if visible else "mask") / f"{im_id:06d}_{part:06d}.png"


def read_mask(path: Path) -> NDArray[np.bool_]:
    """The mask of a PNG file of 0 and 255, (H, W).

    Raises:
        InvalidFileError: If it is no image, or holds another value.
    """
    others = [path.with_suffix(ending).name for ending in _LOSSY if path.with_suffix(ending).exists()]
    if others and not path.exists():
        raise InvalidFileError(
            f"{path} does not exist: expected a PNG file, but found {others[0]}: JPEG makes other values of a mask's"
        )
    image = _read(path)
    if image.ndim != 2 or image.dtype != np.uint8:
        raise InvalidFileError(f"{path}: expected a grey image of 0 and 255, but found {image.dtype} {image.shape}")
    other = image[(image != 0) & (image != 255)]
    if other.size:
        raise InvalidFileError(
            f"{path}: expected a grey image of 0 and 255, but found {int(other[0])}, and {other.size} "
            "pixels of other values in all (JPEG makes such)"
        )
    return image > 0


def write_mask(path: Path, mask: NDArray[np.bool_]) -> None:
    """Writes a mask, (H, W), as a PNG file of 0 and 255."""
    _write(path, np.asarray(mask, dtype=np.bool_).astype(np.uint8) * 255)


def read_depth(path: Path, depth_scale: float = 1.0) -> NDArray[np.float64]:
    """The z-depth of a 16-bit PNG file, (H, W), metres; 0 where nothing was measured.

    Args:
        path: The file.
        depth_scale: Millimetres for each step, from the image's camera.
    """
    image = _read(path)
    if image.ndim != 2 or image.dtype != np.uint16:
        raise InvalidFileError(f"{path}: expected a grey image of 16 bits, but found {image.dtype} {image.shape}")
    return image * (depth_scale * M_PER_MM)


def write_depth(path: Path, depth: NDArray[Any], depth_scale: float = 1.0) -> None:
    """Writes z-depth as a 16-bit PNG file, rounded to whole steps.

    Args:
        path: The file.
        depth: (H, W), metres, at most 65,535 steps.
        depth_scale: Millimetres for each step, which the image's camera must say.
    """
    steps = np.rint(np.asarray(depth, dtype=np.float64) / (depth_scale * M_PER_MM))
    if not ((steps >= 0) & (steps <= 65_535)).all():
        raise InvalidArgumentError(
            f"depth must be 0 to 65,535 steps of {depth_scale:g} mm, but is up to {steps.max():g}"
        )
    _write(path, steps.astype(np.uint16))


def read_photo(path: Path) -> NDArray[np.uint8]:
    """The picture of a file of 8 bits a channel, grey or colour, (H, W, 3), RGB.

    Raises:
        InvalidFileError: If it is none.
    """
    image = _read(path)
    if image.dtype != np.uint8 or image.ndim > 3 or (image.ndim == 3 and image.shape[2] not in (3, 4)):
        raise InvalidFileError(f"{path}: expected a picture of 8 bits, but found {image.dtype} {image.shape}")
    conversion = cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(image[..., :3] if image.ndim == 3 else image), conversion))


def png_size(path: Path) -> tuple[int, int]:
    """Height and width of a PNG file, pixels, from its header.

    Raises:
        InvalidFileError: If it is none.
    """
    with check_input(path).open("rb") as file:
        header = file.read(_PNG_HEADER)
    if not header.startswith(_PNG) or len(header) < _PNG_HEADER:
        raise InvalidFileError(f"{path}: expected a PNG file, but it does not begin as one")
    width, height = struct.unpack(">II", header[16:])
    return height, width


def _read(path: Path) -> NDArray[Any]:
    content = read_input(path, MOST_IMAGE)
    if content.startswith(_PNG) and len(content) >= _PNG_HEADER:
        width, height = struct.unpack(">II", content[16:_PNG_HEADER])
        if width * height > MAXIMUM_PIXELS:
            raise InvalidFileError(f"{path}: expected at most {MAXIMUM_PIXELS} pixels, but found {width} x {height}")
    try:
        image: NDArray[Any] | None = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # an empty file
        image = None
    if image is None:
        raise InvalidFileError(f"{path}: expected an image, but it cannot be read as one")
    return image


def _write(path: Path, image: NDArray[Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    # Half the size of OpenCV's own choice for depth, in less time.
    if not cv2.imwrite(str(path), image, [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_DEFAULT]):
        raise OSError(f"{path} could not be written")
