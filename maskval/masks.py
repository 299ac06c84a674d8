"""Binary masks: checking, packing to bits, and COCO's run lengths."""

import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import Any, Literal, Self, cast

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidArgumentError, InvalidMaskError
from maskval.inputs.arrays import floats

Implementation = Literal["numba", "numpy"]
Packed = tuple[NDArray[np.uint64], NDArray[np.int64], bool]

# No camera has as many: a size beyond it is a broken file, which must not make anything allocate it.
MAXIMUM_PIXELS = 2**28
# COCO's own code holds a number in 64 bits: 13 letters of 5 bits.
_LETTERS = 13


@dataclass(frozen=True, slots=True, eq=False)
class PackedMasks:
    """K masks of one size, 64 pixels of a row in a word, so that an overlap is an AND and a count of bits.

    Build it with `pack` or `from_rle`, once for as many calls of `silhouette_iou` as share the masks.

    Args:
        words: Bit j of words[k, v, w] is pixel [v, 64 w + j] of mask k, (K, H, ceil(W / 64)); bits beyond W are 0.
        width: Image width W, pixels.

    Attributes:
        areas_px: Pixels in each mask, (K,).

    Raises:
        InvalidMaskError: If the words are not of this shape and type.
    """

    words: NDArray[np.uint64]
    width: int
    areas_px: NDArray[np.int64] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        words = np.array(self.words, order="C")
        if words.dtype != np.uint64 or words.ndim != 3 or words.shape[2] != -(-self.width // 64):
            raise InvalidMaskError(
                f"words must be uint64 of shape (K, H, {-(-self.width // 64)}), but are {words.dtype} of {words.shape}"
            )
        self._freeze(words, np.bitwise_count(words).sum(axis=(1, 2), dtype=np.int64))

    def __reduce__(self) -> tuple[type[Self], tuple[NDArray[np.uint64], int]]:
        # What comes out of a pickle is not writeable either: Numba would compile the kernel anew for arrays that are.
        return type(self), (self.words, self.width)

    def _freeze(self, words: NDArray[np.uint64], areas_px: NDArray[np.int64]) -> None:
        words.setflags(write=False)
        areas_px.setflags(write=False)
        object.__setattr__(self, "words", words)
        object.__setattr__(self, "areas_px", areas_px)

    @classmethod
    def pack(cls, masks: NDArray[Any], *, implementation: Implementation = "numba") -> Self:
        """The packed form of binary masks.

        Args:
            masks: (K, H, W) or one mask (H, W), bool, or uint8 of 0 and 1.
            implementation: "numba", or the slower "numpy" of the same result, which compiles nothing.

        Raises:
            InvalidMaskError: If the shape, the type or a value is another.
        """
        stack = _mask_array(masks, dimensions=(2, 3))
        height, width = stack.shape[-2:]
        pixels = np.ascontiguousarray(stack).reshape(-1).view(np.uint8)
        pixels.setflags(write=False)  # one type for Numba
        words, areas_px, is_binary = _packer(implementation)(
            pixels, (len(stack) if stack.ndim == 3 else 1, height, width)
        )
        if stack.dtype == np.uint8 and not is_binary:
            raise _not_binary(stack)
        # Both are new and of the right shape: nothing to check, copy or count.
        packed = object.__new__(cls)
        object.__setattr__(packed, "width", width)
        packed._freeze(words, areas_px)
        return packed

    @classmethod
    def from_rle(
        cls,
        runs: Iterable[Sequence[int] | str | bytes],
        height: int,
        width: int,
        *,
        implementation: Implementation = "numba",
    ) -> Self:
        """The packed form of COCO run lengths, plain or compressed, the counts of one mask after the other."""
        masks = [mask_from_rle(counts, height, width) for counts in runs]
        stack = np.array(masks, dtype=np.bool_).reshape(len(masks), height, width)
        return cls.pack(stack, implementation=implementation)

    def unpack(self) -> NDArray[np.bool_]:
        """The masks as pixels, (K, H, W)."""
        bits = np.unpackbits(self.words.astype("<u8").view(np.uint8), axis=-1, bitorder="little")
        return bits[..., : self.width].view(np.bool_)

    @property
    def height(self) -> int:
        """Image height H, pixels."""
        return int(self.words.shape[1])

    def __len__(self) -> int:
        return len(self.words)


def mask_iou(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Intersection over union of two masks, in [0, 1]; 0 when both are empty: nothing agrees.

    Args:
        a: (H, W), bool, or uint8 of 0 and 1.
        b: Mask of the same size.
    """
    first, second = _binary(a), _binary(b)
    if first.shape != second.shape:
        raise InvalidMaskError(f"masks must have one size, but have {first.shape} and {second.shape}")
    union = np.count_nonzero(first | second)
    return np.count_nonzero(first & second) / union if union else 0.0


def rle_counts(mask: NDArray[Any]) -> list[int]:
    """COCO's uncompressed run lengths: column by column, zeros first.

    Args:
        mask: (H, W), bool, or uint8 of 0 and 1.
    """
    pixels = _binary(mask).ravel(order="F")
    changes = np.flatnonzero(np.diff(pixels, prepend=False))
    counts: list[int] = np.diff(changes, prepend=0, append=pixels.size).tolist()
    return counts


def mask_from_rle(counts: Sequence[int] | str | bytes, height: int, width: int) -> NDArray[np.bool_]:
    """The mask of COCO's run lengths, (H, W).

    Args:
        counts: Lengths of the runs of zeros and ones in turn, zeros first, column by column; or their compressed form,
            as text or as the bytes that `pycocotools.mask.encode` returns.
        height: Image height H, pixels.
        width: Image width W, pixels.

    Raises:
        InvalidMaskError: If the image has no pixels or more than 2^28, a count is negative or no whole number, or the
            counts do not add up to H W.
    """
    _check_size(height, width)
    runs = _runs(counts)
    if min(runs, default=0) < 0:
        raise InvalidMaskError(f"counts must be whole numbers >= 0, but are {str(counts)[:60]}")
    # Python's integers: a sum in 64 bits may wrap around to the right number.
    if sum(runs) != height * width:
        raise InvalidMaskError(f"counts must add up to {height} x {width} = {height * width}, but to {sum(runs)}")
    return np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape((height, width), order="F")


def mask_from_polygons(polygons: Sequence[Sequence[float]], height: int, width: int) -> NDArray[np.bool_]:
    """The mask of COCO's polygons, (H, W), drawn as COCO draws them.

    Args:
        polygons: The corners of each part of the mask, u and v in turn, three corners or more, pixels.
        height: Image height H, pixels.
        width: Image width W, pixels.

    Raises:
        InvalidMaskError: If there is no polygon, one has fewer corners or one outside of the image, or the image's
            size is none.
    """
    _check_size(height, width)
    if not polygons:
        raise InvalidMaskError("a mask must have at least one polygon, but has none")
    for polygon in polygons:
        corners = floats("a polygon", polygon, InvalidMaskError)
        if corners.ndim != 1 or len(corners) < 6 or len(corners) % 2:
            raise InvalidMaskError(f"a polygon must have u and v of at least 3 corners, but has {len(polygon)} numbers")
        places = corners.reshape(-1, 2)
        if not ((places >= -1) & (places <= (width + 1, height + 1))).all():
            raise InvalidMaskError(f"polygons must lie in the image of {height} x {width}, but reach beyond it")
    drawn = import_module("pycocotools.mask").frPyObjects([list(polygon) for polygon in polygons], height, width)
    mask: NDArray[np.bool_] = np.any([mask_from_rle(part["counts"], height, width) for part in drawn], axis=0)
    return mask


def _check_size(height: int, width: int) -> None:
    if min(height, width) < 1 or height * width > MAXIMUM_PIXELS:
        raise InvalidMaskError(f"a mask must have 1 to {MAXIMUM_PIXELS} pixels, but has {height} x {width}")


def _runs(counts: Sequence[int] | str | bytes) -> list[int]:
    """The run lengths, plain."""
    if isinstance(counts, bytes):
        counts = counts.decode("latin-1")
    if isinstance(counts, str):
        return _decompressed(counts)
    try:
        return [operator.index(count) for count in counts]
    except TypeError as error:
        raise InvalidMaskError(f"counts must be whole numbers >= 0, but are {str(counts)[:60]}") from error


def _decompressed(text: str) -> list[int]:
    """The run lengths of COCO's compressed form: 5 bits a letter, and each length less the one before the last."""
    counts: list[int] = []
    value = shift = 0
    for letter in text:
        bits = ord(letter) - 48
        if not 0 <= bits < 64:
            raise InvalidMaskError(f"compressed run lengths must be letters from '0' to 'o', but hold {letter!r}")
        if shift == 5 * _LETTERS:
            raise InvalidMaskError(f"compressed run lengths must have at most {_LETTERS} letters a number")
        value |= (bits & 31) << shift
        shift += 5
        if bits & 32:  # another letter follows
            continue
        if bits & 16:  # the number is negative
            value -= 1 << shift
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
        value = shift = 0
    if shift:
        raise InvalidMaskError("compressed run lengths must end with a number, but are cut off")
    return counts


@cache
def _packer(implementation: Implementation) -> Callable[[NDArray[np.uint8], tuple[int, int, int]], Packed]:
    """What packs; Numba is imported at its first use, because it alone takes longer than this package."""
    if implementation == "numba":
        return cast("Callable[..., Packed]", import_module("maskval.packing").pack)
    if implementation == "numpy":
        return _pack
    raise InvalidArgumentError(f"implementation must be one of ['numba', 'numpy'], but is {implementation!r}")


def _pack(pixels: NDArray[np.uint8], shape: tuple[int, int, int]) -> Packed:
    """See `packing.pack`."""
    count, height, width = shape
    bits = np.zeros((count, height, -(-width // 64) * 8), dtype=np.uint8)
    bits[:, :, : -(-width // 8)] = np.packbits(pixels.reshape(shape), axis=-1, bitorder="little")
    words = bits.view("<u8").astype(np.uint64, copy=False)
    return words, np.bitwise_count(words).sum(axis=(1, 2), dtype=np.int64), bool(pixels.max(initial=0) <= 1)


def _binary(mask: NDArray[Any]) -> NDArray[np.bool_]:
    array = _mask_array(mask, dimensions=(2,))
    if array.dtype == np.uint8 and array.max(initial=0) > 1:
        raise _not_binary(array)
    return array.view(np.bool_)


def _mask_array(mask: NDArray[Any], dimensions: tuple[int, ...]) -> NDArray[Any]:
    try:
        array = np.asarray(mask)
    except ValueError as error:  # ragged lists
        raise InvalidMaskError(f"masks must be of one size, but are not: {error}") from error
    if array.ndim not in dimensions:
        wanted = " or ".join("(K, H, W)" if n == 3 else "(H, W)" for n in dimensions)
        raise InvalidMaskError(f"a mask must have shape {wanted}, but has {array.shape}")
    if array.dtype not in (np.bool_, np.uint8):
        raise InvalidMaskError(f"a mask must be bool or uint8, but is {array.dtype}")
    return array


def _not_binary(array: NDArray[np.uint8]) -> InvalidMaskError:
    return InvalidMaskError(f"a uint8 mask must hold 0 and 1, but holds {array.max()}")
