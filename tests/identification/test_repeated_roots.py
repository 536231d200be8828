"""Modes at one frequency: a single force sees one shape there, two forces see both."""

from dataclasses import replace

import numpy as np

from modallab.core.frf import Frf
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.frf_model import identify_frf
from modallab.identification.model.repeated_poles import split_repeated
from modallab.identification.options import IdentificationOptions

POINTS = 6
LINES = np.arange(1, 481) * 0.25
DRIVEN = (0, 3)


def _rig():
    force = Channel(index=0, name="force", quantity="force", unit="N")
    channels = [Channel(index=i, name=f"v{i}", quantity="velocity", unit="m/s", point=i) for i in range(1, POINTS + 1)]
    points = tuple(Point(id=i, x_m=0.1 * i) for i in range(1, POINTS + 1))
    return Rig(name="plate", model="unknown", points=points, channels=(force, *channels))


def _frf(frequency, zeta, lines=LINES, noise=0.005):
    rng = np.random.default_rng(3)
    phi = rng.standard_normal((len(frequency), POINTS))
    s, w = 2j * np.pi * lines, 2 * np.pi * np.array(frequency)[:, None]
    receptance = 1 / (s**2 + 2 * np.array(zeta)[:, None] * w * s + w**2)
    values = np.einsum("mo,mi,mk->oik", phi, phi[:, DRIVEN], receptance) * s
    size = noise * np.sqrt(np.mean(np.abs(values) ** 2, axis=-1, keepdims=True))
    values = values + size * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    names = tuple(f"v{i}" for i in range(1, POINTS + 1))
    return Frf(lines, values, "mobility", names, tuple(range(1, POINTS + 1)), tuple(d + 1 for d in DRIVEN))


def test_two_modes_at_one_frequency_are_both_found_from_two_forces():
    truth_hz, zeta = [30.0, 60.0, 60.0, 95.0], [0.006, 0.004, 0.009, 0.004]
    model, _ = identify_frf(_frf(truth_hz, zeta), _rig(), IdentificationOptions())
    assert model.n_modes == 4
    assert np.all(np.abs(model.frequency_hz - truth_hz) < 5 * model.frequency_sigma_hz)
    np.testing.assert_allclose(np.sort(model.damping_ratio), sorted(zeta), rtol=0.02)


def test_equal_frequency_and_damping_are_two_modes_whose_shapes_span_the_true_plane():
    rng = np.random.default_rng(3)
    truth_hz, zeta = [30.0, 60.0, 60.0, 95.0], [0.006, 0.005, 0.005, 0.004]
    phi = rng.standard_normal((4, POINTS))
    model, _ = identify_frf(_frf(truth_hz, zeta, noise=0.002), _rig(), IdentificationOptions())
    assert model.n_modes == 4
    np.testing.assert_allclose(model.frequency_hz, truth_hz, rtol=1e-4)
    assert model.frequency_hz[1] == model.frequency_hz[2]
    assert any("2 modes share the pole at 60 Hz" in note for note in model.notes)
    plane, _ = np.linalg.qr(phi[1:3].T)
    for shape in model.shapes[1:3]:
        inside = plane @ (plane.T @ shape)
        assert np.linalg.norm(inside) > 0.999 * np.linalg.norm(shape)
    assert np.linalg.cond(model.shapes[1:3].T) < 10
    # At unit modal mass the sum over both is the same in any basis of the plane.
    product = model.shapes[1:3].T @ model.shapes[1:3]
    np.testing.assert_allclose(product, phi[1:3].T @ phi[1:3], atol=0.03 * np.abs(phi).max() ** 2)


def test_one_force_sees_one_mode_where_two_share_a_pole():
    both = _frf([30.0, 60.0, 60.0, 95.0], [0.006, 0.005, 0.005, 0.004])
    one = replace(both, values=both.values[:, :1], input_points=both.input_points[:1])
    model, _ = identify_frf(one, _rig(), IdentificationOptions())
    assert model.n_modes == 3


def test_noise_is_no_second_rank():
    rng = np.random.default_rng(0)
    for _ in range(50):
        a = np.outer(rng.standard_normal(8), rng.standard_normal(3)) + 0j
        noise = rng.standard_normal((8, 3)) + 1j * rng.standard_normal((8, 3))
        a += 0.5 * noise / np.sqrt(2)
        assert split_repeated(a[None], np.full((1, 8, 3), 0.5), range(8), range(3)).pole.tolist() == [0]


def test_without_sensors_at_the_forces_the_parts_still_add_up():
    rng = np.random.default_rng(0)
    a = (rng.standard_normal((8, 2)) @ rng.standard_normal((2, 3))).astype(complex)
    found = split_repeated(a[None], np.full((1, 8, 3), 1e-6), (None,) * 8, range(3))
    assert found.pole.tolist() == [0, 0]
    np.testing.assert_allclose(found.constants.sum(axis=0), a, atol=1e-12)
    assert all(np.linalg.matrix_rank(part, tol=1e-9) == 1 for part in found.constants)


