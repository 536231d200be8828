"""A finite-element model taken at a rig's channels: the receptances of the whole model, in the band of a test."""

from dataclasses import replace

import numpy as np
import pytest
from beam_elements import beam
from scipy.sparse import csc_array

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.fem.fem_file import FemModel
from modallab.formats.fem.matrix_model import modes_of, symmetric
from modallab.gap.modal.narrower import in_band
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.frfs import receptances_of_model
from modallab.updating.elements import frf_of_elements, mesh_shapes, model_of_elements

EI, PER_M, LENGTH, BAND = 70.0, 0.8, 0.9, (3.0, 250.0)
K, M, FREEDOMS, NODES = beam(EI, PER_M, LENGTH, 12)
PLACES = {int(n): (float(x), float(y), float(z)) for n, x, y, z in NODES}


def rig(direction: str = "+z", first: int = 1) -> Rig:
    points = tuple(Point(id=first + n, x_m=x) for n, x in enumerate((0.3, 0.6, 0.9)))
    channels = (
        Channel(index=0, name="force", quantity="force", unit="N", direction="-z"),
        *(
            Channel(index=n + 1, name=f"a{n}", quantity="acceleration", unit="m/s^2", point=p.id, direction=direction)
            for n, p in enumerate(points)
        ),
    )
    return Rig(name="beam", model="unknown", drive_direction="-z", points=points, channels=channels)


def sparse(matrix: np.ndarray) -> csc_array:
    return symmetric(matrix, "beam's", "beam")


def free() -> FemModel:
    """The same beam held by nothing but a spring too soft to be seen."""
    k, m, freedoms, nodes = beam(EI, PER_M, LENGTH, 12)
    first = np.zeros((26, 26)), np.zeros((26, 26))
    h = LENGTH / 12
    own = EI / h**3 * np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]])
    mass = PER_M * h / 420 * np.array([[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]])
    for whole, part, rows in zip(first, (k, m), (own, mass), strict=True):
        whole[2:, 2:] = part
        whole[:2, :4] = rows
        whole[2:4, :2] = rows[:, 2:].T
    places = {0: (0.0, 0.0, 0.0), **PLACES}
    at = np.concatenate([[(0, 3), (0, 5)], freedoms])
    assert len(nodes) == 12
    return FemModel(modes_of(*map(sparse, first), at, places, "free"), {})


CLAMPED = FemModel(modes_of(sparse(K), sparse(M), FREEDOMS, PLACES, "clamped"), {})


def receptance(k: np.ndarray, m: np.ndarray, omega: complex) -> np.ndarray:
    """(3, 3) at the nodes 4, 8 and 12, by the matrices themselves."""
    rows = [2 * (node - 1) for node in (4, 8, 12)]
    return np.linalg.inv(k - omega**2 * m)[np.ix_(rows, rows)]


def test_in_the_band_it_answers_as_the_whole_model_does() -> None:
    found = model_of_elements(CLAMPED, rig(), BAND, (1, 2, 3))
    assert found.frequency_hz[-1] < 1.1 * BAND[1] < CLAMPED.modes.frequency_hz[found.n_modes]
    assert -2 not in found.residual_powers
    for hz in (4.0, 70.0, 160.0, 245.0):
        exact = receptance(K, M, 2 * np.pi * hz)
        made = receptances_of_model(found, np.array([2j * np.pi * hz]))[0]
        # Without damping but for what it is believed to be, which is nothing away from the resonances.
        np.testing.assert_allclose(made.real, exact, atol=0.01 * np.abs(exact).max())


def test_its_frfs_are_those_of_the_matrices_on_the_lines_of_the_test() -> None:
    hz, shift = np.linspace(*BAND, 40), 2.0
    like = Frf(hz, np.zeros((3, 1, 40), complex), "mobility", ("x", "y", "z"), (1, 2, 3), (3,), damping_shift=shift)
    undamped = replace(CLAMPED, modes=replace(CLAMPED.modes, damping_ratio=np.zeros(24)))
    found = frf_of_elements(undamped, rig(), like, (3,))
    s = shift + 2j * np.pi * hz
    exact = np.array([receptance(K, M, p / 1j)[:, 2:] * p for p in s])
    np.testing.assert_allclose(np.moveaxis(found.values, -1, 0), exact, rtol=1e-6)
    assert found.outputs == ("a0", "a1", "a2")


