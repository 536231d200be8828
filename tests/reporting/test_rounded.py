import pytest

from modallab.core.rounded import rounded


@pytest.mark.parametrize(
    ("value", "said"),
    [(1.0234, "1.02"), (920.4, "920"), (2151.0, "2150"), (999.6, "1000"), (1.5e7, "1.5e+07"), (float("nan"), "nan")],
)
def test_a_gap_has_three_digits_and_no_exponent_below_a_million(value: float, said: str) -> None:
    assert rounded(value) == said
