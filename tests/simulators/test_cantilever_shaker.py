"""The generator, its clock and the way it is switched off."""

import json
import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from modallab.bench.protocol import AcquisitionRequest, Bench, Burst
from modallab.core.errors import ConfigurationError, UnsupportedError
from modallab.core.rig import Rig
from modallab_simulators.cantilever import open_bench
from modallab_simulators.cantilever.excitation import BurstOutput
from modallab_simulators.cantilever.recursion import DELAY

Running = Callable[..., Bench]

BURST = Burst(20.0, 0.5, 0.2, 1.0)
N_PER_COUNT = 10 / 2**15 / 0.5
NOISE_N = 0.0003 / 0.5


def test_a_burst_is_a_tapered_sine_and_exactly_zero_outside():
    emission = BurstOutput(BURST, 1.0, 0.0)
    times = np.arange(0.9, 2.6, 1e-4)
    volts = emission.volts(times)
    assert not volts[(times <= 1.0) | (times >= 2.4)].any()
    hold = (times > 1.2) & (times < 2.2)
    np.testing.assert_allclose(volts[hold], 0.5 * np.sin(2 * math.pi * 20 * (times[hold] - 1)), atol=1e-12)
    edge = (times > 1.0) & (times < 1.2)
    assert (np.abs(volts[edge]) <= 0.5 * np.sin(math.pi * (times[edge] - 1) / 0.4) ** 2 + 1e-12).all()


def test_a_cut_burst_is_gone_within_the_amplifiers_fall():
    emission = BurstOutput(BURST, 1.0, 0.0).cut(1.5)
    times = np.arange(0.9, 2.6, 1e-4)
    volts = emission.volts(times)
    assert not volts[times >= 1.5 + 0.032].any()
    np.testing.assert_array_equal(volts[times <= 1.5], BurstOutput(BURST, 1.0, 0.0).volts(times)[times <= 1.5])
    assert emission.cut(1.6) == emission


def test_the_force_begins_where_play_says_and_ends_with_the_burst(running: Running):
    bench = running("seed=2", "sine", 1000.0)
    bench.read(333, 1.0)
    begin = bench.play(BURST)
    assert begin >= 333 + DELAY
    force = bench.read(3000, 1.0).samples[0] * N_PER_COUNT
    end = begin - 333 + round(1000 * BURST.duration_s)
    assert np.abs(force[: begin - 333]).max() < 6 * NOISE_N
    assert np.abs(force[end + DELAY :]).max() < 6 * NOISE_N
    assert np.abs(force).max() == pytest.approx(0.25, rel=0.01)
    # In the rise the amplitude is sin^2 of a quarter turn over the ramp.
    times = np.arange(60, 140)
    expected = 0.25 * np.sin(math.pi * times / 400) ** 2 * np.sin(2 * math.pi * 20 * times / 1000)
    np.testing.assert_allclose(force[begin - 333 + times], expected, atol=6 * NOISE_N)


def test_zero_stops_the_shaker_at_once(running: Running):
    bench = running("seed=2", "sine", 1000.0)
    bench.play(BURST)
    bench.read(600, 1.0)
    bench.zero()
    force = bench.read(1000, 1.0).samples[0] * N_PER_COUNT
    assert np.abs(force[: DELAY - 10]).max() > 0.2
    assert np.abs(force[2 * DELAY + 5 :]).max() < 6 * NOISE_N


def test_zero_recalls_a_burst_that_has_not_begun(running: Running):
    bench = running("seed=2", "sine", 1000.0)
    bench.play(BURST)
    bench.zero()
    assert np.abs(bench.read(3000, 1.0).samples[0] * N_PER_COUNT).max() < 6 * NOISE_N


def test_after_zero_another_burst_may_follow(running: Running):
    bench = running("seed=2", "sine", 1000.0)
    bench.play(BURST)
    bench.read(600, 1.0)
    with pytest.raises(ConfigurationError, match="still on"):
        bench.play(BURST)
    bench.zero()
    begin = bench.play(BURST)
    force = bench.read(3000, 1.0).samples[0] * N_PER_COUNT
    assert np.abs(force[begin - 600 + 300 : begin - 600 + 1000]).max() == pytest.approx(0.25, rel=0.01)


