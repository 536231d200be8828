"""A channel that fails stops the drive: within 0.3 s, with no block accepted; a sound one never does."""

import numpy as np
import pytest
from scripted_bench import ScriptedBench, scripted_rig

from modallab.acquisition.monitor.burst_windows import ExchangedChannels
from modallab.acquisition.monitor.plausibility import KnownShapes, Plausibility
from modallab.acquisition.monitor.rest_noise import RepetitionCounter, RestNoise, clipped_channels
from modallab.acquisition.monitor.tone_prediction import channel_faults, is_dead, predict_later_window, tone_basis
from modallab.acquisition.process.run import record_run, run_plan
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Burst, SampleChunk
from modallab.core.errors import SafetyError
from modallab.core.plan import ForceControl, SinePlan
from modallab.core.rig import Limits, Rig
from modallab.storage import Store
from modallab_simulators.faults import KINDS, ChannelFault, FaultyBench, Kind

LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=20.0)
SCRIPTED = scripted_rig(LIMITS)
PLAN = SinePlan(frequencies_hz=(27.34375, 60.0), levels_v={"low": 0.5}, settle_s=2.0, wait_s=1.0, settle_timeout_s=3.0)
T = np.arange(1000) / 1000
RNG = np.random.default_rng(3)


class Timed(FaultyBench):
    """Knows how many samples had been read when the output was brought to 0 V after the fault."""

    read_so_far = 0
    zeroed_at = 0

    def read(self, count, timeout_s):
        chunk = super().read(count, timeout_s)
        self.read_so_far = chunk.first_sample + count
        return chunk

    def zero(self):
        super().zero()
        self.zeroed_at = self.zeroed_at or (self.read_so_far if self.at is not None else 0)


@pytest.mark.parametrize("channel", [0, 9])
@pytest.mark.parametrize("kind", KINDS)
def test_a_channel_that_fails_in_a_burst_stops_the_drive_and_spoils_no_block(
    store: Store, link_rig: Rig, kind: Kind, channel: int
) -> None:
    # In the rise, in the settled part, and in the last tenth of a second of the block.
    for seed, part in enumerate((0.2, 0.45, 0.72)):
        fault = ChannelFault(kind, channel, burst=1, part=part, other=5)
        bench = Timed(open_bench(f"sim://cantilever?seed={seed}&zeta=0.02", link_rig), fault, seed)
        with store.begin(PLAN, link_rig, bench.info) as recorder, pytest.raises(SafetyError):
            run_plan(bench, link_rig, PLAN, recorder, lambda _: None, chunk_s=0.02)
        assert bench.at is not None
        assert (bench.zeroed_at - bench.at) / PLAN.rate_hz <= 0.3
        rows = store.catalogue.blocks(recorder.run)
        assert [row.note.accepted for row in rows] == [False]
        assert rows[0].note.name.endswith("_tripped")


@pytest.mark.parametrize("volts", [0.02, 2.0])
def test_a_sound_bench_is_never_stopped_low_or_high_at_a_resonance_or_beside_it(
    store: Store, link_rig: Rig, volts: float
) -> None:
    lines = (3 / 1.024, 5 / 1.024, 6 / 1.024, 31 / 1.024, 96 / 1.024)
    plan = SinePlan(frequencies_hz=lines, levels_v={"only": volts}, settle_s=2.0, wait_s=1.0, settle_timeout_s=4.0)
    rig = link_rig.model_copy(update={"limits": LIMITS.model_copy(update={"acceleration_m_s2": 1000.0})})
    run = record_run(open_bench("sim://cantilever?seed=2&zeta=0.01", rig), rig, plan, store, lambda _: None)
    assert len(store.blocks(run)) == len(lines)


class Unplugged(ScriptedBench):
    """The force sensor is not there: its input shows its noise."""

    def _counts(self, first: int, count: int) -> np.ndarray:
        counts = super()._counts(first, count)
        counts[0] = self.noise[0, np.arange(first, first + count) % self.noise.shape[1]]
        return counts


def test_without_a_force_sensor_a_force_control_never_raises_the_drive(store: Store) -> None:
    bench = Unplugged()
    plan = PLAN.model_copy(update={"force": ForceControl(levels_n={"low": 1.0})})
    with pytest.raises(SafetyError, match="force shows no force at"):
        record_run(bench, SCRIPTED, plan, store, lambda _: None)
    assert bench.done.count("play") == 1
    (run,) = store.catalogue.runs()
    assert [row.note.accepted for row in store.catalogue.blocks(run.id)] == [False]


