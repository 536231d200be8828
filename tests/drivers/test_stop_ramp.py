"""Every stop of a burst is a fall from the value the output has, seen on the output's own trace at 51.2 kHz."""

import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer
from stop_trace import RATE_HZ, Stop, seen

from modallab.bench.capabilities import PlaysWaves
from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst, Waveform
from modallab.bench.ramp_down import FALL_S, ramp_down_s, ramp_down_samples
from modallab.core.rig import Rig
from modallab_drivers.ni_daqmx import ramp_down

MOST_PER_MS = 0.05
LEVEL_V = 2.0
LOOKED_BACK_S = 4.0


@pytest.fixture(scope="module")
def paced(rig: Rig) -> Iterator[NiServer]:
    with NiServer(rig, "9215", "--pace", virtual=False) as server:
        server.say("preamplifiers sine")
        yield server


OPEN: list[Bench] = []


@pytest.fixture(autouse=True)
def nothing_left() -> Iterator[None]:
    """What one test leaves open, no other finds."""
    yield
    while OPEN:
        OPEN.pop().close()


def opened(server: NiServer, rig: Rig) -> Bench:
    OPEN.append(open_bench(server.url, rig))
    return OPEN[-1]


def playing(server: NiServer, rig: Rig, burst: Burst, after_s: float) -> Bench:
    bench = opened(server, rig)
    bench.configure(AcquisitionRequest("sine", 2000.0))
    bench.start()
    bench.play(burst)
    bench.read(round(2000 * after_s), 5.0)
    return bench


def traced(server: NiServer, burst: Burst) -> Stop:
    time.sleep(0.1)
    # So long, since on a busy machine the stop may lie a while back.
    return seen(
        np.array(server.say(f"trace {LOOKED_BACK_S} {RATE_HZ}")["volts"]), burst.frequency_hz, burst.amplitude_v
    )


@pytest.mark.parametrize("way", ["zero", "stop", "close", "supervisor"])
@pytest.mark.parametrize("frequency_hz", [20.0, 110.0])
def test_a_stop_at_a_random_moment_is_no_step(paced: NiServer, rig: Rig, way: str, frequency_hz: float) -> None:
    rng = np.random.default_rng()
    burst = Burst(frequency_hz, LEVEL_V, 0.1, 20.0)
    bench = playing(paced, rig, burst, float(rng.uniform(0.05, 0.6)))
    if way == "supervisor":
        handle = open_output(paced.url, rig)
        assert handle is not None
        handle.zero()
        handle.close()
    else:
        getattr(bench, way)()
    found = traced(paced, burst)
    bench.close()
    assert found.end_v == 0.0
    assert found.jump == 0.0
    assert found.per_ms <= MOST_PER_MS
    assert found.took_s < 0.3


