"""Effects of sensors, converter and excitation on noise-free records, against what they are by definition."""

import numpy as np
import pytest
from noiseless_bench import RATE_HZ, driven, noiseless_rig, resting, struck, tone

from modallab.bench.protocol import AcquisitionRequest
from modallab.core.errors import ConfigurationError
from modallab_simulators.cantilever import open_bench

NOISE_V = 0.0003


def response(with_effect: np.ndarray, without: np.ndarray, rows: slice | int) -> tuple[np.ndarray, np.ndarray]:
    """Ratio of two whole decays' spectra where both have something to say, and its frequencies."""
    f = np.fft.rfftfreq(with_effect.shape[1], 1 / RATE_HZ)
    one, two = np.fft.rfft(with_effect[rows]), np.fft.rfft(without[rows])
    used = (f > 1) & (f < 600) & np.all(np.abs(np.atleast_2d(two)) > 1e-2, axis=0)
    return f[used], (one / two)[..., used]


def test_gain_error_is_a_flat_ratio_of_one_row():
    sound, found = struck(), struck("gain_error,channel=a03,gain=1.08")
    np.testing.assert_allclose(found[3], 1.08 * sound[3], atol=1e-7)
    np.testing.assert_array_equal(np.delete(found, 3, axis=0), np.delete(sound, 3, axis=0))


def test_polarity_turns_one_row_over():
    sound, found = struck(), struck("polarity,channel=a07,sign=-1")
    np.testing.assert_allclose(found[7], -sound[7], atol=3e-8)
    np.testing.assert_array_equal(found[6], sound[6])


def test_swap_exchanges_two_rows():
    sound, found = struck(), struck("swap,channel=a02:a09")
    np.testing.assert_array_equal(found[[2, 9]], sound[[9, 2]])
    np.testing.assert_array_equal(found[[0, 1, 3]], sound[[0, 1, 3]])


def test_force_gain_scales_what_the_force_channel_reads_and_nothing_else():
    sound, found = struck(), struck("force_gain,gain=1.2")
    np.testing.assert_allclose(found[0], 1.2 * sound[0], atol=1e-7)
    np.testing.assert_array_equal(found[1:], sound[1:])


def test_position_error_shows_the_motion_farther_from_the_clamp():
    rig = noiseless_rig()
    dx = rig.x_of(7) - rig.x_of(6)
    found = struck(f"position_error,channel=a06,dx={dx}")
    np.testing.assert_allclose(found[6], found[7], atol=1e-7 * np.abs(found).max())
    found = struck(f"position_error,channel=a06,dx={-dx}")
    np.testing.assert_allclose(found[6], found[5], atol=1e-7 * np.abs(found).max())


@pytest.mark.parametrize("over", [0.0, 1e-15])
def test_a_sensor_drawn_to_sit_at_the_clamp_may_miss_it_by_what_numbers_are_rounded_by(over: float):
    rig = noiseless_rig()
    sound, found = struck(), struck(f"position_error,channel=a06,dx={-rig.x_of(6) - over!r}")
    np.testing.assert_allclose(found[6], 0.0, atol=1e-7 * np.abs(sound).max())


def test_a_sensor_before_the_clamp_is_rejected():
    with pytest.raises(ConfigurationError, match="position_error: dx is"):
        struck(f"position_error,channel=a06,dx={-noiseless_rig().x_of(6) - 1e-6!r}")


def test_noisy_channel():
    rig = noiseless_rig()
    rig = rig.model_copy(update={"converter": rig.converter.model_copy(update={"noise_rms_v": NOISE_V})})
    bench = open_bench("sim://cantilever?effect=noisy_channel,channel=4,factor=30", rig)
    scale = bench.configure(AcquisitionRequest("impact", RATE_HZ)).scale
    bench.start()
    spread = (bench.read(40_000, 1.0).samples * scale[:, None]).std(axis=1)
    np.testing.assert_allclose(spread, NOISE_V * np.where(np.arange(11) == 4, 30, 1), rtol=0.03)


def test_ac_coupling_is_a_first_order_high_pass_on_every_accelerometer():
    # A heavily damped beam has come to rest at the end of the record, so that the spectra are those of whole decays.
    query = "seed=1&zeta=0.05"
    sound = struck(query=query, seconds=20)
    found = struck("ac_coupling,corner_hz=3", query=query, seconds=20)
    f, ratio = response(found, sound, slice(1, 11))
    expected = 1j * f / (1j * f + 3)
    assert np.abs(ratio - expected).max() < 2e-4
    np.testing.assert_array_equal(found[0], sound[0])