class Weakened(ScriptedBench):
    """After the first burst the force reads a tenth for the same drive."""

    def _counts(self, first: int, count: int) -> np.ndarray:
        counts = super()._counts(first, count)
        if self.done.count("play") > 1:
            noise = self.noise[0, np.arange(first, first + count) % self.noise.shape[1]]
            counts[0] = noise + (counts[0] - noise) / 10
        return counts


def test_a_force_that_does_not_answer_the_drive_as_in_the_burst_before_is_not_corrected_by(store: Store) -> None:
    bench = Weakened()
    plan = PLAN.model_copy(update={"force": ForceControl(levels_n={"low": 1.0})})
    with pytest.raises(SafetyError, match=r"where the\s+previous burst gave"):
        record_run(bench, SCRIPTED, plan, store, lambda _: None)
    assert bench.done.count("play") == 2


class DeadAtRest(ScriptedBench):
    """An accelerometer delivers zeros from the end of the first burst on."""

    def _counts(self, first: int, count: int) -> np.ndarray:
        counts = super()._counts(first, count)
        if self.bursts and first > self.bursts[0][0] + 5000:
            counts[1] = 0
        return counts


def test_a_channel_that_dies_at_rest_lets_no_further_burst_begin(store: Store) -> None:
    bench = DeadAtRest()
    with pytest.raises(SafetyError, match="a01 reads less than its own noise"):
        record_run(bench, SCRIPTED, PLAN, store, lambda _: None)
    assert bench.done.count("play") == 1
    assert len(store.blocks(store.catalogue.runs()[0].id)) == 1


def windows(later: np.ndarray) -> tuple[np.ndarray, object, np.ndarray]:
    basis = tone_basis(T, 30.0, np.ones_like(T))
    earlier = np.stack([a * np.cos(2 * np.pi * 30 * T[:100] + a) for a in (1.0, 2.0, 3.0)])
    noise = np.full(3, 0.01)
    earlier = earlier + 0.01 * RNG.standard_normal(earlier.shape)
    return (
        later + 0.01 * RNG.standard_normal(later.shape),
        predict_later_window(earlier, basis[:100], basis[120:170]),
        noise,
    )


def sound() -> np.ndarray:
    return np.stack([a * np.cos(2 * np.pi * 30 * T[120:170] + a) for a in (1.0, 2.0, 3.0)])


def test_what_follows_the_drive_is_sound_and_a_knock_is_no_fault() -> None:
    for later in (sound(), sound() + np.sin(2 * np.pi * 77 * T[120:170]), 1.3 * sound()):
        seen, foreseen, noise = windows(later)
        assert channel_faults(seen, foreseen, noise, noise) == {}
        assert not is_dead(seen, foreseen, noise).any()


def test_what_a_channel_does_instead_says_what_has_become_of_it() -> None:
    later = sound()
    later[0] = np.linspace(0.4, 0.3, 50)
    seen, foreseen, noise = windows(later)
    assert is_dead(seen, foreseen, noise).tolist() == [True, False, False]
    seen, foreseen, noise = windows(sound()[[0, 2, 1]])
    assert channel_faults(seen, foreseen, noise, noise) == {
        1: "and {2} are exchanged",
        2: "and {1} are exchanged",
    }
    seen, foreseen, noise = windows(sound())
    seen[2] = np.clip(seen[2], -1.8, 1.8)
    assert "clipped" in channel_faults(seen, foreseen, noise, noise)[2]


def test_a_repetition_is_counted_over_chunks_and_within_them() -> None:
    counter = RepetitionCounter(2)
    first = np.array([[1, 2, 3, 3], [5, 5, 5, 1]], dtype=np.int16)
    assert counter.longest_runs(first).tolist() == [2, 3]
    assert counter.longest_runs(np.array([[3, 3, 4], [1, 2, 2]], dtype=np.int16)).tolist() == [4, 2]


def test_noise_that_moves_the_count_never_repeats_it_as_long_as_a_frozen_one() -> None:
    for rms in (0.6, 1.0, 20.0):
        samples = np.rint(rms * RNG.standard_normal((1, 200_000))).astype(np.int16)
        noise = RestNoise.of(samples[:, :2048], counts=True)
        assert RepetitionCounter(1).longest_runs(samples)[0] < noise.longest_run[0] < 300
    still = RestNoise.of(np.zeros((1, 2048), dtype=np.int16), counts=True)
    assert still.longest_run[0] == np.inf
    assert not still.visible[0]


