"""Measured FRFs off the frequency axis, against the closed form of the modes they were made of."""

from dataclasses import replace

import numpy as np
import pytest
from other_structures import as_believed, as_built, benches, frf
from phased_line import OMEGA, PSI, model, rig
from structures import Material

from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.core.model import ModalModel
from modallab.gap.modal.compared import compared
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.gap.modal.free import Free
from modallab.gap.modal.matching import Side
from modallab.gap.modal.off_axis import MeasuredFrfs
from modallab.gap.model.tolerances import with_tolerances
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.frfs import receptances_of_model

HZ = np.arange(10.0, 95.0, 0.05)


def frfs(quantity: FrfQuantity = "inertance", noise: float = 0.0, seed: int = 0, hz: np.ndarray = HZ) -> Frf:
    s = np.asarray(2j * np.pi * hz)
    values = np.moveaxis(receptances_of_model(model(), s) * (s ** DERIVATIVES[quantity])[:, None, None], 0, -1)
    drawn = np.random.default_rng(seed).standard_normal((2, *values.shape)) * noise / np.sqrt(2)
    known = np.full(values.shape, noise**2)
    return Frf(hz, values + drawn[0] + 1j * drawn[1], quantity, ("a1", "a2", "a3"), (1, 2, 3), (1,), variance=known)


def at(frf: Frf, s: np.ndarray) -> np.ndarray:
    measured = MeasuredFrfs.of(frf, model())
    assert measured is not None
    return measured.means_at(s).receptances


@pytest.mark.parametrize("quantity", ["receptance", "mobility", "inertance"])
def test_lines_tell_the_frf_off_the_axis(quantity: FrfQuantity) -> None:
    s = 2 * np.pi * np.array([21.4, 35.0, 50.0, 68.3]) * (0.01 + 1j)
    expected = receptances_of_model(model(), s)
    off = np.linalg.norm(at(frfs(quantity), s) - expected, axis=(1, 2)) / np.linalg.norm(expected, axis=(1, 2))
    assert np.all(off < 0.02), off


def test_lines_farther_apart_than_a_resonance_is_wide_tell_it_too() -> None:
    s = 2 * np.pi * np.array([21.4, 50.0, 68.3]) * (0.03 + 1j)
    coarse = frfs(hz=np.arange(10.0, 95.0, 0.7))
    np.testing.assert_allclose(at(coarse, s), receptances_of_model(model(), s), rtol=1e-6)


def test_each_point_s_own_resonance_is_met_where_a_roving_sensor_moved_it() -> None:
    """Widths of a tenth of the lines' distance: a common model would stand beside each resonance by its width."""
    s = 2 * np.pi * np.array([21.4, 50.0, 68.3]) * (0.03 + 1j)
    coarse, narrow = np.arange(10.0, 95.0, 0.25), model().model_copy(update={"damping_ratio": np.full(3, 5e-4)})
    whole, expected = frfs(hz=coarse), np.zeros((3, 3, 1), np.complex128)
    for o, moved in enumerate((-4e-4, 0.0, 6e-4)):
        own = narrow.model_copy(update={"frequency_hz": narrow.frequency_hz * (1 + moved)})
        lines = np.asarray(2j * np.pi * coarse)
        whole.values[o] = np.moveaxis(receptances_of_model(own, lines) * (lines**2)[:, None, None], 0, -1)[o]
        expected[:, o] = receptances_of_model(own, s)[:, o]
    measured = MeasuredFrfs.of(whole, narrow)
    assert measured is not None
    np.testing.assert_allclose(measured.means_at(s).receptances, expected, rtol=1e-4)


def leaked(frf: Frf, noise: float, seed: int) -> Frf:
    """Lines of random records under a Hann window: means over their neighbours, which no model fits."""
    hz = np.arange(10.0, 95.0, 0.5)
    apart = (hz[:, None] - frf.frequency_hz) / 0.5
    seen = np.abs(np.sinc(apart) + (np.sinc(apart - 1) + np.sinc(apart + 1)) / 2) ** 2
    values = frf.values @ (seen / seen.sum(axis=1)[:, None]).T
    drawn = np.random.default_rng(seed).standard_normal((2, *values.shape)) * noise / np.sqrt(2)
    known = np.full(values.shape, noise**2)
    return replace(frf, frequency_hz=hz, values=values + drawn[0] + 1j * drawn[1], variance=known)