def test_loose_mount_is_the_transmissibility_of_its_spring_and_damper():
    query = "seed=1&zeta=0.05"
    sound = struck(query=query, seconds=20)
    found = struck("loose_mount,channel=a05,hz=180,zeta=0.04", query=query, seconds=20)
    f, ratio = response(found, sound, 5)
    r = f / 180
    expected = (1 + 0.08j * r) / (1 - r**2 + 0.08j * r)
    assert np.abs(ratio / expected - 1).max() < 5e-4
    np.testing.assert_array_equal(found[4], sound[4])


def test_two_sensor_effects_on_one_row_multiply():
    query = "seed=1&zeta=0.05"
    sound = struck(query=query, seconds=20)
    both = struck("ac_coupling,corner_hz=3;loose_mount,channel=a05,hz=180,zeta=0.04", query=query, seconds=20)
    f, ratio = response(both, sound, 5)
    r = f / 180
    expected = (1 + 0.08j * r) / (1 - r**2 + 0.08j * r) * 1j * f / (1j * f + 3)
    assert np.abs(ratio / expected - 1).max() < 1e-3


def test_clipping_cuts_one_row_at_its_level():
    sound, found = struck(), struck("clipping,channel=a10,fraction_of_peak=0.5,peak_v=1.2")
    np.testing.assert_allclose(found[10], np.clip(sound[10], -0.6, 0.6), atol=1e-7)
    np.testing.assert_array_equal(found[:10], sound[:10])


def test_without_a_stated_peak_clipping_is_measured_by_the_hardest_hit():
    found = np.abs(struck("clipping,channel=a10,fraction_of_peak=0.1"))
    assert (found[10] == found[10].max()).sum() > 20
    assert found[10].max() < 0.2 * np.abs(struck())[10].max()


@pytest.mark.parametrize("delay", [1e-7, 3.3e-4, 4e-3])
def test_trigger_delay_puts_a_later_acceleration_beside_the_force(delay: float):
    sound, found = driven(f_hz=37.0), driven(f"trigger_delay,seconds={delay}", f_hz=37.0)
    ratio = np.array([tone(b[4000:], 37.0) / tone(a[4000:], 37.0) for a, b in zip(sound, found, strict=True)])
    np.testing.assert_allclose(ratio[1:] / ratio[0], np.exp(2j * np.pi * 37.0 * delay), rtol=1e-4)


def test_channel_skew_leads_in_proportion_to_the_row():
    skew = 7e-5
    sound, found = driven(f_hz=37.0), driven(f"channel_skew,seconds_per_channel={skew}", f_hz=37.0)
    ratio = np.array([tone(b[4000:], 37.0) / tone(a[4000:], 37.0) for a, b in zip(sound, found, strict=True)])
    expected = np.exp(2j * np.pi * 37.0 * skew * np.arange(11))
    np.testing.assert_allclose(ratio / ratio[0], expected, rtol=1e-4)


@pytest.mark.parametrize("relative", [0.02, -0.013])
def test_clock_error_scales_every_frequency(relative: float):
    found = driven(f"clock_error,relative={relative}", f_hz=40.0)[0, 4000:]
    best = max(np.linspace(38.5, 41.5, 601), key=lambda f: abs(tone(found, float(f))))
    assert best == pytest.approx(40.0 / (1 + relative), abs=0.006)
    # A beam sampled faster rings more slowly: sample n of one stands where n / (1 + relative) of the other does.
    query = "seed=1&zeta=0.02"
    sound, found = struck(query=query), struck(f"clock_error,relative={relative}", query=query)
    times = np.arange(sound.shape[1])
    start = int(np.argmax(np.abs(sound[0]) > 0.01))
    shifted = np.interp(start + (times - start) / (1 + relative), times, sound[10])
    far = slice(start + 400, start + 1500)
    assert np.corrcoef(shifted[far], found[10, far])[0, 1] > 0.995
    assert abs(np.corrcoef(sound[10, far], found[10, far])[0, 1]) < 0.9


def test_mains_hum_is_there_without_excitation_and_grows_by_the_row():
    found = resting("mains_hum,volts=0.05,hz=50")
    hum = np.array([tone(row, 50.0) for row in found])
    np.testing.assert_allclose(np.abs(hum), 0.05 * (0.5 + 0.1 * np.arange(11)), rtol=1e-5)
    np.testing.assert_allclose(np.angle(hum / hum[0]), 0, atol=1e-5)
    rest = found - np.array(
        [np.abs(h) * np.cos(2 * np.pi * 50 * np.arange(found.shape[1]) / RATE_HZ + np.angle(h)) for h in hum]
    )
    assert np.abs(rest).max() < 1e-6


def test_hit_position_moves_the_hit_and_leaves_the_shaker():
    rig = noiseless_rig()
    dx = rig.x_of(4) - rig.x_of(3)
    np.testing.assert_allclose(struck(f"hit_position,dx={dx}", point=3)[1:], moved(point=4)[1:], atol=1e-6)
    np.testing.assert_array_equal(driven(f"hit_position,dx={dx}"), driven())


