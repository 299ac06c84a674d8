"""Binary masks: checking, packing to bits, and COCO's run lengths."""

import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from maskval.errors import InvalidMaskError

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
        areas = np.bitwise_count(words).sum(axis=(1, 2), dtype=np.int64)
        for name, array in (("words", words), ("areas_px", areas)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __reduce__(self) -> tuple[type[Self], tuple[NDArray[np.uint64], int]]:
        # What comes out of a pickle is not writeable either: Numba would compile the kernel anew for arrays that are.
        return type(self), (self.words, self.width)

    @classmethod
    def pack(cls, masks: NDArray[Any]) -> Self:
        """The packed form of binary masks.

        Args:
            masks: (K, H, W) or one mask (H, W), bool, or uint8 of 0 and 1.

        Raises:
            InvalidMaskError: If the shape, the type or a value is another.
        """
        stack = _binary(masks, dimensions=(2, 3))
        if stack.ndim == 2:
            stack = stack[None]
        count, height, width = stack.shape
        packed = np.zeros((count, height, -(-width // 64) * 8), dtype=np.uint8)
        packed[:, :, : -(-width // 8)] = np.packbits(stack, axis=-1, bitorder="little")
        return cls(packed.view("<u8").astype(np.uint64, copy=False), width)

    @classmethod
    def from_rle(cls, runs: Iterable[Sequence[int] | str | bytes], height: int, width: int) -> Self:
        """The packed form of COCO run lengths, plain or compressed, the counts of one mask after the other."""
        masks = [mask_from_rle(counts, height, width) for counts in runs]
        return cls.pack(np.array(masks, dtype=np.bool_).reshape(len(masks), height, width))

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
    if min(height, width) < 1 or height * width > MAXIMUM_PIXELS:
        raise InvalidMaskError(f"a mask must have 1 to {MAXIMUM_PIXELS} pixels, but has {height} x {width}")
    runs = _runs(counts)
    if min(runs, default=0) < 0:
        raise InvalidMaskError(f"counts must be whole numbers >= 0, but are {str(counts)[:60]}")
    # Python's integers: a sum in 64 bits may wrap around to the right number.
    if sum(runs) != height * width:
        raise InvalidMaskError(f"counts must add up to {height} x {width} = {height * width}, but to {sum(runs)}")
    return np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape((height, width), order="F")


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


def _binary(mask: NDArray[Any], dimensions: tuple[int, ...] = (2,)) -> NDArray[np.bool_]:
    array = np.asarray(mask)
    if array.ndim not in dimensions:
        wanted = " or ".join("(K, H, W)" if n == 3 else "(H, W)" for n in dimensions)
        raise InvalidMaskError(f"a mask must have shape {wanted}, but has {array.shape}")
    if array.dtype == np.bool_:
        return array
    if array.dtype != np.uint8:
        raise InvalidMaskError(f"a mask must be bool or uint8, but is {array.dtype}")
    if array.size and array.max() > 1:
        raise InvalidMaskError(f"a uint8 mask must hold 0 and 1, but holds {array.max()}")
    return array.view(np.bool_)