def test_what_leaking_lines_leave_open_is_stated() -> None:
    s = 2 * np.pi * np.array([21.4, 50.0, 68.3]) * (0.03 + 1j)
    lines = leaked(frfs(), 1e-4, seed=0)
    other = model().model_copy(update={"frequency_hz": model().frequency_hz * np.array([1.001, 0.999, 1.001])})
    sides = [MeasuredFrfs.of(lines, m) for m in (model(), other)]
    one, two = (side.means_at(s) for side in sides if side is not None)
    stated = np.sqrt(np.einsum("lloi->loi", one.noise() + two.noise()).real)
    assert np.all(np.abs(one.receptances - two.receptances) < 3 * stated)


@pytest.mark.thorough("draws noise many times")
def test_the_covariance_is_that_of_the_noise() -> None:
    s = 2 * np.pi * np.array([35.0, 50.0, 50.3]) * (0.01 + 1j)
    measured = MeasuredFrfs.of(frfs(noise=1e-3), model())
    assert measured is not None
    drawn = np.array([at(frfs(noise=1e-3, seed=n), s) for n in range(100)])
    off = drawn - drawn.mean(axis=0)
    found = np.einsum("nloi,nmoi->lm", off, np.conj(off)) / (100 * 3)
    expected = measured.means_at(s).noise().mean(axis=(2, 3))
    np.testing.assert_allclose(found, expected, atol=0.3 * np.abs(expected).max())


@pytest.mark.thorough("two comparisons")
def test_what_a_model_misses_is_missed_in_neither() -> None:
    """Of three modes the models hold two: with the FRFs a gain is exact all the same, and nothing is no gap."""
    whole = model()
    values_at_modes = ("frequency_hz", "damping_ratio", "frequency_sigma_hz", "damping_sigma")
    part = {n: getattr(whole, n)[:2] for n in (*values_at_modes, "modal_constants", "modal_constant_sigma")}
    two = whole.model_copy(update=part)
    gain = frfs(noise=1e-4, seed=2)
    gain.values[1] *= 1.12
    (effect,) = diagnose_by_model(two, two, rig(), frfs=(frfs(noise=1e-4), gain)).effects
    assert (effect.effect, effect.place.model_dump()) == ("gain_error", {"channel": "a2"})
    assert effect.parameters["gain"] == pytest.approx(1.12, rel=1e-3)
    none = diagnose_by_model(two, two, rig(), frfs=(frfs(noise=1e-4), frfs(noise=1e-4, seed=3)))
    assert none.verdict == "no_gap"
    assert none.nothing is not None
    assert none.unknown is not None
    assert none.nothing + none.unknown + sum(c.probability for c in none.candidates) == pytest.approx(1.0)


def test_modal_constants_that_were_not_found_end_no_comparison() -> None:
    lost = np.full(model().modal_constants.shape, 1e60)
    unknown = model().model_copy(update={"modal_constant_sigma": lost})
    assert diagnose_by_model(model(), unknown, rig()).verdict == "no_gap"


@pytest.mark.thorough("identifies a plate twice")
def test_a_sound_plate_measured_a_second_time_has_no_gap() -> None:
    """Its sensors, hits, stiffness and mass are each off within their tolerances, alike in all FRFs of a place."""
    bench, rng = replace(benches()["plate"], hits=(24, 21, 14, 11, 3, 18)), np.random.default_rng([3, 3])
    before = frf(bench, bench.make(Material()), rng, as_believed(bench))
    of, built = as_built(bench, rng)
    after = frf(bench, of, rng, built)
    models = [identify_frf(one, bench.rig, IdentificationOptions())[0] for one in (before, after)]
    assert diagnose_by_model(*models, bench.rig, frfs=(before, after)).verdict == "no_gap"


@pytest.mark.thorough("a comparison")
def test_a_filter_in_the_force_s_channel_has_no_name_and_a_delay_has_one() -> None:
    """To first order a filter is a delay."""
    s = np.asarray(2j * np.pi * HZ)
    verdicts = []
    for by in (1 + s / (2 * np.pi * 150.0), np.exp(-s * 1e-3)):
        there = frfs(noise=1e-5, seed=2)
        there.values[:] *= by
        found = diagnose_by_model(model(), model(), rig(), frfs=(frfs(noise=1e-5), there))
        verdicts.append((found.verdict, [e.effect for e in found.effects]))
    assert verdicts == [("unknown", []), ("known", ["trigger_delay"])]


