"""A channel that fails while a wave plays stops the drive: within 0.3 s, with no block that holds the fault."""

import numpy as np
import pytest

from modallab.acquisition.monitor.flat_tops import flat_tops
from modallab.acquisition.process.run import record, run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Chunk
from modallab.core.errors import SafetyError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND, Broadband
from modallab.storage import Store
from modallab_simulators.channel_faults import ChannelFault, FaultyBench, Kind

RATE_HZ = 2000.0


def plan_of(signal: Broadband, **fields: object) -> BroadbandPlan:
    given = {"signal": signal, "levels_v": {"low": 0.3}, "blocks": 3, "settle_s": 2.0, "wait_s": 1.0}
    return BroadbandPlan.model_validate(given | fields)


class Timed(FaultyBench):
    """Knows how many samples had been read when the output was brought to 0 V, and when a cut was first to be seen."""

    read_so_far = 0
    zeroed_at = 0
    bites_at = 0

    def read(self, count: int, timeout_s: float) -> Chunk:
        chunk = super().read(count, timeout_s)
        self.read_so_far = chunk.first_sample + count
        differs = np.flatnonzero((chunk.samples != self.sound).any(axis=0))
        if differs.size and not self.bites_at:
            self.bites_at = chunk.first_sample + int(differs[0])
        return chunk

    def zero(self) -> None:
        super().zero()
        self.zeroed_at = self.zeroed_at or (self.read_so_far if self.at is not None else 0)


@pytest.mark.parametrize("channel", [0, 9])
@pytest.mark.parametrize("kind", ["dead", "frozen", "unplugged", "clipped"])
@pytest.mark.parametrize("signal", ["pseudo-random", "random", "chirp"])
def test_a_channel_that_fails_in_a_wave_stops_the_drive_and_spoils_no_block_that_counts(
    store: Store, link_rig: Rig, signal: Broadband, kind: Kind, channel: int
) -> None:
    plan = plan_of(signal)
    # In the first second, between two blocks, and late in a block.
    for seed, part in enumerate((0.15, 0.54, 0.75)):
        fault = ChannelFault(kind, channel, part=part, level=0.5)
        bench = Timed(open_bench(f"sim://cantilever?seed={seed}", link_rig), fault, seed)
        with store.begin(plan, link_rig, bench.info) as recorder, pytest.raises(SafetyError):
            run_plan(bench, link_rig, plan, recorder, lambda _: None, chunk_s=0.02)
        assert bench.at is not None
        assert (bench.zeroed_at - bench.bites_at) / RATE_HZ <= 0.3
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
    for seed in (2, 3):
        run = record(open_bench(f"sim://cantilever?seed={seed}", rig), rig, plan, store, lambda _: None)
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
        record(bench, rig, plan_of("random"), store, lambda _: None)


def smooth(rng: np.random.Generator, rms: float, highest: float) -> np.ndarray:
    spectrum = np.zeros(201, complex)
    spectrum[1 : int(highest * 200)] = rng.standard_normal(int(highest * 200) - 1) + 1j * rng.standard_normal(
        int(highest * 200) - 1
    )
    values = np.fft.irfft(spectrum, 400)
    return rms * values / values.std() + 0.7 * rng.standard_normal(400)


def test_a_sound_signal_has_no_flat_tops_and_a_cut_one_has() -> None:
    rng = np.random.default_rng()
    noise, step = np.array([0.7]), np.array([1.0])
    for rms in (5.0, 50.0, 500.0, 5000.0):
        for highest in (0.03, 0.2, 0.5, 0.9):
            found = [flat_tops(np.rint(smooth(rng, rms, highest))[None], noise, step)[0] for _ in range(200)]
            assert not any(found)
    for hz in (3.0, 20.0, 40.0, 100.0, 250.0):
        for amplitude in (100.0, 1000.0, 30000.0):
            phases = rng.uniform(0, 6.28, 100)
            tones = amplitude * np.sin(2 * np.pi * hz * np.arange(400) / 2000 + phases[:, None])
            tones = np.rint(tones + 0.7 * rng.standard_normal(tones.shape))
            assert not flat_tops(tones, np.full(100, 0.7), np.ones(100)).any()
    for highest in (0.03, 0.2, 0.4):
        cut = np.rint(np.clip(smooth(rng, 1000.0, highest), -1000, 1000))[None]
        assert flat_tops(cut, noise, step)[0]
