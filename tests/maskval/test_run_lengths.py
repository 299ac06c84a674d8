"""Run lengths of other programs: what pycocotools writes, and files that are broken or meant to do harm."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pycocotools import mask as coco

from maskval import InvalidMaskError, PackedMasks, mask_from_rle
from maskval.masks import MAXIMUM_PIXELS

images = hnp.arrays(np.bool_, st.tuples(st.integers(1, 60), st.integers(1, 60)))


@given(images)
def test_what_pycocotools_encodes_is_read_as_bytes_and_as_text(mask) -> None:
    encoded = coco.encode(np.asfortranarray(mask, dtype=np.uint8))["counts"]
    assert type(encoded) is bytes
    for counts in (encoded, encoded.decode("ascii")):
        np.testing.assert_array_equal(mask_from_rle(counts, *mask.shape), mask)
        np.testing.assert_array_equal(PackedMasks.from_rle([counts], *mask.shape).words, PackedMasks.pack(mask).words)


def test_counts_may_be_an_array_of_numpy() -> None:
    assert mask_from_rle(np.array([1, 2, 1], dtype=np.uint32), 2, 2).tolist() == [[False, True], [True, False]]


# The sum of the first is H W in 64 bits; each other one is more than a machine has memory for.
@pytest.mark.parametrize(
    ("counts", "height", "width", "words"),
    [
        ([2**62, 2**62, 2**62, 2**62 + 76_800], 240, 320, f"add up to 240 x 320 = 76800, but to {2**64 + 76_800}"),
        ([2**64 + 6], 2, 3, f"add up to 2 x 3 = 6, but to {2**64 + 6}"),
        (np.array([2**63, 2**63, 6], dtype=np.uint64), 2, 3, f"but to {2**64 + 6}"),
        ([10**12], 10**6, 10**6, f"a mask must have 1 to {MAXIMUM_PIXELS} pixels, but has 1000000 x 1000000"),
        ([2**64], 2**32, 2**32, "pixels, but has 4294967296 x 4294967296"),
        ([6], -2, -3, "pixels, but has -2 x -3"),
        ([0], 0, 5, "pixels, but has 0 x 5"),
        ("V" + "P" * 12 + "0", 2, 3, "compressed run lengths must have at most 13 letters a number"),
        ("ooooooooooo3", 2, 3, "add up to 2 x 3 = 6, but to "),
        (b"6\xff", 2, 3, re.escape(r"letters from '0' to 'o', but hold 'ÿ'")),
        (None, 2, 3, "whole numbers >= 0, but are None"),
        ([[6]], 2, 3, r"whole numbers >= 0, but are \[\[6\]\]"),
    ],
)
def test_run_lengths_that_no_image_has_are_refused_before_anything_is_allocated(
    counts: Any, height: int, width: int, words: str
) -> None:
    with pytest.raises(InvalidMaskError, match=words):
        mask_from_rle(counts, height, width)


def test_an_image_has_at_most_the_greatest_size() -> None:
    with pytest.raises(InvalidMaskError, match="but to 0"):
        mask_from_rle([0], 1, MAXIMUM_PIXELS)
    with pytest.raises(InvalidMaskError, match="pixels, but has 1 x"):
        mask_from_rle([0], 1, MAXIMUM_PIXELS + 1)


def test_a_number_may_have_thirteen_letters() -> None:
    # 6 in thirteen times 5 bits, the lowest first; 32 says that another letter follows.
    letters = [6 + 32] + 11 * [0 + 32] + [0]
    text = "".join(chr(48 + bits) for bits in letters)
    assert (len(text), mask_from_rle(text, 2, 3).shape) == (13, (2, 3))