@pytest.mark.thorough("diagnoses a structure once more")
def test_what_a_sensor_reads_of_the_force_is_no_term_outside_the_band() -> None:
    """An identification calls it a body's mass, which the reference has not. Its FRFs say that it was not there."""
    there, read = frfs(noise=1e-5, seed=2), np.zeros((1, 3, 1))
    read[0, 1] = 0.5 * np.median(np.abs(there.values[1]))
    there.values[1] += read[0, 1, 0]
    with_term = model().model_copy(update={"residuals": read, "residual_powers": (-2,)})
    found = diagnose_by_model(model(), with_term, rig(), frfs=(frfs(noise=1e-5), there))
    assert (found.verdict, found.effects) == ("unknown", [])


def roved(softer: float = 1.0) -> Frf:
    """One sensor and a hammer at three points, at the third of which little moves; struck there when it was softer."""
    omega, s = OMEGA * np.array([1.0, softer])[:, None], np.asarray(2j * np.pi * HZ)
    each = [receptances_of_model(soft_place(w), s) * (s**2)[:, None, None] for w in omega]
    each[0][:, :, 2] = each[1][:, :, 2]
    values = np.moveaxis(each[0], 0, -1)
    return Frf(HZ, values, "inertance", ("a1",), (1,), (1, 2, 3), variance=np.full(values.shape, 1e-10))


def soft_place(omega: np.ndarray = OMEGA) -> ModalModel:
    local = {"residuals": np.array([[[2e-6, 0.0, 0.0]]]), "residual_powers": (0,)}
    return model(PSI * [1.0, 1.0, 0.05], omega, sensors=(1,), driven=(1, 2, 3)).model_copy(update=local)


def test_hits_that_were_aslant_at_one_of_several_points_have_no_name() -> None:
    """Where little moves, a spring at a soft place would take a share of it."""
    aslant = roved().values * np.array([1.0, 1.0, 0.55])[:, None]
    found = diagnose_by_model(soft_place(), soft_place(), rig(), frfs=(roved(), replace(roved(), values=aslant)))
    assert (found.verdict, found.effects) == ("unknown", [])
    assert "Most likely what has no name is this: hits at 3." in found.notes


def test_a_point_that_was_struck_when_the_structure_was_warm_gives_no_other_cause_a_name() -> None:
    found = diagnose_by_model(soft_place(), soft_place(), rig(), frfs=(roved(), roved(softer=0.985)))
    assert (found.verdict, found.effects) == ("unknown", [])
    assert "Most likely what has no name is this: hits at 3." in found.notes


@pytest.mark.parametrize("faster", [0.985, 1.012])
def test_a_structure_that_is_stiffer_as_a_whole_takes_along_what_no_model_has_of_it(faster: float) -> None:
    """H(s / b) / b^2 is the FRF of b^2 times the stiffness at the same damping ratios, whatever H is."""
    s = np.asarray(2j * np.pi * HZ)

    def measured(by: float) -> Frf:
        at = s / by
        unknown = 2e-6 / (at**2 + 2 * 0.01 * at * 2 * np.pi * 58 + (2 * np.pi * 58) ** 2)
        whole = (receptances_of_model(model(), at) + unknown[:, None, None]) / by**2
        return replace(frfs(), values=np.moveaxis(whole * (s**2)[:, None, None], 0, -1))

    sides = [Side(model(), MeasuredFrfs.of(measured(by), model())) for by in (1.0, faster)]
    free = Free(compared(sides[0], sides[1], with_tolerances(rig())))
    u = np.zeros(free.size)
    u[0] = np.log(faster**2) / free.deviations[0]
    assert free.share(0 * u) > 0.05
    assert free.share(u) < 0.005


@pytest.mark.thorough("identifies and diagnoses")
def test_noise_three_times_as_large_as_stated_is_no_gap() -> None:
    """Of what lines are off by the order is known, the size is inferred."""
    clean = frfs(hz=np.arange(10.0, 95.0, 0.25))
    size = 0.1 * float(np.sqrt(np.mean(np.abs(clean.values) ** 2)))
    stated = np.full(clean.values.shape, (size / 3) ** 2)
    drawn = (np.random.default_rng(seed).standard_normal((2, *stated.shape)) * size / np.sqrt(2) for seed in (1, 2))
    sides = tuple(replace(clean, values=clean.values + one + 1j * other, variance=stated) for one, other in drawn)
    models = [identify_frf(of, rig(), IdentificationOptions())[0] for of in sides]
    assert diagnose_by_model(models[0], models[1], rig(), frfs=sides).verdict == "no_gap"
