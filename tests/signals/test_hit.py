import numpy as np
import pytest

from modallab.core.errors import DataError
from modallab.signals.hit import find_hit, windowed_force

N = 2048


def force(*peaks, noise=0.02, offset=0.3, seed=1):
    t = np.arange(N)
    pulses = sum((p * np.where(abs(t - at) < 5, np.cos(np.pi * (t - at) / 10) ** 2, 0) for at, p in peaks), np.zeros(N))
    return pulses + offset + noise * np.random.default_rng(seed).standard_normal(N)


def test_the_hit_is_found_with_offset_and_noise():
    hit = find_hit(force((100, 80.0)))
    assert hit.peak == 100
    assert 80 <= hit.first <= 95
    assert 105 <= hit.stop <= 121
    assert hit.offset == pytest.approx(0.3, abs=0.003)
    assert hit.noise == pytest.approx(0.02, rel=0.1)


def test_a_pull_is_a_hit_too():
    assert find_hit(force((300, -50.0))).peak == 300


def test_both_contacts_of_a_double_hit_stay_and_the_noise_between_them_goes():
    both = force((100, 80.0), (300, 30.0))
    hit = find_hit(both)
    assert hit.first < 95
    assert hit.stop > 305
    kept = windowed_force(both, hit)
    assert kept[300] == pytest.approx(30.0, abs=0.1)
    assert not kept[130:270].any()


def test_outside_the_hit_is_zero_and_inside_nothing_but_the_offset_changes():
    raw = force((100, 80.0))
    hit = find_hit(raw)
    kept = windowed_force(raw, hit)
    assert not kept[: hit.first].any()
    assert not kept[hit.stop :].any()
    np.testing.assert_allclose(kept[hit.first : hit.stop], raw[hit.first : hit.stop] - hit.offset)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (force(), "no hit"),
        (np.where(np.arange(N) == 5, np.nan, force((100, 80.0))), "NaN"),
        (np.zeros(0), "empty"),
        (force((100, 80.0)) * 1j, "real"),
    ],
    ids=["noise", "nan", "empty", "complex"],
)
def test_what_holds_no_hit_is_rejected(values, says):
    with pytest.raises(DataError, match=says):
        find_hit(values)


def test_zeros_hold_no_hit():
    with pytest.raises(DataError):
        find_hit(np.zeros(N))


@pytest.mark.parametrize("seed", range(3))
def test_one_sample_that_stands_out_by_chance_does_not_lengthen_the_hit(seed):
    raw = force((100, 80.0), seed=seed)
    alone = raw.copy()
    alone[1500] = 0.3 + 6.5 * 0.02
    alone[[1499, 1501]] = 0.3 - 0.01, 0.3 + 0.02
    whole, found = find_hit(raw), find_hit(alone)
    assert (found.first, found.stop) == (whole.first, whole.stop)
    contact = alone.copy()
    contact[1501] = 0.3 + 5.5 * 0.02
    assert find_hit(contact).stop > 1501
    spike = raw.copy()
    spike[1500] = 0.3 + 12 * 0.02
    assert find_hit(spike).stop > 1500


@pytest.mark.parametrize("noise", [0.1, 0.3, 0.5, 0.7, 1.0])
@pytest.mark.parametrize("seed", range(6))
def test_a_hit_is_short_where_noise_is_less_than_a_step_of_the_converter(noise, seed):
    step = 0.015
    # The median of such noise is zero: by it every sample that is not would belong to the hit.
    seen = step * np.rint(force((100, 12.0), noise=noise * step, offset=0.0, seed=seed) / step)
    hit = find_hit(seen)
    assert hit.stop - hit.first < 60
