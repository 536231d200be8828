"""The settling fit against sums of sines and decays that are known exactly, and against the simulated beam."""

import json

import numpy as np
import pytest
from scripted_bench import ScriptedBench, Strike, scripted_rig

from modallab.acquisition.procedures.settling import amplitude_at, fit_settling
from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.bench.protocol import Burst
from modallab.core.errors import PlanError
from modallab.core.plan import KnownMode, SinePlan
from modallab.core.rig import Limits, Rig
from modallab.storage import Store

RATE = 1000.0
MODES = (KnownMode(frequency_hz=4.8, damping_ratio=0.005), KnownMode(frequency_hz=30.0, damping_ratio=0.004))


def record_of(ratios: tuple[float, float], drive_hz: float, noise: float, before: int = 4096, seed: int = 3):
    """Force, motion (3, n): a response of 1, 2, 3 and decays of the given ratios at sample `before`."""
    rng = np.random.default_rng(seed)
    t = (np.arange(before + 1024) - before) / RATE
    size = np.array([1.0, 2.0, 3.0])[:, None]
    motion = size * np.sin(2 * np.pi * drive_hz * t + 0.4) + 0.7
    for ratio, mode in zip(ratios, MODES, strict=True):
        omega = 2 * np.pi * mode.frequency_hz
        wave = np.exp(-mode.damping_ratio * omega * t) * np.cos(omega * np.sqrt(1 - mode.damping_ratio**2) * t + 1.1)
        motion += ratio * size[::-1] * wave
    force = 0.5 * np.sin(2 * np.pi * drive_hz * t) + noise / 10 * rng.standard_normal(t.size)
    return force, motion + noise * rng.standard_normal(motion.shape)


@pytest.mark.parametrize("drive_hz", [3.0, 4.88, 4.8, 29.3, 84.0])
@pytest.mark.parametrize("ratios", [(0.03, 0.01), (0.0, 0.02), (0.0, 0.0)])
def test_without_noise_the_decays_are_found_exactly_beats_or_not(drive_hz: float, ratios: tuple[float, float]) -> None:
    force, motion = record_of(ratios, drive_hz, 0.0)
    found = fit_settling(force, motion, RATE, 4096, drive_hz, MODES)
    assert found is not None
    np.testing.assert_allclose(found.ratio, ratios, atol=1e-6)
    assert found.verdict(0.005) == ("yes" if not any(ratios) else "no")


@pytest.mark.parametrize("ppm", [-100.0, 100.0])
def test_the_generators_own_clock_makes_no_decay(ppm: float) -> None:
    force, motion = record_of((0.0, 0.0), 84.0 * (1 + ppm * 1e-6), 0.0)
    found = fit_settling(force, motion, RATE, 4096, 84.0, MODES)
    assert found is not None
    assert found.frequency_hz == pytest.approx(84.0 * (1 + ppm * 1e-6), rel=1e-9)
    assert found.total_decay < 1e-6


def test_with_noise_the_error_is_what_sigma_says() -> None:
    errors = []
    for seed in range(60):
        force, motion = record_of((0.03, 0.01), 8.0, 0.2, seed=seed)
        found = fit_settling(force, motion, RATE, 4096, 8.0, MODES)
        assert found is not None
        errors.append((found.ratio - (0.03, 0.01)) / found.sigma)
    assert np.sqrt(np.mean(np.square(errors))) < 1.5


def test_where_noise_hides_the_decay_the_verdict_is_unknown() -> None:
    force, motion = record_of((0.002, 0.0), 8.0, 3.0)
    found = fit_settling(force, motion, RATE, 4096, 8.0, MODES)
    assert found is not None
    assert found.verdict(0.005) == "unknown"


def test_the_time_that_is_missing_is_that_of_the_slowest_decay() -> None:
    force, motion = record_of((0.05, 0.0), 84.0, 0.0)
    found = fit_settling(force, motion, RATE, 4096, 84.0, MODES)
    assert found is not None
    expected = np.log(0.05 / (0.005 / np.sqrt(2))) / (0.005 * 2 * np.pi * 4.8)
    assert found.further_wait_s(0.005) == pytest.approx(expected, rel=1e-3)


def test_without_a_mode_in_reach_there_is_nothing_to_judge() -> None:
    force, motion = record_of((0.0, 0.0), 84.0, 0.0)
    assert fit_settling(force, motion, RATE, 4096, 84.0, ()) is None
    assert fit_settling(force, motion[:0], RATE, 4096, 84.0, MODES) is None
    assert fit_settling(force, 0 * motion, RATE, 4096, 84.0, MODES) is None


