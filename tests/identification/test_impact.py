import functools
from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.errors import DataError, IdentificationError
from modallab.identification.impact import identify_impact
from modallab.identification.model.modal_model import with_hit_shares
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection.pre_trigger_noise import model_error
from modallab.signals.signals import to_signals_of

TWO_POINTS = (5, 3)


@functools.cache
def identified(seed, options=None, **how):
    rng = np.random.default_rng(seed)
    system = bench.modes(rng)
    rig = bench.rig(5)
    signals = to_signals_of(bench.impact_blocks(system, rng, **how), rig)
    return system, *identify_impact(signals, rig, options or IdentificationOptions(band_hz=(2.9, 400.0)))


def test_true_poles_come_out_of_a_block_shorter_than_the_ring_down():
    system, model, fit = identified(1)
    assert fit.refined.settled
    assert model.n_modes == 3
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz, rtol=2e-4)
    np.testing.assert_allclose(model.damping_ratio, system.zeta, rtol=0.03)


@pytest.mark.parametrize("seed", range(3))
def test_a_pole_above_the_band_leaves_those_within_it_right(seed):
    system, model, fit = identified(seed, IdentificationOptions(band_hz=(2.9, 75.0)))
    within = system.frequency_hz < 75.0
    assert fit.refined.settled
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz[within], rtol=5e-4)
    np.testing.assert_allclose(model.damping_ratio, system.zeta[within], rtol=0.05)


@pytest.mark.thorough("identifies many recordings")
def test_stated_sigma_is_the_scatter():
    normalised = []
    for seed in range(5):
        system, model, _ = identified(seed)
        normalised += list((model.frequency_hz - system.frequency_hz) / model.frequency_sigma_hz)
        normalised += list((model.damping_ratio - system.zeta) / model.damping_sigma)
    # 36 numbers: their rms scatters by 12 %, so 1 / 1.5 to 1.5 is some three sigmas wide; the seeds are fixed.
    assert 1 / 1.5 < np.sqrt(np.mean(np.square(normalised))) < 1.5


def test_modal_constants_and_unit_mass_shapes_are_those_of_the_structure():
    system, model, _ = identified(2, points=TWO_POINTS)
    expected = system.phi[:, :, None] * system.phi[:, [4, 2]][:, None, :]
    error = np.abs(model.modal_constants - expected)
    assert np.all(error < 5 * model.modal_constant_sigma + 1e-3 * np.abs(expected).max(axis=(1, 2), keepdims=True))
    sign = np.sign(np.sum(model.shapes.real * system.phi, axis=1))
    np.testing.assert_allclose(sign[:, None] * model.shapes.real, system.phi, atol=4e-3)
    assert np.abs(model.shapes.imag).max() < 0.01


def test_hits_at_two_points_share_their_poles():
    _, one, _ = identified(3)
    _, two, _ = identified(3, points=TWO_POINTS)
    assert two.input_points == TWO_POINTS
    assert np.all(two.damping_sigma < one.damping_sigma)


def test_a_beam_that_still_rings_before_the_hit_is_said_and_modelled():
    system, model, _ = identified(4, rest=2.0)
    assert any("before the hit" in note for note in model.notes)
    np.testing.assert_allclose(model.frequency_hz[0], system.frequency_hz[0], rtol=5e-4)
    np.testing.assert_allclose(model.damping_ratio[0], system.zeta[0], rtol=0.08)


def test_half_power_reads_the_block_and_its_floor_says_so():
    _, model, _ = identified(5)
    assert model.half_power[0] > 5 * model.damping_ratio[0]
    assert model.half_power[0] == pytest.approx(model.half_power_floor[0], rel=0.35)


def test_samples_in_integers_or_floats_give_the_same_model():
    rng = np.random.default_rng(6)
    system, rig = bench.modes(rng), bench.rig(5)
    blocks = bench.impact_blocks(system, rng)
    counts = []
    for b in blocks:
        samples = np.round(b.samples / 1e-4).astype(np.int32)
        counts.append(bench.block(b.name, "impact", b.order, b.rate_hz, samples, b.drive_point))
    scaled = [type(b)(**{f: getattr(b, f) for f in b.__slots__} | {"scale": np.full(6, 1e-4)}) for b in counts]
    one, _ = identify_impact(to_signals_of(blocks, rig), rig, IdentificationOptions(band_hz=(2.9, 400.0)))
    two, _ = identify_impact(to_signals_of(scaled, rig), rig, IdentificationOptions(band_hz=(2.9, 400.0)))
    np.testing.assert_allclose(one.frequency_hz, two.frequency_hz, rtol=1e-6)


def test_a_block_without_a_hit_is_rejected():
    rng = np.random.default_rng(7)
    rig = bench.rig(5)
    still = bench.block("still", "impact", 0, 2000.0, 0.03 * rng.standard_normal((6, 2048)), 5)
    with pytest.raises(DataError, match="no hit"):
        identify_impact(to_signals_of([still], rig), rig, IdentificationOptions())