def test_what_moves_as_a_whole_is_an_inertance() -> None:
    found = model_of_elements(free(), rig(), BAND, (3,))
    # Two motions of a free beam: x from its middle over the radius of gyration squared.
    off = np.array([0.3, 0.6, 0.9]) - LENGTH / 2
    expected = (1 + off * off[2] / (LENGTH**2 / 12)) / (PER_M * LENGTH)
    np.testing.assert_allclose(found.residuals[found.residual_powers.index(-2)][:, 0], expected, atol=1e-4)


def test_channels_along_the_drive_read_along_it_and_others_as_they_stand() -> None:
    along = model_of_elements(CLAMPED, rig("+z"), BAND, (3,))
    assert np.all(along.modal_constants[:, 2, 0].real > 0)
    with pytest.raises(DataError, match="no mode up to 250 Hz that the sensors see"):
        model_of_elements(CLAMPED, rig("+y"), BAND, (3,))


def test_points_are_nodes_by_place_by_name_or_by_number() -> None:
    expected = model_of_elements(CLAMPED, rig(), BAND, (3,)).modal_constants
    elsewhere = rig(first=101)
    np.testing.assert_array_equal(model_of_elements(CLAMPED, elsewhere, BAND, (103,)).modal_constants, expected)
    numbered = FemModel(modes_of(sparse(K), sparse(M), FREEDOMS, {}, "numbers"), {1: 4, 2: 8, 3: 12})
    np.testing.assert_array_equal(model_of_elements(numbered, rig(), BAND, (3,)).modal_constants, expected)
    with pytest.raises(DataError, match="has no node 101 for point 101"):
        model_of_elements(FemModel(numbered.modes, {}), elsewhere, BAND, (103,))


def test_it_holds_the_valleys_as_an_identification_does() -> None:
    """Of FRFs without noise: what terms do not hold of the modes above the band would be a gap."""
    hz = np.arange(BAND[0], BAND[1], 0.1)
    squares = (2 * np.pi * CLAMPED.modes.frequency_hz) ** 2
    at = np.array([CLAMPED.modes.at[node][:, 2] for node in (4, 8, 12)]).T
    s = 2j * np.pi * hz
    zeta = 0.01
    kernel = s**2 / (s**2 + 2 * zeta * np.sqrt(squares)[:, None] * s + squares[:, None])
    measured = Frf(
        hz, np.einsum("ro,ri,rl->oil", at, at, kernel), "inertance", ("a0", "a1", "a2"), (1, 2, 3), (1, 2, 3)
    )
    bench, _ = identify_frf(measured, rig(), IdentificationOptions())
    computed = model_of_elements(
        replace(CLAMPED, modes=replace(CLAMPED.modes, damping_ratio=np.full(24, zeta))), rig(), BAND, (1, 2, 3)
    )
    valley = 2j * np.pi * np.array([4.0, 30.0, 90.0, 240.0])
    np.testing.assert_allclose(receptances_of_model(computed, valley), receptances_of_model(bench, valley), rtol=2e-3)


def test_in_a_narrower_band_a_mode_above_it_is_what_its_terms_hold() -> None:
    found, band = model_of_elements(CLAMPED, rig(), BAND, (1, 2, 3)), (BAND[0], 180.0)
    narrower = in_band(found, band)
    assert narrower.n_modes == found.n_modes - 1
    s = 2j * np.pi * np.linspace(4.0, 175.0, 50)
    off, size = (
        receptances_of_model(narrower, s) - receptances_of_model(found, s),
        np.abs(receptances_of_model(found, s)),
    )
    assert np.max(np.abs(off) / size.max(axis=(1, 2), keepdims=True)) < 5e-3


def test_the_mesh_moves_as_the_channels_read() -> None:
    """Along a drive that points down it is turned, as modal constants are."""
    how = (CLAMPED, rig(), BAND, (3,))
    made, found = model_of_elements(*how), mesh_shapes(*how)
    assert found is not None
    tip = int(np.argmax(found.places_m[:, 0]))
    here = np.abs(found.motion["z"][tip]) ** 2
    np.testing.assert_allclose(here, made.modal_constants[:, 2, 0].real, rtol=1e-9)
    down = np.array([CLAMPED.modes.at[node][: made.n_modes, 2] for node in CLAMPED.modes.at])
    np.testing.assert_allclose(found.motion["z"], -down)


def test_a_model_whose_owner_names_nodes_has_no_mesh_in_the_rigs_coordinates() -> None:
    named = FemModel(CLAMPED.modes, {1: 4, 2: 8, 3: 12})
    assert mesh_shapes(named, rig(), BAND, (3,)) is None
