import numpy as np
import pytest

from modallab.core.errors import DataError, IdentificationError
from modallab.core.frf import Frf
from modallab.identification.estimate import estimate_poles
from modallab.identification.estimators.plscf import plscf
from modallab.identification.start.stabilisation import stable_poles


def frf(frequency, zeta, phi, inputs, lines, quantity="receptance", shift=0.0, seed=None, noise=0.01):
    f = np.asarray(lines, float)
    s = shift + 2j * np.pi * f
    w = 2 * np.pi * np.asarray(frequency)
    values = np.einsum(
        "mo,mi,mk->oik", phi, phi[:, inputs], 1 / (s**2 + 2 * np.outer(np.asarray(zeta) * w, s) + (w**2)[:, None])
    )
    values = values * s ** {"receptance": 0, "mobility": 1, "inertance": 2}[quantity]
    if seed is not None:
        rng = np.random.default_rng(seed)
        size = noise * np.sqrt(np.mean(np.abs(values) ** 2))
        values = values + size / np.sqrt(2) * (
            rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
        )
    return Frf(
        f,
        values,
        quantity,
        tuple(f"o{i}" for i in range(values.shape[0])),
        (None,) * values.shape[0],
        (None,) * len(inputs),
        damping_shift=shift,
    )


FREQUENCY, ZETA = [12.0, 40.0, 41.0, 90.0], [0.01, 0.005, 0.008, 0.004]
PHI = np.random.default_rng(0).standard_normal((4, 6))
LINES = np.arange(2, 120, 0.25)


@pytest.mark.parametrize("quantity", ["receptance", "mobility", "inertance"])
def test_exact_frfs_give_exact_poles(quantity):
    found = stable_poles(plscf(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES, quantity), 30))
    poles = np.array([p.pole for p in found])
    near = [poles[np.argmin(np.abs(np.abs(poles) - 2 * np.pi * f))] for f in FREQUENCY]
    np.testing.assert_allclose(np.abs(near), 2 * np.pi * np.array(FREQUENCY), rtol=1e-5)
    np.testing.assert_allclose(-np.real(near) / np.abs(near), ZETA, rtol=1e-3)


def test_the_damping_shift_is_taken_off_again():
    found = stable_poles(plscf(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES, shift=4.0), 30))
    poles = np.array([p.pole for p in found])
    near = [poles[np.argmin(np.abs(np.abs(poles) - 2 * np.pi * f))] for f in FREQUENCY]
    np.testing.assert_allclose(-np.real(near) / np.abs(near), ZETA, rtol=1e-2)


def test_noisy_frfs_give_each_mode_once():
    found = stable_poles(plscf(frf(FREQUENCY, ZETA, PHI, [0, 3], LINES, seed=1), 30))
    assert [round(abs(p.pole) / (2 * np.pi)) for p in found] == [12, 40, 41, 90]


def test_uneven_ascending_lines_are_welcome():
    lines = np.sort(np.random.default_rng(2).uniform(5, 110, 300))
    found = stable_poles(plscf(frf(FREQUENCY, ZETA, PHI, [0, 3], lines), 20))
    assert {12, 40, 41, 90} <= {round(abs(p.pole) / (2 * np.pi)) for p in found}


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda v: np.where(np.arange(v.shape[-1]) == 7, np.nan, v), "NaN"),
        (lambda v: np.abs(v) + 0j, "phase"),
        (lambda v: 0 * v, "zero"),
    ],
    ids=["nan", "magnitude only", "zeros"],
)
def test_what_is_no_frf_is_rejected(spoil, says):
    good = frf(FREQUENCY, ZETA, PHI, [0], LINES)
    bad = Frf(good.frequency_hz, spoil(good.values), "receptance", good.outputs, good.output_points, good.input_points)
    with pytest.raises(DataError, match=says):
        plscf(bad, 10)


def test_descending_frequencies_are_rejected():
    good = frf(FREQUENCY, ZETA, PHI, [0], LINES)
    bad = Frf(
        good.frequency_hz[::-1],
        good.values[..., ::-1],
        "receptance",
        good.outputs,
        good.output_points,
        good.input_points,
    )
    with pytest.raises(DataError, match="descends"):
        plscf(bad, 10)


def test_too_few_lines_for_the_order_are_rejected():
    with pytest.raises(IdentificationError, match="40 lines of 6 outputs and 1 inputs cannot carry order 60"):
        plscf(frf(FREQUENCY, ZETA, PHI, [0], LINES[:40]), 60)


@pytest.mark.parametrize(
    "n_inputs", [1, 3, pytest.param(10, marks=pytest.mark.thorough("an estimator with ten inputs"))]
)
def test_a_mode_far_below_the_highest_line_is_found_from_any_number_of_inputs(n_inputs):
    """A beam's modes, the lowest at a hundredth of the band: every input sees them all."""
    order = np.arange(1, 8)
    frequency = 4.75 * np.array([1.0, 6.27, 17.55, 34.4, 56.8, 84.9, 118.6])
    phi = np.sin(np.outer((2 * order - 1) * np.pi / 2, np.linspace(0.1, 1, 10)))
    lines = np.arange(3, 800, 0.9765625)
    measured = frf(frequency, np.full(7, 0.006), phi, range(n_inputs), lines, "mobility", 5.6, 1, 1e-3)
    found = [abs(p) / (2 * np.pi) for p in estimate_poles(measured, "plscf").poles]
    assert max(min(abs(f / true - 1) for f in found) for true in frequency) < 1e-3


def test_lines_are_counted_with_the_outputs_that_share_them():
    """Six damped modes in 32 lines: one output cannot carry them, nine can."""
    frequency = [63.6, 81.2, 93.0, 101.2, 114.8, 129.7]
    zeta = [0.028, 0.037, 0.05, 0.046, 0.04, 0.04]
    phi = np.random.default_rng(3).standard_normal((6, 9))
    measured = frf(frequency, zeta, phi, [4], np.arange(5.0, 160.0, 5.0), "inertance")
    found = [abs(p) / (2 * np.pi) for p in estimate_poles(measured, "plscf").poles]
    assert max(min(abs(f / true - 1) for f in found) for true in frequency) < 1e-3


def test_a_narrow_band_far_from_zero_keeps_its_modes():
    one = np.random.default_rng(0).standard_normal((2, 3))
    narrow = frf([4050.0, 4150.0], [0.002, 0.003], one, [0], np.linspace(3950, 4250, 301), seed=1)
    found = [abs(p.pole) / (2 * np.pi) for p in stable_poles(plscf(narrow, 120))]
    for true in (4050.0, 4150.0):
        assert min(abs(f - true) for f in found) < 1.0
