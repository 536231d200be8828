from transcript import difference


def test_equal_words_agree_wherever_the_lines_break() -> None:
    printed = ["mode     f [Hz]", "", " ──── ", "  1    4.75  ", "a note in", "two lines"]
    assert difference(["mode  f [Hz]", " 1  4.75", "a note", "in two lines"], printed) == ""


def test_numbers_may_differ_a_little_and_words_may_not() -> None:
    assert difference(["1 4.7549(9) Hz"], ["1 4.7550(12) Hz"]) == ""
    assert difference(["1 4.7549 Hz"], ["1 4.7551 Hz"]) != ""
    assert difference(["150000.000 Pa"], ["150001.400 Pa"]) == ""
    assert difference(["15 hits"], ["16 hits"]) != ""
    assert difference(["1 4.7549 Hz"], ["1 4.7549 kHz"]) != ""
    assert difference(["read 7.06, so"], ["read 7.05, so"]) == ""


def test_an_ellipsis_stands_for_any_words() -> None:
    assert difference(["first", "...", "last"], ["first", "a", "b", "last"]) == ""
    assert difference(["first", "..."], ["first", "a", "b"]) == ""
    assert difference(["..."], ["a", "b"]) == ""
    assert difference(["first", "...", "1.0", "...", "last"], ["first", "a", "1.01", "b", "last"]) == ""
    assert difference(["first", "...", "2.0", "...", "last"], ["first", "a", "1.0", "b", "last"]) != ""
    assert difference(["first", "...", "last"], ["first", "a"]) != ""


def test_what_is_missing_or_too_much_is_named() -> None:
    assert "second" in difference(["first", "second"], ["first"])
    assert "second" in difference(["first"], ["first", "second"])


def test_durations_are_not_compared() -> None:
    assert difference(["24/24 0:00:01"], ["24/24 0:00:14"]) == ""


def test_a_gap_may_differ_by_its_last_digit_and_a_count_not():
    assert not difference(["The gap of 244 noise units"], ["The gap of 245 noise units"])
    assert difference(["The gap of 244 noise units"], ["The gap of 246 noise units"])
    assert difference(["all 244 tests"], ["all 245 tests"])