def test_the_amplitude_is_that_of_the_sine() -> None:
    force, _ = record_of((0.0, 0.0), 84.003, 0.0, before=0)
    assert amplitude_at(force, RATE, 84.0) == pytest.approx(0.5, rel=1e-6)


LIMITS = Limits(drive_v=5.0, slew_v_per_s=5000.0, force_n=50.0, acceleration_m_s2=60.0, max_burst_s=60.0)
RINGS = KnownMode(frequency_hz=60.0, damping_ratio=0.002)
"""The scripted bench's own mode, with 1.33 s to 1/e."""


class RingingBench(ScriptedBench):
    """Every burst begins with a transient of the mode."""

    def play(self, burst: Burst) -> int:
        start = super().play(burst)
        self.hits.append((start, Strike(peak_n=0.0, response=1.0, zeta=RINGS.damping_ratio)))
        return start


def sine(**fields: object) -> SinePlan:
    plain = {"frequencies_hz": (27.34375,), "levels_v": {"low": 2.0}, "settle_s": 2.0, "wait_s": 2.0}
    return SinePlan.model_validate(plain | fields)


def test_a_block_that_has_not_settled_is_recorded_again_from_a_longer_burst(store: Store) -> None:
    # The response is 2 m/s^2, the transient 1 m/s^2 at its start: 11 % after 2 s, 0.5 % after 6.1 s.
    plan = sine(modes=(RINGS,), max_settle_s=10.0)
    run = record_run(RingingBench(), scripted_rig(LIMITS), plan, store, lambda _: None)
    first, second = store.catalogue.blocks(run)
    share = 0.5 * np.exp(-2.0 * 2 * np.pi * 60 * 0.002)
    assert first.note.facts["decay_ratio"] == pytest.approx(share, rel=0.02)
    assert (first.note.name, first.note.accepted) == ("sine_low_027.344_rejected_1", False)
    assert "not settled: the free decay at 60 Hz is 11" in first.note.reason
    assert (second.note.name, second.note.accepted, second.note.reason) == ("sine_low_027.344", True, "")
    assert second.note.facts["settled"] in ("yes", "unknown")
    assert float(second.note.facts["settle_s"]) == pytest.approx(2 + np.log(share / 0.005) * 1.326, abs=0.1)


def test_past_the_bound_it_is_kept_and_flagged(store: Store) -> None:
    run = record_run(RingingBench(), scripted_rig(LIMITS), sine(modes=(RINGS,)), store, lambda _: None)
    (only,) = store.catalogue.blocks(run)
    assert only.note.accepted
    assert "not settled" in only.note.reason
    assert only.note.facts["settled"] == "no"


def test_without_known_modes_nothing_is_judged_nor_lengthened(store: Store) -> None:
    run = record_run(RingingBench(), scripted_rig(LIMITS), sine(), store, lambda _: None)
    (only,) = store.catalogue.blocks(run)
    assert "settled" not in only.note.facts
    assert only.note.reason == ""


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"max_settle_s": 1.0, "modes": (RINGS,)}, "max_settle_s is 1; allowed: at least settle_s = 2"),
        ({"max_settle_s": 5.0}, "max_settle_s needs modes"),
        (
            {"max_settle_s": 70.0, "modes": (RINGS,)},
            "a burst of max_settle_s.* lasts 72.12 s; allowed by the rig: 60 s",
        ),
    ],
)
def test_bounds_that_make_no_sense_are_rejected_before_anything_moves(
    store: Store, fields: dict[str, object], said: str
) -> None:
    bench = ScriptedBench()
    with pytest.raises(PlanError, match=said):
        record_run(bench, scripted_rig(LIMITS), sine(**fields), store, lambda _: None)
    assert "play" not in bench.done


def test_on_the_beam_the_decay_that_is_seen_falls_as_its_mode_says(store: Store, link_rig: Rig) -> None:
    bench = open_bench("sim://cantilever?seed=4&zeta=0.01", link_rig)
    truth = json.loads(bench.info.facts["frequency_hz"])[:3]
    modes = tuple(KnownMode(frequency_hz=f, damping_ratio=0.01) for f in truth)
    seen: list[float] = []
    for settle_s in (3.0, 5.0):
        plan = SinePlan(frequencies_hz=(8 / 1.024,), settle_s=settle_s, ramp_s=0.2, wait_s=2.0, modes=modes)
        run = record_run(bench, link_rig, plan, store, lambda _: None)
        seen.append(float(store.catalogue.blocks(run)[0].note.facts["decay_ratio"]))
    assert seen[0] > 0.02
    assert seen[0] / seen[1] == pytest.approx(np.exp(2.0 * 0.01 * 2 * np.pi * truth[0]), rel=0.05)
