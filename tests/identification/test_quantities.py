"""Noise belongs to what was measured: FRFs give the same modes in whatever quantity they are given."""

import numpy as np
import pytest

import modallab as ml

F = np.arange(1, 320, 0.5)
W = 2 * np.pi * F
F0, ZETA = (48.0, 132.0, 259.0), (0.003, 0.004, 0.002)
POWER = {"receptance": -2, "mobility": -1, "inertance": 0}


def measured(even_in: str, noise: float, seed: int) -> np.ndarray:
    """Inertances (6, 1, lines) of a free structure, their noise even in the quantity that was measured."""
    rng = np.random.default_rng(seed)
    shapes = rng.normal(size=(3, 6))
    shapes[:, 0] = np.abs(shapes[:, 0]) + 0.5
    values = np.full((6, 1, F.size), 1 / 3.0, complex)
    for f, zeta, shape in zip(F0, ZETA, shapes, strict=True):
        w0 = 2 * np.pi * f
        values[:, 0] += np.outer(shape * shape[0], -(W**2) / (w0**2 - W**2 + 2j * zeta * w0 * W))
    factor = (1j * W) ** POWER[even_in]
    size = noise * np.mean(np.abs(values * factor))
    return values + size / factor * (rng.normal(size=(*values.shape, 2)) @ [1, 1j]) / 2**0.5


AGAIN = pytest.mark.thorough("identifies each record in three quantities")


@pytest.mark.parametrize(
    ("even_in", "band"),
    [
        ("receptance", (20, 310)),
        pytest.param("inertance", (20, 310), marks=AGAIN),
        pytest.param("mobility", None, marks=AGAIN),
    ],
)
def test_the_same_modes_and_sigmas_come_from_every_quantity(even_in: str, band: tuple[float, float] | None) -> None:
    values = measured(even_in, 2e-3, seed=3)
    found = []
    for quantity, power in POWER.items():
        frf = ml.frf(F, values * (1j * W) ** power, inputs=[1], outputs=[1, 2, 3, 4, 5, 6], quantity=quantity)  # type: ignore[arg-type]
        found.append(ml.identify(frf, band=band, progress=False).modal_model)
    for model in found:
        np.testing.assert_allclose(model.frequency_hz, F0, rtol=1e-3)
        sigma = found[0].frequency_sigma_hz
        assert np.max(np.abs(model.frequency_hz - found[0].frequency_hz) / sigma) < 0.1
        np.testing.assert_allclose(model.frequency_sigma_hz, sigma, rtol=0.01)
        np.testing.assert_allclose(model.damping_sigma, found[0].damping_sigma, rtol=0.01)
        # From 1 Hz on, noise that is even in the receptance of a free structure hides the lines that would show it.
        assert band is None or any(f"even over the lines in the {even_in}" in note for note in model.notes)
        assert np.max(np.abs(model.frequency_hz - F0) / sigma) < 5
