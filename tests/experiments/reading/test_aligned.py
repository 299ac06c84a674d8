from decimal import Decimal

from experiments.reading.aligned import aligned, text_of


def test_words_stand_left_and_numbers_right() -> None:
    told = aligned(["name", "n"], [("a", 1), ("long name", 200), (None, None)], 80)
    assert told.splitlines() == [
        "name         n",
        "--------------",
        "a            1",
        "long name  200",
        "–            –",
    ]


def test_words_are_shortened_before_columns_are_left_out() -> None:
    lines = aligned(["word", "number"], [("w" * 50, 123456)], 20).splitlines()
    assert lines[2] == f"{'w' * 11}…  123456"
    assert max(map(len, lines)) == 20


def test_a_number_is_never_shortened() -> None:
    lines = aligned(["a", "b", "c"], [(111111, 222222, 333333)], 14).splitlines()
    assert lines[:3] == ["     a       b", "--------------", "111111  222222"]
    assert " ".join(lines[3:]) == "no room for c: --csv or --json prints all"


def test_values_are_told_in_one_line_and_six_digits() -> None:
    assert text_of(1 / 3) == "0.333333"
    assert text_of(Decimal("2.50")) == "2.50"
    assert text_of(True) == "true"
    assert text_of([0.5, None, (1,)]) == "[0.5, –, [1]]"
    assert text_of("two\nlines") == "two lines"
