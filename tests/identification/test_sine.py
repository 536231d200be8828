import functools

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.options import IdentificationOptions
from modallab.identification.sine import identify_sine
from modallab.signals.signals import to_signals_of

LINES = np.array([3, 4, 5, 6, 7, 8, 9, 12, 18, 30, 45, 50, 54, 56, 58, 60, 64, 72, 90, 130, 150, 158, 162, 170]) / 1.024


@functools.cache
def identified(seed, **how):
    rng = np.random.default_rng(seed)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.sine_blocks(system, rng, LINES * (1 + 12e-6), **how)
    return system, *identify_sine(to_signals_of(blocks, rig), rig, IdentificationOptions())


def test_true_poles_come_out_of_blocks_that_still_ring():
    system, model, fit = identified(1)
    assert fit.refined.settled
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz, rtol=1e-3)
    np.testing.assert_allclose(model.damping_ratio, system.zeta, rtol=0.05)


@pytest.mark.thorough("identifies many recordings")
def test_stated_sigma_is_the_scatter():
    normalised = []
    for seed in range(4):
        system, model, _ = identified(seed)
        normalised += list((model.frequency_hz - system.frequency_hz) / model.frequency_sigma_hz)
        normalised += list((model.damping_ratio - system.zeta) / model.damping_sigma)
    assert 1 / 1.5 < np.sqrt(np.mean(np.square(normalised))) < 1.5


def test_settling_less_changes_the_blocks_but_not_the_poles():
    system, short, _ = identified(2, settle_s=2.0)
    np.testing.assert_allclose(short.frequency_hz, system.frequency_hz, rtol=1e-3)
    np.testing.assert_allclose(short.damping_ratio, system.zeta, rtol=0.05)


def test_the_generators_clock_is_found_and_said():
    rng = np.random.default_rng(3)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.sine_blocks(system, rng, LINES * (1 + 50e-6))
    reported = [
        type(b)(**{f: getattr(b, f) for f in b.__slots__} | {"frequency_hz": float(line)})
        for b, line in zip(blocks, LINES, strict=True)
    ]
    model, _ = identify_sine(to_signals_of(reported, rig), rig, IdentificationOptions())
    note = next(n for n in model.notes if "ppm" in n)
    assert 45 <= float(note.split("runs ")[1].split(" ppm")[0]) <= 55


def test_a_shaker_that_was_off_is_rejected():
    rng = np.random.default_rng(4)
    rig = bench.rig(5)
    block = bench.block("off", "sine", 0, 1000.0, 0.001 * rng.standard_normal((6, 1024)), 3, frequency_hz=10.0)
    with pytest.raises(DataError, match="no sine"):
        identify_sine(to_signals_of([block], rig), rig, IdentificationOptions())


def test_too_few_frequencies_are_rejected():
    rng = np.random.default_rng(5)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.sine_blocks(system, rng, LINES[::8])
    with pytest.raises(IdentificationError):
        identify_sine(to_signals_of(blocks, rig), rig, IdentificationOptions())


def test_two_drive_points_are_rejected():
    rng = np.random.default_rng(6)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.sine_blocks(system, rng, LINES[:4], point=3) + bench.sine_blocks(system, rng, LINES[4:8], point=5)
    with pytest.raises(DataError, match="points"):
        identify_sine(to_signals_of(blocks, rig), rig, IdentificationOptions())