def test_no_mode_is_found_in_noise():
    rng = np.random.default_rng(8)
    rig = bench.rig(5)
    blocks = []
    for i in range(5):
        samples = 0.03 * rng.standard_normal((6, 2048))
        samples[0] += bench.pulse(2048, 2000.0, 0.05, 4e-3, 80.0)
        blocks.append(bench.block(f"hit_{i}", "impact", i, 2000.0, samples, 5))
    with pytest.raises(IdentificationError, match=r"no (stable pole|mode)"):
        identify_impact(to_signals_of(blocks, rig), rig, IdentificationOptions())


def test_a_band_without_lines_is_rejected_by_its_numbers():
    with pytest.raises(DataError, match=r"50 to 51 Hz holds 1 of the block's lines"):
        identified(9, IdentificationOptions(band_hz=(50.0, 51.0)))


def test_two_modes_closer_than_a_line_are_two():
    rng = np.random.default_rng(10)
    system = bench.Modes(np.array([60.0, 60.6, 140.0]), np.array([0.004, 0.006, 0.005]), bench.modes(rng).phi)
    rig = bench.rig(5)
    blocks = bench.impact_blocks(system, rng, points=TWO_POINTS)
    model, _ = identify_impact(to_signals_of(blocks, rig), rig, IdentificationOptions(band_hz=(20.0, 400.0)))
    np.testing.assert_allclose(model.frequency_hz, system.frequency_hz, rtol=1e-4)
    np.testing.assert_allclose(model.damping_ratio, system.zeta, rtol=0.01)


def spoiled(change):
    rng = np.random.default_rng(11)
    rig = bench.rig(5)
    good = to_signals_of(bench.impact_blocks(bench.modes(rng), rng, hits=2), rig)
    return change(good), rig


def with_responses(signals, change):
    return [replace(s, responses=change(s.responses)) for s in signals]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda s: [], "no block"),
        (lambda s: with_responses(s, lambda y: np.where(np.arange(y.shape[1]) == 9, np.nan, y)), "NaN"),
        (lambda s: with_responses(s, lambda y: y * np.array([1, 0, 1, 1, 1])[:, None]), "a02: dead"),
        (lambda s: with_responses(s, lambda y: y.T), "do not belong"),
        (lambda s: [s[0], replace(s[1], rate_hz=1000.0)], "differ"),
        (lambda s: [replace(i, rate_hz=float("nan")) for i in s[:1]], "rate"),
        (lambda s: [replace(i, forces=0 * i.force) for i in s], "force is dead"),
    ],
    ids=["nothing", "nan", "dead", "transposed", "two rates", "no rate", "no force"],
)
def test_what_is_no_impact_test_is_rejected(change, says):
    with pytest.raises(DataError, match=says):
        identify_impact(*spoiled(change), IdentificationOptions(band_hz=(2.9, 400.0)))


@pytest.mark.thorough("identifies many recordings")
def test_what_no_linear_modes_explain_is_said():
    rng = np.random.default_rng(12)
    system, rig = bench.modes(rng), bench.rig(5)
    good = to_signals_of(bench.impact_blocks(system, rng, hits=3), rig)
    model, fit = identify_impact(good, rig, IdentificationOptions(band_hz=(2.9, 400.0)))
    assert model_error(fit, good) == pytest.approx(1, abs=0.1)
    assert not any("pre-trigger noise" in note for note in model.notes)
    distorted = with_responses(good, lambda y: y + 0.002 * y**2)
    model, fit = identify_impact(distorted, rig, IdentificationOptions(band_hz=(2.9, 400.0)))
    assert model_error(fit, distorted) > 1.1
    assert any("pre-trigger noise" in note for note in model.notes)


def test_each_hit_has_the_share_of_its_force_in_the_modes():
    """Equal at low frequencies, where impulses alone count; at the highest mode the shortest hit has most."""
    system = bench.modes(np.random.default_rng(7))
    blocks = []
    for width in (4e-3, 8e-3):
        samples = np.vstack([force := bench.pulse(2048, 2000.0, 0.05, width, 0.4 / width), np.zeros((2, 2048))])
        samples[1:] = bench.respond(system, force, 5, 2000.0)[:2]
        blocks.append(bench.block(f"impact_p05_{len(blocks)}", "impact", len(blocks), 2000.0, samples, 5))
    hits = to_signals_of(blocks, bench.rig(2))
    _, model, _ = identified(1)
    low = model.model_copy(update={"frequency_hz": np.array([2.0, 100.0, 180.0])})
    shares = with_hit_shares(low, [hits]).hit_shares
    assert shares.shape == (3, 1, 2)
    np.testing.assert_allclose(shares.sum(axis=2), 1)
    np.testing.assert_allclose(shares[0], 0.5, atol=0.01)
    # The spectrum of a cosine pulse: sin(x) / (x (1 - (x / pi)^2)), x = pi f width.
    x = np.pi * 180.0 * np.array([4e-3, 8e-3])
    power = (np.sin(x) / (x * (1 - (x / np.pi) ** 2))) ** 2
    np.testing.assert_allclose(shares[2, 0], power / power.sum(), atol=0.01)