def test_flat_tops_are_a_cut_off_channel_and_a_coarsely_sampled_sine_is_none() -> None:
    noise = RestNoise.of(np.rint(RNG.standard_normal((1, 2048))).astype(np.int16), counts=True)
    for hz in (3.0, 30.0, 250.0):
        sine = np.rint(900 * np.sin(2 * np.pi * hz * T + 0.3) + RNG.standard_normal(1000)).astype(np.int16)[None]
        assert not clipped_channels(sine, noise).any()
    cut = np.clip(np.rint(900 * np.sin(2 * np.pi * 30 * T)), -600, 600).astype(np.int16)[None]
    assert clipped_channels(cut, noise).all()


def moved(rng: np.random.Generator, shapes: np.ndarray, growth: float) -> tuple[np.ndarray, np.ndarray]:
    """(11, 1000) volts of a rise in which two shapes beat, with noise; and its rest before."""
    t = np.arange(1000) / 1000
    parts = np.stack([growth * t**2 * np.sin(2 * np.pi * 23 * t), np.sin(2 * np.pi * 20 * t) * np.exp(-2 * t)])
    noise = rng.standard_normal((11, 1500))
    return shapes @ parts + noise[:, :1000], noise[:, 1000:]


@pytest.mark.parametrize("seed", range(5))
def test_plugs_that_change_places_are_seen_in_a_rise_too_and_a_new_shape_is_no_fault(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shapes = 20 * rng.standard_normal((11, 3))
    values, rest = moved(rng, shapes[:, :2], 10.0)
    one, other = sorted(rng.choice(11, 2, replace=False).tolist())

    def seen(later: np.ndarray) -> list[tuple[int, int] | None]:
        places = ExchangedChannels(rest, np.ones(11))
        places.add_older_samples(values[:, :800])
        return [places.find_exchanged(later[:, n : n + 50]) for n in (850, 870, 890)]

    assert seen(values) == [None, None, None]
    swapped = values.copy()
    swapped[[one, other]] = values[[other, one]]
    assert seen(swapped)[1:] == [(one, other)] * 2
    assert seen(values + np.outer(shapes[:, 2], np.sin(np.arange(1000) / 10))) == [None, None, None]


def test_a_response_in_a_node_is_not_missed_and_one_that_the_others_ask_for_is() -> None:
    rng = np.random.default_rng(3)
    modes = rng.standard_normal((10, 3)) + 0j
    modes[4] = 1.0, 0.5, 0.0
    known = KnownShapes()
    for _ in range(4):
        known.add_burst(1000 * modes[:, :2] @ rng.standard_normal(2) + rng.standard_normal(10))
    tone = 1000 * modes[:, :2] @ np.array([1.0, -0.5]) + rng.standard_normal(10)
    full = float(np.abs(tone[4]))
    tone[4] = 0.0
    assert 0.8 * full < known.must_read(4, tone) < full
    in_a_node = 1000 * modes[:, 2] + rng.standard_normal(10)
    assert known.must_read(4, in_a_node) == 0.0


def test_a_single_response_has_no_others_that_say_what_it_must_read() -> None:
    known = KnownShapes()
    known.add_burst(np.array([1000.0 + 0j]))
    assert known.must_read(0, np.array([3.0 + 0j])) == 0.0


def weak_tone_lost(at_s: float, largest: float) -> None:
    """Plays a burst in which one response is weak, and vanishes after `at_s`; others reach `largest`."""
    rng = np.random.default_rng(8)
    rate_hz, noise = 2000.0, 10.0
    burst = Burst(70.0, 0.5, 1.0, 4.0)
    times = np.arange(round(burst.duration_s * rate_hz)) / rate_hz
    tone = burst.envelope(times) * np.sin(2 * np.pi * burst.frequency_hz * times)
    sizes = np.array([500.0, largest, 0.7 * largest, 27.0])
    samples = sizes[:, None] * tone
    samples[3, times > at_s] = 0.0
    counts = np.round(samples + rng.normal(0, noise, samples.shape)).astype(np.int16)
    rest = np.round(rng.normal(0, noise, (4, 2000))).astype(np.int16)
    watch = Plausibility(("force", "a", "b", "c"), np.ones(4), np.ones(4), 0, (0, 1, 2, 3), rate_hz)
    watch.begin(burst, 0, rest, RestNoise.of(rest, counts=True), 0)
    for first in range(0, len(times), 40):
        watch(SampleChunk(first, counts[:, first : first + 40], np.zeros(4, dtype=np.bool_)))


def test_what_is_weak_beside_the_others_may_vanish_in_the_fall_and_nowhere_else() -> None:
    # While the drive falls, each mode lags it by a little of its own: at a node that little is all there is.
    weak_tone_lost(5.05, largest=9000.0)
    for at_s, largest in ((3.0, 9000.0), (5.05, 900.0)):
        with pytest.raises(SafetyError, match="c no longer follows the drive"):
            weak_tone_lost(at_s, largest)