def test_the_generators_clock_is_off_by_what_the_facts_say(running: Running):
    bench = running("seed=8", "sine", 1000.0)
    ppm = float(bench.info.facts["generator_ppm"])
    assert abs(ppm) > 1
    bench.play(Burst(100.0, 2.0, 1.0, 60.0))
    force = bench.read(60_000, 1.0).samples[0, 2000:].astype(float)
    times = np.arange(len(force)) / 1000.0

    def power(shift_ppm: float) -> float:
        return -abs(np.exp(-2j * math.pi * 100.0 * (1 + shift_ppm * 1e-6) * times) @ force)

    assert minimize_scalar(power, bounds=(-40, 40), method="bounded").x == pytest.approx(ppm, abs=0.5)


def test_steady_response_is_that_of_the_modes_the_facts_state(running: Running, rig: Rig):
    bench = running("seed=8&zeta=0.01", "sine", 1000.0)
    facts = {k: np.array(json.loads(v)) for k, v in bench.info.facts.items() if v.startswith("[")}
    ppm = float(bench.info.facts["generator_ppm"])
    for f in (17.0, 50.0):
        begin = bench.play(Burst(f, 5.0, 1.0, 40.0))
        volts = bench.read(begin + 40_000 - bench.read(1, 1.0).first_sample, 1.0).samples[:, -20_000:] * (10 / 2**15)
        turns = np.exp(-2j * math.pi * f * (1 + ppm * 1e-6) * np.arange(20_000) / 1000)
        phasor = volts @ (turns * np.hanning(20_000))
        measured = (phasor[1:] / 0.1) / (phasor[0] / 0.5)
        omega, omegas = 2 * math.pi * f, 2 * math.pi * facts["frequency_hz"]
        shapes = facts["shapes_per_sqrt_kg"]
        drive = shapes[:, facts["points"].tolist().index(rig.shaker_point)]
        modal = 1 / (omegas**2 - omega**2 + 2j * facts["damping_ratio"] * omegas * omega)
        expected = -(omega**2) * (shapes.T @ (drive * modal))
        # The facts end at 1 kHz, so what the modes beyond add is missing.
        assert np.abs(measured - expected).max() < 2e-3 * np.abs(expected).max()
        bench.zero()
        bench.read(60_000, 1.0)


def test_shaker_response_at_every_resonance_stays_within_the_range(running: Running):
    for f in (4.78, 30.75, 87.6):
        bench = running("seed=1&zeta=0.003", "sine", 1000.0)
        bench.play(Burst(f, 0.5, 1.0, 40.0))
        chunk = bench.read(42_000, 1.0)
        assert not chunk.overload.any()
        assert np.abs(chunk.samples[1:]).max() > 1000


@pytest.mark.parametrize(
    "burst",
    [
        Burst(0.0, 1.0, 0.1, 1.0),
        Burst(500.0, 1.0, 0.1, 1.0),
        Burst(math.nan, 1.0, 0.1, 1.0),
        Burst(20.0, 0.0, 0.1, 1.0),
        Burst(20.0, 10.1, 0.1, 1.0),
        Burst(20.0, 1.0, -0.1, 1.0),
        Burst(20.0, 1.0, 0.0, math.inf),
        Burst(20.0, 1.0, 0.0, 0.0),
    ],
)
def test_impossible_bursts_are_rejected(running: Running, burst: Burst):
    with pytest.raises(ConfigurationError, match="a burst of"):
        running("seed=2", "sine", 1000.0).play(burst)


def test_a_rig_without_shaker_cannot_drive(rig: Rig):
    bench = open_bench("sim://cantilever", rig.model_copy(update={"shaker_point": None}))
    assert not bench.info.can_drive
    bench.configure(AcquisitionRequest("sine", 1000.0))
    bench.start()
    with pytest.raises(UnsupportedError, match="no shaker"):
        bench.play(BURST)
