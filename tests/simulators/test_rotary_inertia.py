"""Rotary inertia against Rayleigh's beam in closed form, and beams that have few modes."""

import json

import numpy as np
import pytest
from scipy.optimize import brentq

from modallab.bench.protocol import Burst
from modallab.core.errors import ConfigurationError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.assembled import RotaryModes
from modallab_simulators.cantilever.attached import SUMMED, AttachedModes, Attachment
from modallab_simulators.cantilever.basis import ModalBasis, TruncatedBasis
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.chain import Chain
from modallab_simulators.cantilever.effect_part import ChainChanges
from modallab_simulators.cantilever.excitation import BurstOutput
from modallab_simulators.cantilever.modes import Modes

BEAM = CantileverBeam(0.8, 60.0, 1.6, np.inf)


def rayleigh(omega: float, inertia: float) -> float:
    """Determinant of the cantilever's end conditions, of W'''' + r^2 k W'' - k W = 0 over a unit length."""
    k = BEAM.mass_kg_m * omega**2 * BEAM.length_m**4 / BEAM.bending_stiffness_n_m2
    r2 = inertia / BEAM.mass_kg_m / BEAM.length_m**2
    root = np.sqrt((r2 * k / 2) ** 2 + k)
    a, b = np.sqrt(root + r2 * k / 2), np.sqrt(root - r2 * k / 2)
    # W = A (cos a x - cosh b x) + B (sin a x - (a / b) sinh b x): no moment, and no shear, at the free end.
    moment = np.array([-(a**2) * np.cos(a) - b**2 * np.cosh(b), -(a**2) * np.sin(a) - a * b * np.sinh(b)])
    bend = np.array([a**3 * np.sin(a) - b**3 * np.sinh(b), -(a**3) * np.cos(a) - a * b**2 * np.cosh(b)])
    turn = np.array([-a * np.sin(a) - b * np.sinh(b), a * np.cos(a) - a * np.cosh(b)])
    shear = bend + r2 * k * turn
    return float((moment[0] * shear[1] - moment[1] * shear[0]) / np.cosh(b) ** 2)


@pytest.mark.parametrize("slenderness", [0.002, 0.01, 0.03])
def test_frequencies_are_those_of_rayleighs_beam(slenderness: float):
    inertia = BEAM.mass_kg_m * (slenderness * BEAM.length_m) ** 2
    found, plain = RotaryModes(BEAM, inertia).omega(8), BEAM.omega(8)
    assert np.all(found < plain)
    for omega in found:
        exact = brentq(rayleigh, omega * 0.9995, omega * 1.0005, args=(inertia,), xtol=1e-9)
        assert omega == pytest.approx(exact, rel=1e-6)


def test_modes_of_a_beam_with_rotary_inertia_add_up_to_its_statics():
    modes = RotaryModes(BEAM, BEAM.mass_kg_m * 0.006**2)
    x = np.array([0.2, 0.5, 0.8])
    added = modes.shapes(x, 150) @ (modes.shapes(np.array([0.3]), 150)[0] / modes.omega(150) ** 2)
    np.testing.assert_allclose(added, BEAM.flexibility(x, 0.3), rtol=1e-6)


def test_heavier_slices_leave_what_modes_above_the_last_answer_statically():
    # At ten points of a stiff beam that is 1e-9 of the whole answer: an error of 1e-8 in mode 1 hides it.
    beam = CantileverBeam(1.195, 545.0, 3.06, 393.0)
    x = np.linspace(0.1195, 1.195, 10)
    whole = np.stack([beam.flexibility(x, at) for at in x], axis=1)

    def above(modes: Modes) -> float:
        shapes = modes.shapes(x, SUMMED) / modes.omega(SUMMED)
        return float(np.linalg.eigvalsh(whole - shapes @ shapes.T)[0])

    found = [above(RotaryModes(beam, inertia, ((3, 0.0027),))) for inertia in np.linspace(2e-5, 4e-5, 6)]
    np.testing.assert_allclose(found, above(beam), rtol=1e-5)


def test_what_would_let_the_structure_fly_apart_is_rejected():
    modes = AttachedModes(BEAM, [Attachment(0.6, stiffness=-1e6)])
    with pytest.raises(ConfigurationError, match=r"at 0\.6 m give the beam an unstable mode"):
        modes.omega(3)


def test_what_is_no_number_is_never_counted_as_zero(rig: Rig):
    chain = Chain.of(rig, "impact", ChainChanges())
    luck = chain.draw(np.random.default_rng(1), np.random.default_rng(2), 4)
    seen = np.zeros((len(rig.channels), 4))
    seen[3, 2] = np.nan
    with pytest.raises(ConfigurationError, match="row 3 of the simulated bench"):
        chain.convert(seen, luck, np.arange(4) / 1000)


def test_a_mass_on_a_beam_with_rotary_inertia_lowers_what_rayleighs_quotient_says():
    modes = RotaryModes(BEAM, BEAM.mass_kg_m * 0.006**2)
    small = 1e-6
    heavier = AttachedModes(modes, [Attachment(0.6, mass=small)]).omega(5)
    slope = -0.5 * modes.shapes(np.array([0.6]), 5)[0] ** 2
    np.testing.assert_allclose((heavier / modes.omega(5) - 1) / small, slope, rtol=1e-3, atol=1e-3)


def test_a_beam_of_few_modes_answers_with_these_only():
    basis = TruncatedBasis(ModalBasis(BEAM, BEAM.omega(6), np.full(6, 0.005)), 9)
    x = np.array([0.1, 0.45, 0.8])
    phi, load, omega = BEAM.shapes(x, 9), BEAM.shapes(np.array([0.3]), 9)[0], BEAM.omega(9)
    expected = phi[:, 6:] @ (load[6:] / omega[6:] ** 2)
    np.testing.assert_allclose(basis.remainder(x, 0.3), expected, rtol=1e-6, atol=1e-15)
    shift = phi[:, 6:] @ (-BEAM.participation(9)[6:] / omega[6:] ** 2)
    np.testing.assert_allclose(basis.base_remainder(x), shift, rtol=1e-6, atol=1e-15)


def test_a_straight_ramp_rises_and_falls_evenly():
    times = np.linspace(0, 4, 4001)
    burst = Burst(10.0, 2.0, 1.0, 2.0)
    volts = BurstOutput(burst, 0.0, 0.0, straight=True).volts(times)
    envelope = np.minimum(1.0, np.minimum(times, 4.0 - times))
    np.testing.assert_allclose(volts, 2.0 * envelope * np.sin(20 * np.pi * times), atol=1e-9)


def test_the_bench_has_rotary_inertia(running, rig: Rig):
    truth = running("seed=1&k_root=inf")
    facts = truth.info.facts
    assert rig.beam is not None
    b, h, rho, e = (
        rig.beam.width_m,
        *(float(facts[k]) for k in ("thickness_m", "density_kg_m3", "youngs_modulus_pa")),
    )
    beam = CantileverBeam(rig.beam.length_m, e * b * h**3 / 12, rho * b * h, np.inf)
    found = np.array(json.loads(facts["frequency_hz"])) * 2 * np.pi
    count = len(found)
    r2 = h**2 / 12
    # To first order a mode falls by half of what its turning adds to its kinetic energy.
    at, weights = np.polynomial.legendre.leggauss(200)
    slopes = beam.shapes(rig.beam.length_m * (at + 1) / 2, count, 1)
    turning = weights @ slopes**2 * rig.beam.length_m / 2 * beam.mass_kg_m * r2
    np.testing.assert_allclose(1 - found / beam.omega(count), turning / 2, rtol=0.02)
