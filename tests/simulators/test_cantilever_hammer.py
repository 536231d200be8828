"""Hits of the virtual operator."""

from collections.abc import Callable

import numpy as np
import pytest

from modallab.bench.protocol import Bench
from modallab.core.errors import RigError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.hammer import (
    PEAK_N,
    REACTION_S,
    REBOUND_S,
    WEAK_N,
    WIDTH_S,
    ContactPulse,
    HammerHit,
    draw_hit,
)
from modallab_simulators.cantilever.recursion import DELAY

Running = Callable[..., Bench]

N_PER_COUNT = 10 / 2**15 / 0.02
RATE = 2000


def contacts(force: np.ndarray, threshold_n: float = 1.5) -> list[tuple[int, int]]:
    """First and last sample of each stretch above the threshold, gaps under 4 ms closed."""
    above = np.flatnonzero(force > threshold_n)
    if not above.size:
        return []
    cuts = np.flatnonzero(np.diff(above) > 8)
    starts, ends = above[np.r_[0, cuts + 1]], above[np.r_[cuts, above.size - 1]]
    return list(zip(starts.tolist(), ends.tolist(), strict=True))


def hit(bench: Bench, point: int) -> np.ndarray:
    bench.prompt_hit(point)
    return bench.read(2 * RATE, 1.0).samples[0] * N_PER_COUNT


def test_a_pulse_is_smooth_and_ends():
    pulse = ContactPulse(0.1, 0.004, 80.0)
    times = np.linspace(0.09, 0.12, 3001)
    force = pulse.force(times)
    assert force.max() == pytest.approx(80.0, rel=1e-6)
    assert not force[(times < 0.1) | (times > 0.104)].any()
    # Impulse of a sin^2 pulse: half its peak times its width.
    assert np.trapezoid(force, times) == pytest.approx(80 * 0.004 / 2, rel=1e-4)


def test_a_hit_of_two_contacts_is_their_sum():
    first, second = ContactPulse(0.1, 0.004, 80.0), ContactPulse(0.13, 0.004, 20.0)
    both = HammerHit(0.5, (first, second))
    times = np.linspace(0.09, 0.15, 500)
    np.testing.assert_array_equal(both.force(times), first.force(times) + second.force(times))
    assert (both.start_s, both.end_s) == (0.1, pytest.approx(0.134))


def test_a_prompt_gives_one_hit_after_the_reaction_time(running: Running):
    bench = running("seed=3&bad_hits=0")
    for point in (6, 10, 3, 1):
        found = contacts(hit(bench, point))
        assert len(found) == 1
        start, end = found[0]
        assert REACTION_S[0] - 0.002 <= (start - DELAY) / RATE <= REACTION_S[1] + 0.002
        assert (end - start) / RATE <= WIDTH_S[1] + 0.002
    assert not contacts(bench.read(5 * RATE, 1.0).samples[0] * N_PER_COUNT)


def test_no_hit_comes_unasked(running: Running):
    assert not contacts(running("bad_hits=1").read(5 * RATE, 1.0).samples[0] * N_PER_COUNT)


def test_good_hits_neither_overload_nor_drown(running: Running, rig: Rig):
    for seed in range(3):
        bench = running(f"seed={seed}&bad_hits=0")
        for point in (p.id for p in rig.points):
            bench.prompt_hit(point)
            chunk = bench.read(2 * RATE, 1.0)
            assert not chunk.overload.any()
            assert chunk.samples[0].max() * N_PER_COUNT > 15
            assert np.abs(chunk.samples[1:]).max() > 2**15 * 0.2
            bench.read(20 * RATE, 1.0)


def test_bad_hits_appear_as_often_as_asked():
    swings = [draw_hit(np.random.default_rng(seed), 0.3, 0.0) for seed in range(1000)]
    double = np.mean([s.rebound_s > 0 for s in swings])
    weak = np.mean([s.weak_n > 0 for s in swings])
    assert 0.11 < double < 0.19
    assert 0.11 < weak < 0.19
    assert not any(s.rebound_s and s.weak_n for s in swings)
    good = [s for s in swings if not s.rebound_s and not s.weak_n]
    assert all(PEAK_N[0] <= s.peak_n <= PEAK_N[1] and WIDTH_S[0] <= s.width_s <= WIDTH_S[1] for s in good)


def test_double_hits_and_weak_ones_show_in_the_force(running: Running):
    bench, kinds = running("seed=5&bad_hits=1"), set()
    for _ in range(12):
        force = hit(bench, 6)
        found = contacts(force)
        if len(found) == 2:
            gap = (found[1][0] - found[0][0]) / RATE
            assert REBOUND_S[0] - 0.003 <= gap <= REBOUND_S[1] + 0.003
            kinds.add("double")
        elif len(found) == 1:
            assert WEAK_N[0] / 2 < force.max() < WEAK_N[1] * 1.1
            kinds.add("weak")
    assert kinds == {"double", "weak"}


def test_the_place_error_is_none_unless_asked_for():
    assert draw_hit(np.random.default_rng(1), 0.0, 0.0).place_m == 0
    places = [draw_hit(np.random.default_rng(seed), 0.0, 0.002).place_m for seed in range(300)]
    assert 0.0017 < np.std(places) < 0.0023


def test_a_newer_prompt_replaces_a_hit_that_has_not_come(running: Running):
    def struck_at_three(first_asked: int) -> np.ndarray:
        bench = running("seed=3&bad_hits=0")
        bench.prompt_hit(first_asked)
        bench.read(100, 1.0)
        bench.prompt_hit(3)
        return bench.read(2 * RATE, 1.0).samples

    samples = struck_at_three(10)
    assert len(contacts(samples[0] * N_PER_COUNT)) == 1
    np.testing.assert_array_equal(struck_at_three(6), samples)


def test_a_point_that_is_not_on_the_rig_is_rejected(running: Running):
    with pytest.raises(RigError, match="point 11 is not on the rig"):
        running().prompt_hit(11)
