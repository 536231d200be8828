"""Two outputs of a device drive two shakers: they start at one sample, and end, fall and trip together."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from ni_server import NiServer
from two_shakers import TIP, two_shakers

from modallab.acquisition.procedures.broadband_wave import make_waves, wave_layout
from modallab.acquisition.process.run import record_run
from modallab.bench.capabilities import DrivesSeveralShakers
from modallab.bench.loader import open_bench, open_output
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst, Waveform
from modallab.core.errors import BenchError, ConfigurationError, SafetyError
from modallab.core.hardware import Excitation, Shaker
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.frf.broadband import broadband_frf
from modallab.signals.signals import to_signals_of
from modallab.storage import Store

RATE_HZ = 2000.0
PLAN = BroadbandPlan(
    signal="pseudo-random",
    shakers="all",
    levels_v={"low": 0.3},
    blocks=6,
    settle_s=1.0,
    wait_s=0.5,
    band_hz=(5.0, 300.0),
)
LAYOUT = wave_layout(PLAN, 3, PLAN.block_s)
WAVES = make_waves(PLAN, "low", 1, LAYOUT, 2)


@pytest.fixture(scope="module")
def both(rig: Rig) -> Rig:
    return two_shakers(rig)


@pytest.fixture(scope="module")
def cabled(both: Rig) -> Iterator[NiServer]:
    """Its outputs lead to its own inputs."""
    with NiServer(both, "9215", "--cables") as server:
        yield server


@pytest.fixture(scope="module")
def server(both: Rig) -> Iterator[NiServer]:
    with NiServer(both, "9215") as started:
        started.say("preamplifiers sine")
        yield started


def started(server: NiServer, rig: Rig, *, test: str = "pseudo-random") -> tuple[Bench, float]:
    bench = open_bench(server.url, rig)
    rate_hz = bench.configure(AcquisitionRequest("sine" if test == "sine" else "pseudo-random", RATE_HZ)).rate_hz
    bench.start()
    bench.read(400, 2.0)
    return bench, rate_hz


def lag_of(volts: np.ndarray, wave: Waveform, start: int, rate_hz: float) -> tuple[int, float]:
    first, count = start - 400 + round(LAYOUT.lead_s * rate_hz), round(PLAN.block_s * rate_hz)
    expected = wave.at(LAYOUT.lead_s + np.arange(count) / rate_hz)
    alike = [float(np.corrcoef(volts[first + k : first + k + count], expected)[0, 1]) for k in range(-60, 61)]
    return int(np.argmax(alike)) - 60, max(alike)


def test_each_output_plays_its_own_wave_from_one_sample_on(cabled: NiServer, both: Rig) -> None:
    bench, rate_hz = started(cabled, both)
    assert isinstance(bench, DrivesSeveralShakers)
    start = bench.play_waves(WAVES)
    volts = bench.read(round((LAYOUT.end_s + 1.0) * rate_hz), 20.0).samples
    found = [lag_of(volts[row], wave, start, rate_hz) for row, wave in enumerate(WAVES)]
    assert min(alike for _, alike in found) > 0.99
    assert found[0][0] == found[1][0]
    assert abs(np.corrcoef(volts[0], volts[1])[0, 1]) < 0.3
    assert np.abs(volts[:2, -500:]).max() < 0.01
    bench.close()


def test_one_wave_or_a_burst_plays_on_the_first_output_alone(cabled: NiServer, both: Rig) -> None:
    bench, rate_hz = started(cabled, both)
    assert isinstance(bench, DrivesSeveralShakers)
    bench.play_wave(WAVES[0])
    volts = bench.read(round((LAYOUT.end_s + 1.0) * rate_hz), 20.0).samples
    assert volts[0].std() > 0.1
    assert np.abs(volts[1]).max() < 0.01
    bench.play(Burst(40.0, 1.0, 0.1, 0.5))
    volts = bench.read(round(1.0 * rate_hz), 20.0).samples
    assert volts[0].std() > 0.3
    assert np.abs(volts[1]).max() < 0.01
    bench.close()


@pytest.mark.parametrize("way", ["zero", "stop"])
def test_both_outputs_fall_together(cabled: NiServer, both: Rig, way: str) -> None:
    bench, rate_hz = started(cabled, both)
    assert isinstance(bench, DrivesSeveralShakers)
    slow = [Waveform(a * np.sin(np.linspace(0, np.pi, 20001)) * np.sin(np.pi * 0.5), 5000.0) for a in (2.0, -3.0)]
    for wave in slow:
        wave.samples[[0, -1]] = 0.0
    bench.play_waves(slow)
    before = bench.read(round(2.0 * rate_hz), 20.0).samples[:2, -1]
    np.testing.assert_allclose(before, [2.0, -3.0], rtol=0.05)
    getattr(bench, way)()
    if way == "stop":
        bench.start()
    after = bench.read(round(0.2 * rate_hz), 2.0).samples[:2]
    assert np.abs(after[:, -100:]).max() < 1e-3
    if way != "stop":
        # Along half a cosine: never more than 5 % of the level in a ms, which is two samples.
        steps = np.abs(np.diff(np.column_stack([before, after]), axis=1)).max(axis=1)
        assert np.all(steps < 0.03 * np.abs(before))
    bench.close()


def test_waves_that_cannot_go_together_are_rejected_with_their_numbers(cabled: NiServer, both: Rig) -> None:
    bench, _ = started(cabled, both)
    assert isinstance(bench, DrivesSeveralShakers)
    short = Waveform(WAVES[1].samples[:-10].copy(), WAVES[1].rate_hz)
    short.samples[-1] = 0.0
    with pytest.raises(ConfigurationError, match="one rate and one length"):
        bench.play_waves([WAVES[0], short])
    with pytest.raises(ConfigurationError, match=r"limits\.drive_v"):
        bench.play_waves([WAVES[0], Waveform(30 * WAVES[1].samples, WAVES[1].rate_hz)])
    bench.play_waves(WAVES)
    with pytest.raises(ConfigurationError, match="still on"):
        bench.play_waves(WAVES)
    bench.close()


def test_a_run_on_a_device_tells_the_two_forces_apart(server: NiServer, both: Rig, tmp_path: Path) -> None:
    with Store(tmp_path / "data") as store:
        bench = open_bench(server.url, both)
        run = record_run(bench, both, PLAN, store, lambda _: None)
        bench.close()
        blocks = store.blocks(run)
        assert {b.driven_points for b in blocks} == {(4, 9)}
        frf = broadband_frf(to_signals_of(blocks, both), both, (10.0, 290.0))
        at = {point: row for row, point in enumerate(frf.output_points)}
        one, other = frf.values[at[9], 0], frf.values[at[4], 1]
        assert np.linalg.norm(one - other) < 0.05 * np.linalg.norm(one)


def test_beyond_a_limit_at_the_second_force_both_outputs_end(server: NiServer, both: Rig, tmp_path: Path) -> None:
    volts = both.forces[1].sensitivity_v_per_unit
    assert isinstance(volts, dict)
    assert both.limits is not None
    weak = both.forces[1].model_copy(update={"sensitivity_v_per_unit": {t: v / 60 for t, v in volts.items()}})
    channels = tuple(weak if c.name == TIP else c for c in both.channels)
    believed = both.model_copy(update={"channels": channels})
    with Store(tmp_path / "data") as store:
        bench = open_bench(server.url, believed)
        with pytest.raises(SafetyError, match=f"beyond the abort limit: {TIP} .* N"):
            record_run(bench, believed, PLAN, store, lambda _: None)
        bench.start()
        bench.read(400, 2.0)
        assert max(levels(server, 0.05)) == 0.0
        bench.close()


@pytest.mark.parametrize(
    "way", ["supervisor", pytest.param("watchdog", marks=pytest.mark.thorough("waits for a device once more"))]
)
def test_who_ends_them_from_outside_brings_both_outputs_to_zero(both: Rig, way: str) -> None:
    guarded = both.model_copy(update={"excitation": Excitation(watchdog_s=1.5 if way == "watchdog" else 5.0)})
    with NiServer(both, "9215", "--pace", virtual=False) as server:
        bench, _ = started(server, guarded)
        assert isinstance(bench, DrivesSeveralShakers)
        bench.play_waves(WAVES)
        # A watchdog would not wait for one long read.
        for _ in range(60):
            bench.read(50, 5.0)
        assert sorted(levels(server, 0.3))[-2] > 0.05
        if way == "supervisor":
            handle = open_output(server.url, guarded)
            assert handle is not None
            handle.zero()
            handle.close()
        time.sleep(2.5 if way == "watchdog" else 0.6)
        assert max(levels(server, 0.05)) == 0.0
        with pytest.raises(BenchError):
            bench.read(6000, 5.0)
        bench.close()


def levels(server: NiServer, over_s: float) -> list[float]:
    found = server.say(f"levels {over_s}")
    return [value for name, value in found.items() if "/ao" in name]


def test_fewer_outputs_than_shakers_or_one_that_is_not_there_is_said_when_the_bench_is_opened(
    server: NiServer, both: Rig
) -> None:
    five = both.model_copy(update={"shakers": 4 * both.shakers})
    wrong = both.model_copy(update={"shakers": (Shaker(point=9, force=TIP, output="cDAQ1Mod4/ao9"),)})
    none = "no output is left, there are 4"
    for rig, words in ((wrong, r"shakers\[0\]\.output: found 'cDAQ1Mod4/ao9'"), (five, none)):
        with pytest.raises(ConfigurationError, match=words):
            open_bench(server.url, rig)
