from datetime import date
from math import inf, nan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modallab.core.digits import (
    count_with_noun,
    four_places,
    iso_date,
    list_in_words,
    number_ranges,
    number_with_sigma,
    percent_text,
    probability_text,
    relative_difference,
    rounded_to_sigma,
    scientific_text,
    share_text,
    short_number,
    significant_digits,
    three_digits,
    with_interval,
    with_nonbreaking_spaces,
    with_sigma,
)


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (4.80213, 0.00031, "4.8021 ± 0.0003"),
        (4.80213, 0.00014, "4.80213 ± 0.00014"),
        (87.9, 0.0996, "87.90 ± 0.10"),
        (4392.3, 12.0, "4392 ± 12"),
        (4392.3, 130.0, "4392 ± 130"),
        (30.86, nan, "30.86 (± unknown)"),
        (30.86, inf, "30.86 (± unknown)"),
        (30.86, 0.0, "30.86 (± unknown)"),
        (nan, 0.1, "unknown"),
        (-0.5, 0.1, "−0.50 ± 0.10"),
    ],
)
def test_a_value_has_the_digits_that_its_sigma_bears(value, sigma, text):
    assert with_sigma(value, sigma) == text


@pytest.mark.parametrize(
    ("value", "sigma", "text"),
    [
        (4.80213, 0.00031, "4.8021(3)"),
        (4.80213, 0.00014, "4.80213(14)"),
        (4392.3, 12.0, "4392(12)"),
        (43.9, 1.4, "43.9(1.4)"),
        (30.86, nan, "30.86(?)"),
        (nan, 1.0, "unknown"),
    ],
)
def test_the_concise_form_counts_in_the_last_places(value, sigma, text):
    assert number_with_sigma(value, sigma) == text


def test_a_truth_is_written_to_the_places_of_the_reading():
    assert (
        rounded_to_sigma(4.8029912, 0.0003),
        rounded_to_sigma(4.8029912, nan),
        rounded_to_sigma(nan, 1.0),
    ) == ("4.8030", "4.8030", "unknown")
    assert (three_digits(2.44128), three_digits(799.9), three_digits(4997.0)) == ("2.44", "800", "5000")


@settings(derandomize=True)
@given(st.floats(1e-3, 1e5), st.floats(1e-6, 1.0))
def test_rounding_costs_less_than_half_a_sigma(value, share_of_it):
    sigma = value * share_of_it
    shown, shown_sigma = with_sigma(value, sigma).split(" ± ")
    assert abs(float(shown.replace("−", "-")) - value) <= 0.5 * sigma * 1.0001
    assert float(shown_sigma) == pytest.approx(sigma, rel=0.26)


@pytest.mark.parametrize(
    ("value", "text"),
    [(4.80213, "4.802"), (0.0, "0"), (12345.6, "12346"), (0.000123456, "0.0001235"), (1.5e-12, "1.500×10⁻¹²")],
)
def test_a_plain_number_has_four_digits(value, text):
    assert significant_digits(value) == text


def test_unknown_numbers_are_called_so():
    assert {
        significant_digits(nan),
        scientific_text(nan),
        four_places(nan),
        short_number(inf),
        relative_difference(nan, 1.0),
        relative_difference(1.0, 0.0),
    } == {"unknown"}


@pytest.mark.parametrize(
    ("value", "reference", "text"),
    [(1.0, 1.0, "0 %"), (1.00004, 1.0, "+0.0040 %"), (0.976, 1.0, "−2.4 %"), (2.5, 1.0, "+150 %")],
)
def test_a_difference_is_in_percent_with_its_sign(value, reference, text):
    assert relative_difference(value, reference) == text


def test_words():
    assert scientific_text(-1.234e-5) == "−1.23×10⁻⁵"
    assert (short_number(3.0), short_number(1.024), short_number(110.0)) == ("3", "1.024", "110")
    assert (list_in_words([]), list_in_words(["a"]), list_in_words(["a", "b", "c"])) == ("", "a", "a, b and c")
    assert (count_with_noun(1, "block"), count_with_noun(3, "frequency", "frequencies")) == ("1 block", "3 frequencies")
    assert (iso_date(date(2024, 5, 31)), iso_date(None)) == ("2024-05-31", "not given")


def test_a_number_is_never_parted_from_its_unit():
    assert with_nonbreaking_spaces("3 to 110 Hz, 0.51 % in 1.024 s, 4 ± 1 kg") == (
        "3 to 110\u00a0Hz, 0.51\u00a0% in 1.024\u00a0s, 4\u00a0±\u00a01\u00a0kg"
    )
    assert with_nonbreaking_spaces("5 modes, 3 mice") == "5 modes, 3 mice"


@pytest.mark.parametrize(
    ("value", "said"),
    [(1.0234, "1.02"), (920.4, "920"), (2151.0, "2150"), (999.6, "1000"), (1.5e7, "1.5e+07"), (nan, "unknown")],
)
def test_a_gap_has_three_digits_and_no_exponent_below_a_million(value, said):
    assert three_digits(value) == said


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.94, "94 %"), (0.071, "7.1 %"), (0.05, "5 %"), (0.0996, "10 %"), (1.0, "100 %"), (12.5, "1250 %"),
        (0.00005, "below 0.01 %"), (0.0, "0 %"), (-0.012, "−1.2 %"), (nan, "unknown"), (None, "–"),
    ],
)  # fmt: skip
def test_a_share_is_in_percent_to_two_digits(value, said):
    assert percent_text(value) == said


def test_a_part_of_a_whole_has_tenths_of_a_percent():
    assert (share_text(0.99972), share_text(-0.0004), share_text(-0.012)) == ("100.0 %", "0.0 %", "−1.2 %")
    assert percent_text(0.07321, 3) == "7.32 %"


def test_a_probability_is_never_rounded_up_to_a_certainty():
    assert probability_text(1.0) == probability_text(0.995) == "0.99"
    assert (probability_text(0.899999), probability_text(nan)) == ("0.89", "-")


def test_an_interval_bears_the_digits():
    assert with_interval(1.7512345, (1.7508, 1.7516), "m") == ("1.7512 m", "1.7508 to 1.7516 m")
    assert with_interval(1.7512345, None) == ("1.751", "")


def test_numbers_of_points_are_said_as_ranges():
    assert number_ranges([3, 1, 2, 12, 4, 14, 15]) == "1 to 4, 12, 14 and 15"
    assert (number_ranges([7]), number_ranges([None, 2])) == ("7", "2 and unknown")