@pytest.mark.parametrize("apart_s", [0.001, 0.004, 0.012])
def test_two_who_stop_it_one_after_the_other_make_no_step(
    paced: NiServer, rig: Rig, apart_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second must not take a task that is stopped for one that has fallen."""
    # The first is not frozen, however slow the machine is: for who is, the second makes a step in time.
    monkeypatch.setattr(ramp_down, "BEGIN_S", 10.0)
    burst = Burst(110.0, LEVEL_V, 0.1, 20.0)
    bench = playing(paced, rig, burst, 0.3)
    handles = [handle for handle in (open_output(paced.url, rig), open_output(paced.url, rig)) if handle is not None]
    with ThreadPoolExecutor(2) as two:
        first = two.submit(handles[0].zero)
        time.sleep(apart_s)
        two.submit(handles[1].zero).result()
        first.result()
    found = traced(paced, burst)
    for handle in handles:
        handle.close()
    bench.close()
    assert (found.end_v, found.jump) == (0.0, 0.0)
    assert found.per_ms <= MOST_PER_MS


def wave_like_noise(rng: np.random.Generator) -> Waveform:
    rate_hz, count = 5000.0, 50_000
    times = np.arange(count) / rate_hz
    lines = 4.0 + 3.0 * np.arange(20)
    volts = np.sin(2 * np.pi * (lines[:, None] * times + rng.random((20, 1)))).sum(axis=0) * np.hanning(count) ** 0.2
    volts *= LEVEL_V / np.abs(volts).max()
    volts[0] = volts[-1] = 0.0
    return Waveform(volts, rate_hz)


@pytest.mark.parametrize("way", ["zero", "stop", "close", "supervisor"])
def test_a_stop_of_a_wave_at_a_random_moment_is_no_step(paced: NiServer, rig: Rig, way: str) -> None:
    rng = np.random.default_rng()
    wave = wave_like_noise(rng)
    bench = opened(paced, rig)
    assert isinstance(bench, PlaysWaves)
    bench.configure(AcquisitionRequest("random", 2000.0))
    bench.start()
    bench.play_wave(wave)
    bench.read(round(2000 * rng.uniform(0.3, 1.5)), 5.0)
    began = time.monotonic()
    if way == "supervisor":
        handle = open_output(paced.url, rig)
        assert handle is not None
        handle.zero()
        handle.close()
    else:
        getattr(bench, way)()
    time.sleep(0.1)
    took_s = time.monotonic() - began
    assert took_s < wave.duration_s / 2, "the wave was not cut short"
    # From the wave before the stop on, however busy the machine is, but without the wave's own steep beginning.
    volts = np.array(paced.say(f"trace {took_s + 0.2} {RATE_HZ}")["volts"])
    # No stretch of the wave is steeper than a sine of its highest frequency at its peak.
    found = seen(volts, 61.0, LEVEL_V)
    bench.close()
    assert found.end_v == 0.0
    assert found.jump == 0.0
    assert found.per_ms <= MOST_PER_MS
    assert found.took_s < 0.3


def test_the_file_of_a_wave_is_there_while_it_plays_and_no_longer(
    paced: NiServer, rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A folder of its own: other tests play waves at the same time, and theirs would be counted.
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    wave = wave_like_noise(np.random.default_rng())
    bench = opened(paced, rig)
    assert isinstance(bench, PlaysWaves)
    bench.configure(AcquisitionRequest("random", 2000.0))
    bench.start()
    bench.play_wave(wave)
    assert len(list(tmp_path.glob("modallab-wave-*"))) == 1
    bench.zero()
    assert not list(tmp_path.glob("modallab-wave-*"))
    bench.close()


def test_a_device_that_takes_no_value_on_demand_is_brought_to_0_v_by_a_short_buffer(rig: Rig) -> None:
    with NiServer(rig_of_four(rig), "4431", "--pace", virtual=False) as server:
        bench = playing(server, rig_of_four(rig), Burst(20.0, 1.0, 0.1, 20.0), 0.4)
        bench.zero()
        assert server.say("levels 0.01")["Dev1/ao0"] == 0.0
        bench.close()


def test_a_burst_that_has_ended_needs_no_fall(paced: NiServer, rig: Rig) -> None:
    bench = playing(paced, rig, Burst(20.0, LEVEL_V, 0.1, 0.1), 1.2)
    began = time.monotonic()
    bench.zero()
    assert time.monotonic() - began < 1.0
    assert paced.say("levels 0.1")["cDAQ1Mod4/ao0"] == 0.0
    bench.close()


@pytest.mark.parametrize("from_v", [-5.0, -0.3, 0.0, 1.0, 5.0])
def test_a_fall_begins_where_the_output_is_and_ends_at_exactly_0_v(from_v: float) -> None:
    volts = ramp_down_samples(from_v, 5.0, 51_200.0)
    assert volts[0] == from_v
    assert volts[-1] == 0.0
    assert np.abs(volts[51:] - volts[:-51]).max(initial=0.0) <= MOST_PER_MS * 5.0 * 1.001
    assert ramp_down_s(from_v, 5.0) >= FALL_S


def rig_of_four(rig: Rig) -> Rig:
    assert rig.limits is not None
    limits = rig.limits.model_copy(update={"drive_v": 3.0})
    return rig.model_copy(update={"channels": rig.channels[:4], "limits": limits})
