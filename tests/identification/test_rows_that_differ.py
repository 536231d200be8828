"""Rows of FRFs whose frequencies differ are one mode with that spread; close modes of rows that misfit stay two."""

import functools

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions

F = np.arange(40.0, 140.0, 0.25)


def identified(values: NDArray[np.complex128]) -> ModalModel:
    """The model of FRFs (outputs, lines) of one input, with noise of a thousandth."""
    rows, rng = len(values), np.random.default_rng(9)
    noisy = values + 1e-3 * np.abs(values).mean() * (rng.normal(size=(*values.shape, 2)) @ [1, 1j])
    names = tuple(f"a{k}" for k in range(rows))
    channels = [Channel(index=0, name="force", quantity="force", unit="N", point=1)]
    channels += [
        Channel(index=k + 1, name=n, quantity="acceleration", unit="m/s^2", point=k + 1) for k, n in enumerate(names)
    ]
    points = tuple(Point(id=k + 1, x_m=0.1 * k) for k in range(rows))
    rig = Rig(name="rows", model="unknown", points=points, channels=tuple(channels))
    frf = Frf(
        frequency_hz=F,
        values=noisy[:, None],
        quantity="inertance",
        outputs=names,
        output_points=tuple(range(1, rows + 1)),
        input_points=(1,),
    )
    return identify_frf(frf, rig, IdentificationOptions())[0]


def mode(hz: float, zeta: float) -> NDArray[np.complex128]:
    return np.asarray(-(F**2) / (hz**2 - F**2 + 2j * zeta * hz * F), np.complex128)


@functools.cache
def differing() -> tuple[ModalModel, NDArray[np.float64]]:
    rng = np.random.default_rng(1)
    shift, size = 0.3 * rng.normal(size=(2, 12)), rng.uniform(0.3, 1, (2, 12)) * rng.choice([-1, 1], (2, 12))
    modes = ((60.0, shift[0], size[0]), (120.0, shift[1], size[1]))
    rows = [[a[k] * mode(hz + d[k], 0.004) for hz, d, a in modes] for k in range(12)]
    return identified(np.sum(rows, axis=1)), shift


def test_rows_that_differ_by_more_than_a_peak_is_wide_are_one_mode_with_that_spread() -> None:
    model, shift = differing()
    assert model.n_modes == 2
    assert model.frequency_sigma_hz == pytest.approx(shift.std(axis=1) / np.sqrt(12), rel=0.7)
    assert np.all(np.abs(model.frequency_hz - [60, 120]) < 3 * model.frequency_sigma_hz)


def test_close_modes_of_rows_that_misfit_stay_two() -> None:
    rng = np.random.default_rng(2)
    given = ((60.0, 0.006), (60.5, 0.005), (90.0, 0.01))
    rows = np.einsum("om,ml->ol", rng.normal(size=(8, 3)), np.array([mode(*one) for one in given]))
    rows *= 1 + 0.05 * np.sin(2 * np.pi * F / 7 + rng.uniform(0, 6, (8, 1)))
    np.testing.assert_allclose(identified(rows).frequency_hz, [60, 60.5, 90], atol=0.05)
