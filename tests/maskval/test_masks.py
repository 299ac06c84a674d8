import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from maskval import InvalidMaskError, PackedMasks, mask_from_rle, mask_iou, rle_counts
from maskval.masks import Implementation

IMPLEMENTATIONS: tuple[Implementation, ...] = ("numba", "numpy")
images = hnp.arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 140)))


@given(images)
def test_a_mask_survives_its_run_lengths(mask) -> None:
    counts = rle_counts(mask)
    assert sum(counts) == mask.size
    assert all(count > 0 for count in counts[1:])
    np.testing.assert_array_equal(mask_from_rle(counts, *mask.shape), mask)


def test_run_lengths_go_down_the_columns_and_begin_with_zeros() -> None:
    # Column by column: 0 1 | 1 1 | 0 0.
    assert rle_counts(np.array([[0, 1, 0], [1, 1, 0]], dtype=np.uint8)) == [1, 3, 2]
    # A mask that begins with a one begins with no zeros.
    assert rle_counts(np.ones((2, 2), dtype=bool)) == [0, 4]
    assert rle_counts(np.zeros((2, 2), dtype=bool)) == [4]
    # Runs of no length are legal to read.
    np.testing.assert_array_equal(mask_from_rle([0, 1, 0, 2, 1], 2, 2), [[True, True], [True, False]])


@given(images)
def test_packed_bits_are_the_pixels(mask) -> None:
    packed = PackedMasks.pack(np.stack((mask, ~mask)))
    assert (len(packed), packed.height, packed.width) == (2, *mask.shape)
    assert packed.areas_px.tolist() == [np.count_nonzero(mask), np.count_nonzero(~mask)]
    bits = (packed.words[..., None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    pixels = bits.reshape(2, mask.shape[0], -1)
    np.testing.assert_array_equal(pixels[0, :, : mask.shape[1]], mask)
    assert not pixels[:, :, mask.shape[1] :].any()


@given(images)
def test_packing_run_lengths_and_zeros_and_ones_is_packing_the_mask(mask) -> None:
    words = PackedMasks.pack(mask).words
    np.testing.assert_array_equal(PackedMasks.pack(mask.astype(np.uint8)).words, words)
    np.testing.assert_array_equal(PackedMasks.from_rle([rle_counts(mask)], *mask.shape).words, words)


@given(images, st.sampled_from(("whole", "every other", "transposed", "cut out")))
def test_numba_and_numpy_pack_the_same_bits(mask, how) -> None:
    stack = np.stack((mask, ~mask, np.roll(mask, 1)))
    stack = {
        "whole": stack,
        "every other": stack[::2, :, ::-1],
        "transposed": stack.transpose(0, 2, 1),
        "cut out": stack[:, : mask.shape[0] // 2 + 1, mask.shape[1] // 3 :],
    }[how]
    for kind in (np.bool_, np.uint8):
        fast, plain = (PackedMasks.pack(stack.astype(kind, order="K"), implementation=name) for name in IMPLEMENTATIONS)
        assert (fast.words.dtype, fast.areas_px.dtype, fast.width) == (np.uint64, np.int64, stack.shape[2])
        np.testing.assert_array_equal(fast.words, plain.words)
        np.testing.assert_array_equal(fast.areas_px, plain.areas_px)
        assert fast.areas_px.tolist() == np.count_nonzero(stack, axis=(1, 2)).tolist()


@pytest.mark.parametrize("implementation", IMPLEMENTATIONS)
@pytest.mark.parametrize(
    ("size", "place"), [((1, 5), 4), ((2, 40), 79), ((3, 64), 100), ((2, 100), 70), ((2, 100), 199)]
)
def test_a_pixel_that_is_neither_0_nor_1_is_refused_wherever_it_is(implementation, size, place) -> None:
    mask = np.ones(size, dtype=np.uint8)
    assert PackedMasks.pack(mask, implementation=implementation).areas_px.tolist() == [mask.size]
    mask.flat[place] = 2
    with pytest.raises(InvalidMaskError, match="must hold 0 and 1, but holds 2"):
        PackedMasks.pack(mask, implementation=implementation)


def test_packing_no_masks_keeps_the_size() -> None:
    for packed in (PackedMasks.pack(np.zeros((0, 4, 70), dtype=bool)), PackedMasks.from_rle([], 4, 70)):
        assert (len(packed), packed.height, packed.width) == (0, 4, 70)
        assert packed.areas_px.shape == (0,)


def test_nobody_can_write_to_packed_masks() -> None:
    masks = np.zeros((1, 4, 70), dtype=bool)
    for implementation in IMPLEMENTATIONS:
        packed = PackedMasks.pack(masks, implementation=implementation)
        for array in (packed.words, packed.areas_px):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1
    masks[0, 0, 0] = True  # the caller's array stays writeable


def test_mask_iou_of_shifted_squares() -> None:
    a, b = np.zeros((2, 20, 30), dtype=bool)
    a[5:15, 5:15] = b[5:15, 8:18] = True
    assert mask_iou(a, b) == 10 * 7 / (10 * 13)
    assert mask_iou(a, a) == 1
    assert mask_iou(a, np.roll(a, 12, axis=1)) == 0
    assert mask_iou(a & False, b & False) == 0


FLAT = np.zeros((2, 3), dtype=bool)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: PackedMasks.pack(np.zeros((2, 2, 2, 2), dtype=bool)), r"but has \(2, 2, 2, 2\)"),
        (lambda: PackedMasks.pack(FLAT.astype(np.uint8) + 255), "must hold 0 and 1, but holds 255"),
        (lambda: PackedMasks.pack(FLAT.astype(np.float32)), "bool or uint8, but is float32"),
        (lambda: PackedMasks(np.zeros((1, 2, 2), dtype=np.uint64), 64), r"\(K, H, 1\), but are uint64 of \(1, 2, 2\)"),
        (lambda: PackedMasks(np.zeros((1, 2, 2)), 128), "words must be uint64 .* but are float64"),
        (lambda: rle_counts(FLAT[0]), r"shape \(H, W\), but has \(3,\)"),
        (lambda: mask_iou(FLAT, FLAT.T), r"one size, but have \(2, 3\) and \(3, 2\)"),
        (lambda: mask_from_rle([1, 2], 2, 3), "add up to 2 x 3 = 6, but to 3"),
        (lambda: mask_from_rle([7, -1], 2, 3), r"whole numbers >= 0, but are \[7, -1\]"),
        (lambda: mask_from_rle([1.5, 4.5], 2, 3), "whole numbers >= 0"),
        (lambda: mask_from_rle(["P"], 2, 3), r"whole numbers >= 0, but are \['P'\]"),
        (lambda: mask_from_rle("P", 2, 3), "must end with a number, but are cut off"),
    ],
)
def test_bad_masks_are_refused(call, words) -> None:
    with pytest.raises(InvalidMaskError, match=words):
        call()
