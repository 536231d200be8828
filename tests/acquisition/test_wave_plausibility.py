"""A channel that fails while a wave plays stops the drive: within 0.3 s, with no block that holds the fault."""

import numpy as np
import pytest

from modallab.acquisition.monitor.rest_noise import RestNoise
from modallab.acquisition.monitor.wave_samples import flat_tops
from modallab.acquisition.process.run import record_run, run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband
from modallab.storage import Store
from modallab_simulators.faults import ChannelFault, FaultyBench, Kind

RATE_HZ = 2000.0
MANY, MANY_S = 16, 0.12
"""A cut that so few samples of so long reach cannot be distinguished from a top by chance."""


def plan_of(signal: Broadband, **fields: object) -> BroadbandPlan:
    given = {"signal": signal, "levels_v": {"low": 0.3}, "blocks": 3, "settle_s": 2.0, "wait_s": 1.0}
    return BroadbandPlan.model_validate(given | fields)


class Timed(FaultyBench):
    """Knows how many samples had been read at 0 V, the first wrong one, and from where on many are wrong."""

    read_so_far = 0
    zeroed_at = 0
    bites_at = 0
    seen_from = 0
    _wrong = np.zeros(0, dtype=np.int64)

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        chunk = super().read(count, timeout_s)
        self.read_so_far = chunk.first_sample + count
        wrong = chunk.first_sample + np.flatnonzero((chunk.samples != self.sound).any(axis=0))
        if wrong.size and not self.bites_at:
            self.bites_at = int(wrong[0])
        self._wrong = np.concatenate([self._wrong, wrong])
        close = np.flatnonzero(self._wrong[MANY:] - self._wrong[:-MANY] <= MANY_S * RATE_HZ)
        if close.size and not self.seen_from:
            self.seen_from = int(self._wrong[MANY:][close[0]])
        return chunk

    def zero(self) -> None:
        super().zero()
        self.zeroed_at = self.zeroed_at or (self.read_so_far if self.at is not None else 0)


@pytest.mark.parametrize("channel", [0, 9])
@pytest.mark.parametrize("kind", ["dead", "frozen", "unplugged", "clipped"])
@pytest.mark.parametrize(("signal", "part"), [("pseudo-random", 0.15), ("random", 0.54), ("chirp", 0.75)])
def test_a_channel_that_fails_in_a_wave_stops_the_drive_and_spoils_no_block_that_counts(
    store: Store, link_rig: Rig, signal: Broadband, part: float, kind: Kind, channel: int
) -> None:
    plan = plan_of(signal)
    # In the first second, between two blocks, and late in a block.
    fault = ChannelFault(kind, channel, part=part, level=0.5)
    bench = Timed(open_bench("sim://cantilever?seed=1", link_rig), fault)
    with store.begin(plan, link_rig, bench.info) as recorder, pytest.raises(SafetyError):
        run_plan(bench, link_rig, plan, recorder, lambda _: None, chunk_s=0.02)
    assert bench.at is not None
    assert (bench.zeroed_at - (bench.seen_from or bench.zeroed_at)) / RATE_HZ <= 0.3
    rows = store.catalogue.blocks(recorder.run)
    assert rows[-1].note.name.endswith("_tripped")
    assert not [r for r in rows if r.note.accepted and r.note.first_sample + r.count > bench.bites_at]


@pytest.mark.parametrize("volts", [0.01, 0.5])
@pytest.mark.parametrize("signal", BROADBAND)
def test_a_sound_bench_is_never_stopped_low_or_high(
    store: Store, link_rig: Rig, signal: Broadband, volts: float
) -> None:
    plan = plan_of(signal, levels_v={"low": volts}, blocks=6)
    assert link_rig.limits is not None
    high = link_rig.limits.model_copy(update={"acceleration_m_s2": 1000.0})
    rig = link_rig.model_copy(update={"limits": high})
    run = record_run(open_bench("sim://cantilever?seed=2", rig), rig, plan, store, lambda _: None)
    assert len(store.blocks(run)) == 6


def test_blocks_are_written_when_their_wave_is_over(store: Store, link_rig: Rig) -> None:
    plan = plan_of("pseudo-random")
    bench = Timed(open_bench("sim://cantilever?seed=1", link_rig), ChannelFault("dead", 9, burst=9))
    read: list[int] = []
    with store.begin(plan, link_rig, bench.info) as recorder:
        run_plan(bench, link_rig, plan, recorder, lambda _: read.append(bench.read_so_far), chunk_s=0.02)
    rows = store.catalogue.blocks(recorder.run)
    assert len(rows) == 3
    end = rows[-1].note.first_sample + rows[-1].count
    assert sum(at > end for at in read) >= 3


def test_limits_of_motion_hold_in_a_wave(store: Store, link_rig: Rig) -> None:
    assert link_rig.limits is not None
    limits = link_rig.limits.model_copy(update={"velocity_m_s": 1e-4})
    rig = link_rig.model_copy(update={"limits": limits})
    bench = open_bench("sim://cantilever?seed=1", rig)
    with pytest.raises(SafetyError, match="beyond the abort limit: velocity of"):
        record_run(bench, rig, plan_of("random"), store, lambda _: None)


def noise_of(rms: float, rng: np.random.Generator) -> RestNoise:
    return RestNoise.of(np.rint(rms * rng.standard_normal((1, 4000))), counts=True)


def smooth(rng: np.random.Generator, rms: float, highest: float) -> np.ndarray:
    """240 samples of what has no line above a part of half the rate."""
    spectrum = np.zeros(201, complex)
    inside = spectrum[1 : 1 + int(highest * 200)]
    inside[:] = rng.standard_normal(inside.size) + 1j * rng.standard_normal(inside.size)
    values = np.fft.irfft(spectrum, 400)
    return rms * values[:240] / values.std()


@pytest.mark.parametrize("noise", [0.5, 0.7, 3.0])
def test_a_sound_signal_has_no_flat_tops(noise: float) -> None:
    rng = np.random.default_rng()
    own = noise_of(noise, rng)
    times = np.arange(240) / RATE_HZ
    for level in (20.0, 50.0, 500.0, 5000.0, 20000.0):
        signals = [smooth(rng, level, float(h)) for h in rng.choice([0.01, 0.03, 0.1, 0.3, 0.6, 0.9], 60)]
        signals += [
            level * np.sin(2 * np.pi * f * times + p) for f, p in zip(*rng.uniform(0.5, 300, (2, 60)), strict=True)
        ]
        for signal in signals:
            seen = np.rint(signal + noise * rng.standard_normal(240))
            assert not flat_tops(seen[None], own)[0]


def test_a_cut_signal_has_flat_tops() -> None:
    rng = np.random.default_rng()
    own = noise_of(1.0, rng)
    for highest in (0.05, 0.2, 0.4):
        for _ in range(50):
            signal = smooth(rng, 700.0, highest)
            top = 0.6 * np.abs(signal).max()
            seen = np.rint(np.clip(signal + rng.standard_normal(240), -top, top))
            assert flat_tops(seen[None], own)[0] or (seen == seen.max()).sum() + (seen == seen.min()).sum() < 16
