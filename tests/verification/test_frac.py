import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.verification.verify import frac

H = np.random.default_rng(1).standard_normal((4, 2, 50)) + 1j * np.random.default_rng(2).standard_normal((4, 2, 50))


def test_an_frf_agrees_with_itself_times_any_factor():
    np.testing.assert_allclose(frac(H, H * (0.3 - 2j)), 1)


def test_the_closed_form_for_two_lines():
    one, other = np.array([1.0, 1.0j]), np.array([1.0, 1.0])
    # |1 - j|^2 / (2 * 2) = 1 / 2
    assert frac(one, other) == pytest.approx(0.5)


def test_frfs_without_a_common_line_disagree_wholly():
    assert frac(np.array([1.0 + 0j, 0]), np.array([0, 1.0 + 0j])) == 0


def test_noise_of_a_given_power_lowers_frac_by_its_share():
    rng = np.random.default_rng(3)
    clean = np.ones(100_000, complex)
    noise = 0.5 * (rng.standard_normal(clean.size) + 1j * rng.standard_normal(clean.size)) / np.sqrt(2)
    assert frac(clean, clean + noise) == pytest.approx(1 / 1.25, abs=0.01)


def test_nothing_against_something_is_zero_not_nan():
    assert frac(np.zeros(5, complex), np.ones(5, complex)) == 0


@pytest.mark.parametrize(
    ("one", "other", "says"),
    [(H, H[..., :-1], "shapes"), (H, H * np.nan, "NaN"), (H[..., :0], H[..., :0], "shapes")],
    ids=["shapes", "nan", "no lines"],
)
def test_what_cannot_be_compared_is_rejected(one, other, says):
    with pytest.raises(DataError, match=says):
        frac(one, other)
