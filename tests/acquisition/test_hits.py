"""Hits are measured as closed forms say, and rejected with the number that decided."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modallab.acquisition.procedures.hit_acceptance import hit_of, rejection_reasons
from modallab.core.plan import HitAcceptance

RATE, BEFORE, N = 2000.0, 100, 2048
T = np.arange(N) / RATE


def pulse(start_s: float, width_s: float, peak_n: float) -> np.ndarray:
    share = (T - start_s) / width_s
    return np.where((share > 0) & (share < 1), peak_n * np.sin(np.pi * share) ** 2, 0.0)


def force(width_s: float = 0.004, peak_n: float = 100.0, second: float = 0.0, after_s: float = 0.02) -> np.ndarray:
    noise = np.random.default_rng(1).normal(0, 0.015, N)
    start = BEFORE / RATE - 0.0004
    return pulse(start, width_s, peak_n) + pulse(start + after_s, width_s, second * peak_n) + noise


def reasons(signal: np.ndarray, **limits: float) -> list[str]:
    acceptance = HitAcceptance(**limits)
    return rejection_reasons(hit_of(signal, RATE, BEFORE, acceptance.min_band_hz), acceptance)


def test_a_good_hit_has_no_reason_against_it() -> None:
    assert reasons(force()) == []


@given(st.floats(0.002, 0.012), st.floats(20, 400))
def test_peak_and_contact_are_those_of_the_pulse(width_s: float, peak_n: float) -> None:
    hit = hit_of(force(width_s, peak_n), RATE, BEFORE, 110.0)
    # At worst the peak lies in the middle between two samples.
    assert peak_n * np.cos(np.pi / (2 * RATE * width_s)) ** 2 - 0.1 < hit.peak_n < peak_n + 0.1
    # Above 5 % of the peak for 1 - 2 asin(sqrt(0.05)) / pi = 86 % of the width.
    assert hit.contact_s == pytest.approx(0.856 * width_s, abs=2.1 / RATE)


@pytest.mark.parametrize("width_s", [0.004, 0.006, 0.008])
def test_the_drop_is_that_of_a_raised_cosine(width_s: float) -> None:
    x = 110.0 * width_s
    expected_db = -20 * np.log10(np.sinc(x) / (1 - x**2))
    assert hit_of(force(width_s), RATE, BEFORE, 110.0).drop_db == pytest.approx(expected_db, abs=0.3)


@given(st.floats(0.08, 1.0), st.floats(0.012, 0.4))
def test_a_second_contact_is_found_wherever_it_is(ratio: float, after_s: float) -> None:
    hit = hit_of(force(second=ratio, after_s=after_s), RATE, BEFORE, 110.0)
    assert hit.second_ratio == pytest.approx(ratio, rel=0.1)
    assert "double hit" in " ".join(rejection_reasons(hit, HitAcceptance()))


@pytest.mark.parametrize("width_s", [0.0006, 0.0012, 0.002])
@pytest.mark.parametrize("centre_s", [0.0501, 0.05025, 0.0504])
def test_the_ripple_of_a_sharp_filter_is_no_second_contact(centre_s: float, width_s: float) -> None:
    share = (np.arange(N * 16) / (16 * RATE) - centre_s) / width_s
    contact = np.where(np.abs(share) < 0.5, 100 * np.cos(np.pi * share) ** 2, 0.0)
    # A brick wall at half the rate: its ripple reaches 15 % of the peak.
    spectrum = np.fft.rfft(contact)
    spectrum[N // 2 :] = 0
    filtered = np.fft.irfft(spectrum)[::16]
    assert reasons(filtered) == []


@pytest.mark.parametrize(
    ("signal", "limits", "reason"),
    [
        (force(peak_n=6.0), {}, "too weak: 5.9"),
        (force(peak_n=100.0), {"max_force_n": 80.0}, "too strong: 99."),
        (force(width_s=0.03), {}, "contact too long: 2"),
        (force(second=0.3), {}, "double hit: a second pulse of 30"),
        (force(width_s=0.016), {}, "force spectrum too narrow: down"),
    ],
)
def test_each_rejection_names_its_number(signal: np.ndarray, limits: dict[str, float], reason: str) -> None:
    found = reasons(signal, **limits)
    assert any(text.startswith(reason) for text in found), found


def test_all_reasons_are_given_at_once() -> None:
    assert len(reasons(force(width_s=0.03, peak_n=6.0, second=0.3, after_s=0.1))) >= 3


def test_an_offset_of_the_force_channel_does_not_matter() -> None:
    with_offset = hit_of(force() + 3.0, RATE, BEFORE, 110.0)
    without = hit_of(force(), RATE, BEFORE, 110.0)
    assert with_offset.peak_n == pytest.approx(without.peak_n)
    assert with_offset.contact_s == without.contact_s
