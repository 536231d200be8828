"""No public function answers what cannot be with a number, or with its libraries' errors: it says what was wrong."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest
from test_plscf import frf

from modallab.core.errors import DataError, ModallabError
from modallab.frf.estimate import combine_spectra, convert_frf, impact_frf
from modallab.frf.local_polynomial import local_polynomial_frf
from modallab.identification.estimate import estimate_poles
from modallab.identification.estimators.circle import circle_fit
from modallab.identification.estimators.era import era
from modallab.identification.estimators.peak import identify_peaks
from modallab.identification.estimators.plscf import plscf
from modallab.identification.frf_model import identify_frf
from modallab.identification.impact import identify_impact
from modallab.identification.likelihood.orthonormal import qr_decomposition
from modallab.identification.model.modal_mass import unit_mass_shapes
from modallab.identification.model.modal_model import receptance_of_model
from modallab.identification.model.repeated_poles import split_repeated
from modallab.identification.options import IdentificationOptions
from modallab.identification.selection import assumptions, criteria
from modallab.identification.selection.diagram import stabilisation_diagram
from modallab.identification.sine import identify_sine
from modallab.identification.start import bands, half_power
from modallab.identification.start.bands import split_bands
from modallab.signals.signals import to_signals_of
from modallab.verification.verify import frac, synthesised_frf, verify_frf, verify_impact, verify_sine

PHI = np.random.default_rng(0).standard_normal((2, 5))
GOOD = replace(
    frf([12.0, 31.0], [0.01, 0.01], PHI, [0, 2], np.arange(1, 161) * 0.25, "mobility"),
    output_points=(1, 2, 3, 4, 5),
    input_points=(1, 3),
)
ORDERS = plscf(GOOD, 6)
RIG = bench.rig(5)


def with_value(value):
    values = GOOD.values.copy()
    values[1, 0, 7] = value
    return replace(GOOD, values=values)


BAD_FRFS = {
    "NaN": with_value(np.nan),
    "infinite": with_value(np.inf),
    "empty": replace(GOOD, frequency_hz=GOOD.frequency_hz[:0], values=GOOD.values[..., :0]),
    "one line": replace(GOOD, frequency_hz=GOOD.frequency_hz[:1], values=GOOD.values[..., :1]),
    "unequal lengths": replace(GOOD, frequency_hz=GOOD.frequency_hz[:-3]),
    "descending": replace(GOOD, frequency_hz=GOOD.frequency_hz[::-1]),
    "negative frequencies": replace(GOOD, frequency_hz=GOOD.frequency_hz - 100),
    "NaN frequency": replace(GOOD, frequency_hz=np.where(GOOD.frequency_hz == 10, np.nan, GOOD.frequency_hz)),
    "no phase": replace(GOOD, values=np.abs(GOOD.values)),
    "two axes": replace(GOOD, values=GOOD.values[:, 0]),
    "no outputs": replace(GOOD, values=GOOD.values[:0], outputs=(), output_points=()),
    "no inputs": replace(GOOD, values=GOOD.values[:, :0], input_points=()),
}
OF_FRF = {
    "plscf": lambda it: plscf(it, 4),
    "era": lambda it: era(it, 4),
    **{f"estimate {m}": lambda it, m=m: estimate_poles(it, m) for m in ("plscf", "era", "circle", "peak")},
    "identify_frf": lambda it: identify_frf(it, RIG, IdentificationOptions()),
    "identify_peaks": lambda it: identify_peaks(it, None),
    "mmif": bands.mmif,
    "cmif": bands.cmif,
    "split_bands": split_bands,
    "diagram": lambda it: stabilisation_diagram(it, ORDERS),
    "convert": lambda it: convert_frf(it, "receptance"),
    "reciprocity": assumptions.reciprocity,
    "driving_point": assumptions.driving_point,
    "linearity": lambda it: assumptions.linearity(it, it),
    "time_invariance": lambda it: assumptions.time_invariance(it, it),
    "summed_amplitude": half_power.summed_amplitude,
    "verify_frf": lambda it: verify_frf(identify_peaks(GOOD, None), it),
}


@pytest.mark.parametrize("call", OF_FRF)
def test_the_good_frf_is_taken_by_all(call):
    OF_FRF[call](GOOD)


@pytest.mark.parametrize("bad", BAD_FRFS)
@pytest.mark.parametrize("call", OF_FRF)
def test_an_frf_that_cannot_be_is_rejected(call, bad):
    with pytest.raises(ModallabError):
        OF_FRF[call](BAD_FRFS[bad])


BAD_BANDS = [(np.nan, 30.0), (5.0, np.inf), (30.0, 5.0), (10.0, 10.0), (-50.0, -5.0), (12.1, 12.2), (900.0, 950.0)]


@pytest.fixture(scope="module")
def hits():
    rng = np.random.default_rng(4)
    return to_signals_of(bench.impact_blocks(bench.modes(rng, 2), rng, hits=1), RIG)


@pytest.fixture(scope="module")
def sines():
    rng = np.random.default_rng(4)
    return to_signals_of(bench.sine_blocks(bench.modes(rng, 2), rng, np.array([5.0, 6.0, 7.0]), settle_s=1.0), RIG)


@pytest.mark.parametrize("band", BAD_BANDS, ids=str)
@pytest.mark.parametrize("kind", ["frf", "impact", "sine"])
def test_a_band_without_lines_is_rejected(kind, band, hits, sines):
    identify = {
        "frf": lambda: identify_frf(GOOD, RIG, IdentificationOptions(band_hz=band)),
        "impact": lambda: identify_impact(hits, RIG, IdentificationOptions(band_hz=band)),
        "sine": lambda: identify_sine(sines, RIG, IdentificationOptions(band_hz=band)),
    }
    with pytest.raises(ModallabError):
        identify[kind]()


@pytest.mark.parametrize("identify", [identify_impact, identify_sine])
def test_records_that_cannot_be_are_rejected(identify, hits, sines):
    good = hits if identify is identify_impact else sines
    no_motion = replace(good[0], responses=0 * good[0].responses)
    one_dead = replace(good[0], responses=np.vstack([good[0].responses[:-1], 0 * good[0].responses[-1:]]))
    no_force = replace(good[0], forces=np.zeros_like(good[0].force))
    for bad in ([], [no_motion], [one_dead], [no_force]):
        with pytest.raises(ModallabError):
            identify(bad, RIG, IdentificationOptions())


def _verifying(hits, kind):
    """The records of a test, and what compares a model of them with others."""
    if kind == "impact":
        model, fit = identify_impact(hits, RIG, IdentificationOptions())
        return hits, lambda it, of=fit: verify_impact(model, of, [it], RIG)
    rng = np.random.default_rng(4)
    steps = bench.sine_blocks(bench.modes(rng, 2), rng, np.arange(3.0, 30.0, 0.9), settle_s=1.0)
    signals = to_signals_of(steps, RIG)
    model, fit = identify_sine(signals, RIG, IdentificationOptions())
    return signals, lambda it, of=fit: verify_sine(model, of, it, RIG)


@pytest.mark.parametrize("kind", ["impact", pytest.param("sine", marks=pytest.mark.thorough("identifies once more"))])
def test_a_model_is_compared_with_no_other_records_than_its_own(kind, hits):
    good, verify = _verifying(hits, kind)
    assert verify(good).frac.min() > 0.9
    first, *rest = good
    bad = (
        [],
        rest,
        [*good, first],
        [replace(first, responses=0 * first.responses), *rest],
        [replace(first, responses=first.responses[:-1], outputs=first.outputs[:-1]), *rest],
        [replace(s, forces=s.force[:-8], responses=s.responses[:, :-8]) for s in good],
        [replace(s, rate_hz=2 * s.rate_hz) for s in good],
    )
    for records in bad:
        with pytest.raises(DataError):
            verify(records)
    of_frfs = identify_frf(GOOD, RIG, IdentificationOptions())[1]
    with pytest.raises(DataError):
        verify(good, of_frfs)


@pytest.mark.parametrize("order", [0, -3, 10_000])
@pytest.mark.parametrize("method", ["plscf", "era"])
def test_orders_that_the_lines_cannot_carry_are_rejected(method, order):
    with pytest.raises(ModallabError):
        identify_frf(GOOD, RIG, IdentificationOptions(method=method, max_order=order))


@pytest.mark.parametrize("bad_hz", [np.nan, -4.0, 0.0, np.inf, 500.0])
@pytest.mark.parametrize("how", ["pick_hz", "drop_hz"])
def test_modes_by_hand_where_none_can_be_are_rejected(how, bad_hz):
    with pytest.raises(ModallabError):
        identify_frf(GOOD, RIG, IdentificationOptions(**{how: (bad_hz,)}))


SHAPES = PHI + 0j
BAD_SHAPES = {
    "NaN": SHAPES * np.nan,
    "infinite": SHAPES + np.inf,
    "empty": SHAPES[:0],
    "no points": SHAPES[:, :0],
    "one axis": SHAPES[0],
    "zero": SHAPES * 0,
}
OF_SHAPES = {
    "mac": lambda it: criteria.mac(it, it),
    "auto_mac": criteria.auto_mac,
    "comac": lambda it: criteria.comac(it, it),
    "mpc": criteria.mpc,
    "mpd": criteria.mpd,
}


@pytest.mark.parametrize("bad", BAD_SHAPES)
@pytest.mark.parametrize("call", OF_SHAPES)
def test_shapes_that_cannot_be_are_rejected(call, bad):
    with pytest.raises(ModallabError):
        OF_SHAPES[call](BAD_SHAPES[bad])


LINES = np.arange(1, 33) * 1.0
AMPLITUDE = 1 / np.abs(LINES - 12.2)
CURVES = {
    "NaN": (LINES, AMPLITUDE * np.nan),
    "unequal": (LINES[:-2], AMPLITUDE),
    "descending": (LINES[::-1], AMPLITUDE),
    "empty": (LINES[:0], AMPLITUDE[:0]),
    "negative": (LINES, -AMPLITUDE),
    "two axes": (LINES, AMPLITUDE[None]),
}


@pytest.mark.parametrize("bad", CURVES)
def test_curves_without_peaks_to_read_are_rejected(bad):
    f, a = CURVES[bad]
    for call in (half_power.find_peaks, half_power.half_power, half_power.half_power_near):
        with pytest.raises(ModallabError):
            call(f, a) if call is half_power.find_peaks else call(f, a, 11)


@pytest.mark.parametrize("bad", [name for name in CURVES if name != "negative"])
def test_curves_that_make_no_circle_are_rejected(bad):
    f, a = CURVES[bad]
    with pytest.raises(ModallabError):
        circle_fit(f, a * 1j)


def test_a_line_or_a_frequency_that_is_not_there_is_rejected():
    with pytest.raises(ModallabError):
        half_power.half_power(LINES, AMPLITUDE, 99)
    for bad_hz in (np.nan, np.inf):
        with pytest.raises(ModallabError):
            half_power.half_power_near(LINES, AMPLITUDE, bad_hz)


SPECTRA = np.ones((3, 40), complex), np.ones((3, 2, 40), complex)
BAD_SPECTRA = {
    "NaN": (SPECTRA[0] * np.nan, SPECTRA[1]),
    "unequal": (SPECTRA[0][:, :-1], SPECTRA[1]),
    "no blocks": (SPECTRA[0][:0], SPECTRA[1][:0]),
    "no force": (SPECTRA[0] * 0, SPECTRA[1]),
    "no lines": (SPECTRA[0][:, :0], SPECTRA[1][..., :0]),
}


@pytest.mark.parametrize("bad", BAD_SPECTRA)
def test_spectra_that_make_no_frf_are_rejected(bad):
    for call in (combine_spectra, local_polynomial_frf):
        with pytest.raises(ModallabError):
            call(*BAD_SPECTRA[bad])
    with pytest.raises(ModallabError):
        combine_spectra(*BAD_SPECTRA[bad], "Hv")


def test_curves_that_cannot_be_compared_are_rejected():
    good = np.ones((2, 5), complex)
    for one, other in (
        (good, good[:, :4]),
        (good[:, :0], good[:, :0]),
        (good * np.nan, good),
        (good[0, 0], good[0, 0]),
    ):
        with pytest.raises(ModallabError):
            frac(np.asarray(one), np.asarray(other))


def test_a_model_has_no_response_at_frequencies_that_are_none():
    model = identify_peaks(GOOD, None)
    for lines in (np.array([np.nan]), np.array([[1.0, 2.0]]), np.array([np.inf])):
        for call in (lambda it: receptance_of_model(model, it), lambda it: synthesised_frf(model, it, "mobility")):
            with pytest.raises(ModallabError):
                call(lines)


def test_constants_that_cannot_be_are_rejected():
    good = np.ones((1, 3, 2), complex)
    points = (1, 2, 3), (1, 2)
    for constants, sigma in (
        (good * np.nan, np.ones((1, 3, 2))),
        (good, np.ones((1, 3, 1))),
        (good[0], np.ones((3, 2))),
    ):
        with pytest.raises(ModallabError):
            unit_mass_shapes(constants, sigma, *points)
        with pytest.raises(ModallabError):
            split_repeated(constants, sigma, *points)
    with pytest.raises(ModallabError):
        unit_mass_shapes(good, np.ones((1, 3, 2)), (1, 2), (1, 2))


def test_a_matrix_without_columns_to_distinguish_is_rejected():
    for bad in (np.full((9, 2), np.nan), np.ones((2, 9)), np.ones(4), np.ones((0, 0))):
        with pytest.raises(ModallabError):
            qr_decomposition(bad)


def test_hits_without_a_rate_or_a_band_have_no_frf(hits):
    with pytest.raises(ModallabError):
        impact_frf([], RIG, (3.0, 100.0))
    with pytest.raises(ModallabError):
        impact_frf([hits], RIG, (3.0, 100.0), damping_shift=np.nan)
    few = RIG.model_copy(update={"channels": RIG.channels[:-1]})
    with pytest.raises(DataError, match="are not the rig's"):
        impact_frf([hits], few, (3.0, 100.0))