def test_misfit_as_large_in_each_further_direction_is_no_mode():
    rng = np.random.default_rng(8)
    outputs, inputs = np.linalg.qr(rng.standard_normal((3, 3)))[0], np.linalg.qr(rng.standard_normal((40, 3)))[0]
    points = (range(3), range(3, 43))
    for sizes, modes in (((1.0, 0.6, 0.5), 1), ((1.0, 0.6, 0.05), 2)):
        a = (outputs * sizes) @ inputs.T + 0j
        found = split_repeated(a[None], np.full((1, 3, 40), 1e-3), *points, apparent=np.array([0.27]))
        assert found.pole.size == modes


def test_a_band_split_in_two_gives_what_the_whole_gives():
    truth_hz = [12.0, 25.0, 41.0, 70.0, 88.0, 104.0]
    frf = _frf(truth_hz, [0.005] * 6)
    whole, _ = identify_frf(frf, _rig(), IdentificationOptions())
    low, _ = identify_frf(frf, _rig(), IdentificationOptions(band_hz=(5.0, 55.0)))
    high, _ = identify_frf(frf, _rig(), IdentificationOptions(band_hz=(55.0, 120.0)))
    frequency = np.concatenate([low.frequency_hz, high.frequency_hz])
    damping = np.concatenate([low.damping_ratio, high.damping_ratio])
    sigma = np.concatenate([low.damping_sigma, high.damping_sigma])
    np.testing.assert_allclose(frequency, whole.frequency_hz, rtol=1e-4)
    assert np.all(np.abs(damping - 0.005) < 4 * sigma)
    assert np.all(np.abs(damping - whole.damping_ratio) < 4 * np.hypot(sigma, whole.damping_sigma))


def _of_two(second_phase, first_phase=0.0):
    rng = np.random.default_rng(8)
    one, other = rng.standard_normal((2, 40)), rng.standard_normal((2, 3))
    a = np.exp(1j * first_phase) * np.outer(one[0], other[0])
    a = a + 0.4 * np.exp(1j * second_phase) * np.outer(one[1], other[1])
    noise = 1e-3 * (rng.standard_normal(a.shape) + 1j * rng.standard_normal(a.shape))
    return (a + noise)[None], np.full((1, *a.shape), 1.4e-3)


def test_a_rank_in_quadrature_to_the_first_is_no_mode_but_scatter():
    points = tuple(range(100, 140)), (1, 2, 3)
    assert split_repeated(*_of_two(0.1), *points).pole.size == 2
    assert split_repeated(*_of_two(np.pi - 0.1), *points).pole.size == 2
    assert split_repeated(*_of_two(0.7), *points).pole.size == 1
    # Against the first, as a sensor's lag turns both.
    assert split_repeated(*_of_two(1.0, 1.0), *points).pole.size == 2


def test_a_rank_that_one_point_carries_is_what_that_point_misreads():
    points = tuple(range(100, 140)), (1, 2, 3)
    a, sigma = _of_two(0.0)
    u, values, vh = np.linalg.svd(a[0], full_matrices=False)
    alone = np.zeros(40)
    alone[[7, 8]] = 1.0, 0.4
    misread = a - values[1] * np.outer(u[:, 1], vh[1]) + values[1] * np.outer(alone, vh[1])
    assert split_repeated(a, sigma, *points).pole.size == 2
    assert split_repeated(misread, sigma, *points).pole.size == 1
    # The same where the many points are those that were struck.
    assert split_repeated(np.swapaxes(misread, 1, 2), np.swapaxes(sigma, 1, 2), *points[::-1]).pole.size == 1


def _alone(frequency, zeta, constants):
    """A single FRF of these modes, with a thousandth of noise."""
    rng = np.random.default_rng(5)
    s, w = 2j * np.pi * LINES, 2 * np.pi * np.array(frequency)[:, None]
    receptance = 1 / (s**2 + 2 * np.array(zeta)[:, None] * w * s + w**2)
    values = (np.array(constants) @ receptance * s)[None, None]
    size = 1e-3 * np.sqrt(np.mean(np.abs(values) ** 2))
    values = values + size * (rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape))
    return Frf(LINES, values, "mobility", ("v1",), (1,), (4,))


def test_a_single_frf_does_not_tell_a_second_pole_on_the_flank_of_a_first():
    """Half a half-width away and more, a resonance that is not quite that of a mode looks the same."""
    rig = _rig().model_copy(update={"channels": _rig().channels[:2]})
    beside = _alone([30.0, 60.0, 60.5], [0.006, 0.01, 0.01], [1.0, 1.0, 0.15])
    model, _ = identify_frf(beside, rig, IdentificationOptions())
    assert model.n_modes == 2
    apart = _alone([30.0, 60.0, 62.5], [0.006, 0.01, 0.01], [1.0, 1.0, 0.3])
    model, _ = identify_frf(apart, rig, IdentificationOptions())
    np.testing.assert_allclose(model.frequency_hz, [30.0, 60.0, 62.5], rtol=1e-3)
