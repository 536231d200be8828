"""An acceleration that follows the force, as modes far above the band leave it, must not pass for damping."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.frf import Frf
from modallab.identification.frf_model import identify_frf
from modallab.identification.impact import identify_impact
from modallab.identification.model.modal_model import receptance_of_model
from modallab.identification.options import IdentificationOptions
from modallab.signals.hit import find_hit, windowed_force
from modallab.signals.signals import to_signals_of


def test_a_share_of_the_force_in_every_response_moves_no_damping():
    rng = np.random.default_rng(5)
    system, rig = bench.modes(rng), bench.rig(5)
    signals = to_signals_of(bench.impact_blocks(system, rng, points=(5,), hits=4), rig)
    share = np.linspace(-1e-2, 5e-2, 5)[:, None]
    mixed = [replace(s, responses=s.responses + share * windowed_force(s.force, find_hit(s.force))) for s in signals]
    plain = identify_impact(signals, rig, IdentificationOptions())[0]
    model = identify_impact(mixed, rig, IdentificationOptions())[0]
    np.testing.assert_allclose(model.damping_ratio, plain.damping_ratio, atol=0.5 * plain.damping_sigma.min())
    for found, sigma, true in zip(model.damping_ratio, model.damping_sigma, system.zeta, strict=True):
        assert abs(found - true) < 4 * sigma


ROOTS = {"clamped": [1.875104, 4.694091, 7.854757], "free": [4.730041, 7.853205, 10.995608]}
"""Of the beam's frequency equation; the next ones are (n - 1/2) pi, and (n + 1/2) pi."""


def _shape(ends, root, x):
    """Of a beam of length 1 and mass 1, with unit modal mass. Source: Blevins, Formulas for Natural Frequency, 8-1."""
    at, sign = root * x, -1.0 if ends == "clamped" else 1.0
    fall = np.exp(-root)
    # sigma = (cosh + s cos) / (sinh + s sin), divided by exp(root) where cosh and sinh would lose their digits.
    ratio = ((1 + fall**2) / 2 - sign * fall * np.cos(root)) / ((1 - fall**2) / 2 - sign * fall * np.sin(root))
    left = np.exp(-at) / 2 * (1 + ratio) + np.exp(at) / 2 * (1 - ratio)
    return left + sign * (np.cos(at) - ratio * np.sin(at))


def _beam(ends, lines):
    """Inertances (outputs, 1, lines) of a beam with 40 modes, the first at 10 Hz if clamped, at 63.6 Hz if free."""
    x, at = np.array([0.2, 0.5, 0.75, 1.0]), 3
    s, rigid = 2j * np.pi * lines, ends == "free"
    more = (np.arange(4, 41) + (0.5 if rigid else -0.5)) * np.pi
    # Translation and rotation about the middle.
    whole = (1 + 12 * (x - 0.5) * (x[at] - 0.5))[:, None] * np.ones(lines.size) * rigid
    for root in [*ROOTS[ends], *more]:
        w, phi = 20 * np.pi * (root / ROOTS["clamped"][0]) ** 2, _shape(ends, root, x)
        whole = whole + np.outer(phi * phi[at], s**2 / (s**2 + 0.01 * w * s + w**2))
    return Frf(lines, whole[:, None], "inertance", tuple("abcd"), (1, 2, 3, 4), (4,))


@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize("ends", ["clamped", "free"])
def test_a_beam_is_known_below_its_first_mode_free_or_clamped(ends, noise):
    """The band ends right below a mode, which no power series in s follows."""
    first, above = (10.0, 343.6) if ends == "clamped" else (63.64, 568.0)
    frf = _beam(ends, np.linspace(first / 10, 0.95 * above, 500))
    rng, size = np.random.default_rng(3), np.sqrt(np.mean(np.abs(frf.values) ** 2))
    error = noise * size / np.sqrt(2) * (rng.normal(size=frf.values.shape) + 1j * rng.normal(size=frf.values.shape))
    model, _ = identify_frf(replace(frf, values=frf.values + error), bench.rig(4), IdentificationOptions())
    low = frf.frequency_hz < 0.5 * first
    s = 2j * np.pi * frf.frequency_hz[low]
    off = receptance_of_model(model, frf.frequency_hz[low]) - frf.values[..., low] / s**2
    allowed = 0.01 * np.abs(frf.values[..., low] / s**2) + (1e-4 + 0.3 * noise) * size / np.abs(s) ** 2
    assert np.all(np.abs(off) < allowed)
