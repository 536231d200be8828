import numpy as np
import pytest

from modallab.errors import DataError
from modallab.spectra.blow import find_blow, windowed_force

N = 2048


def force(*peaks, noise=0.02, offset=0.3, seed=1):
    t = np.arange(N)
    pulses = sum((p * np.where(abs(t - at) < 5, np.cos(np.pi * (t - at) / 10) ** 2, 0) for at, p in peaks), np.zeros(N))
    return pulses + offset + noise * np.random.default_rng(seed).standard_normal(N)


def test_the_blow_is_found_with_offset_and_noise():
    blow = find_blow(force((100, 80.0)))
    assert blow.peak == 100
    assert 80 <= blow.first <= 95
    assert 105 <= blow.stop <= 121
    assert blow.offset == pytest.approx(0.3, abs=0.003)
    assert blow.noise == pytest.approx(0.02, rel=0.1)


def test_a_pull_is_a_blow_too():
    assert find_blow(force((300, -50.0))).peak == 300


def test_a_double_hit_stays_whole():
    both = force((100, 80.0), (140, 30.0))
    blow = find_blow(both)
    assert blow.first < 95
    assert blow.stop > 145
    kept = windowed_force(both, blow)
    assert kept[140] == pytest.approx(30.0, abs=0.1)


def test_outside_the_blow_is_silence_and_inside_nothing_but_the_offset_changes():
    raw = force((100, 80.0))
    blow = find_blow(raw)
    kept = windowed_force(raw, blow)
    assert not kept[: blow.first].any()
    assert not kept[blow.stop :].any()
    np.testing.assert_allclose(kept[blow.first : blow.stop], raw[blow.first : blow.stop] - blow.offset)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (force(), "no blow"),
        (np.where(np.arange(N) == 5, np.nan, force((100, 80.0))), "NaN"),
        (np.zeros(0), "empty"),
        (force((100, 80.0)) * 1j, "real"),
    ],
    ids=["noise", "nan", "empty", "complex"],
)
def test_what_holds_no_blow_is_refused(values, says):
    with pytest.raises(DataError, match=says):
        find_blow(values)


def test_zeros_hold_no_blow():
    with pytest.raises(DataError):
        find_blow(np.zeros(N))


@pytest.mark.parametrize("seed", range(3))
def test_one_sample_that_stands_out_by_chance_does_not_lengthen_the_blow(seed):
    raw = force((100, 80.0), seed=seed)
    alone = raw.copy()
    alone[1500] = 0.3 + 6.5 * 0.02
    alone[[1499, 1501]] = 0.3 - 0.01, 0.3 + 0.02
    whole, found = find_blow(raw), find_blow(alone)
    assert (found.first, found.stop) == (whole.first, whole.stop)
    contact = alone.copy()
    contact[1501] = 0.3 + 5.5 * 0.02
    assert find_blow(contact).stop > 1501
    spike = raw.copy()
    spike[1500] = 0.3 + 12 * 0.02
    assert find_blow(spike).stop > 1500