def moved(point: int) -> np.ndarray:
    """The hit that was meant for point 3, at another point: what one could bear there makes no difference."""
    return struck(point=point, query="seed=1&peak_n=20,20") if point == 3 else struck(point=point)


def test_residual_ringing_is_a_free_decay_under_the_same_hit():
    sound, found = (
        struck(query="seed=1&reaction_s=1.3,1.4"),
        struck("residual_ringing,fraction=0.5", query="seed=1&reaction_s=1.3,1.4"),
    )
    np.testing.assert_array_equal(found[0], sound[0])
    start = int(np.argmax(np.abs(sound[0]) > 0.001)) - 100
    more = found[1:] - sound[1:]
    ringing, answer = np.abs(more[:, start:]).max(), np.abs(sound[1:]).max()
    assert 0.01 * answer < ringing < 0.6 * answer
    assert np.abs(more[:, :100]).max() == 0
    # What is more is free of force: late in the record it is smaller than early.
    assert more[:, -2000:].std() < 0.8 * more[:, start : start + 2000].std()


def test_floor_vibration_is_seen_by_all_and_by_the_force_channel_not():
    found = resting("floor_vibration,rms_acc=0.5", seconds=60, query="seed=1&k_root=inf")
    assert not found[0].any()
    sensitivity = 0.01
    f = np.fft.rfftfreq(found.shape[1], 1 / RATE_HZ)
    power = np.abs(np.fft.rfft(found[1] / sensitivity)) ** 2
    low = (f > 2.2) & (f < 3.2)
    # Far below the first mode the beam moves with its base, whose power is spread evenly from 2 to 200 Hz.
    expected = 0.5**2 / 198 * found.shape[1] * RATE_HZ / 2
    assert power[low].mean() == pytest.approx(expected, rel=0.3)
    assert power[(f > 250) & (f < 300)].mean() < 0.05 * expected


def test_stinger_and_shaker_mass_act_in_the_sine_test_only():
    for effect in ("stinger_moment,k_rot=500", "shaker_mass,mass=0.2"):
        np.testing.assert_array_equal(struck(effect), struck())
        assert not np.allclose(driven(effect)[1:], driven()[1:], atol=1e-3)
        np.testing.assert_array_equal(driven(effect)[0], driven()[0])


def test_a_lag_and_a_soft_saturation_of_one_preamplifier():
    sound = struck()
    f, ratio = response(
        struck("preamp_lag,channel=a08,corner_hz=60", query="seed=1&zeta=0.05", seconds=20),
        struck(query="seed=1&zeta=0.05", seconds=20),
        8,
    )
    assert np.abs(ratio * (1 + 1j * f / 60) - 1).max() < 2e-3
    soft = struck("soft_saturation,channel=a08,volts=0.7")
    np.testing.assert_allclose(soft[8], sound[8] / np.sqrt(1 + (sound[8] / 0.7) ** 2), atol=1e-7)


def test_dropouts_read_nothing():
    sound, found = struck(), struck("dropouts,channel=a02,share=0.05")
    lost = found[2] != sound[2]
    assert not found[2, lost].any()
    assert lost.mean() == pytest.approx(0.05 * (sound[2] != 0).mean(), rel=0.2)
    np.testing.assert_array_equal(np.delete(found, 2, axis=0), np.delete(sound, 2, axis=0))


def test_timing_jitter_is_slope_times_time():
    sound, found = driven(f_hz=80.0), driven("timing_jitter,seconds_rms=1e-5", f_hz=80.0)
    speed = np.gradient(sound, 1 / RATE_HZ, axis=1)
    late = (found - sound)[:, 4000:]
    np.testing.assert_allclose(late.std(axis=1), 1e-5 * np.sqrt(np.mean(speed[:, 4000:] ** 2, axis=1)), rtol=0.05)
    assert np.corrcoef(late[0], late[10])[0, 1] ** 2 > 0.99


def test_amplifier_harmonics_are_in_the_force():
    found, sound = driven("amplifier_harmonics,share=0.1", f_hz=20.0, volts=5.0), driven(f_hz=20.0, volts=5.0)
    first, second, third = (abs(tone(found[0, 4000:7600], k * 20.0)) for k in (1, 2, 3))
    # Of a unit sine, its square holds 1/2 at twice and its cube 1/4 at three times the frequency.
    amplitude = abs(tone(sound[0, 4000:7600], 20.0))
    np.testing.assert_allclose([second, third], amplitude * np.array([0.05, 0.025]), rtol=0.01)
    assert first == pytest.approx(amplitude * (1 + 0.1 * 0.75), rel=1e-3)
