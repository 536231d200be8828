"""Set-ups of responses alone: sensors that stay give each one's shapes their scale."""

import numpy as np
import pytest
from scipy.signal import lfilter

import modallab as ml
from modallab.cli import main
from modallab.core.errors import DataError, IdentificationError
from modallab.identification.response_only.known_poles import shapes_at
from modallab.identification.setups.join_responses import ResponseSetUp, join_responses
from modallab.pipelines.model_file import read_models

F, ZETA = np.array([5.0, 5.1, 20.0]), np.array([0.01, 0.012, 0.02])
SHAPES = np.random.default_rng(3).standard_normal((3, 9))


def setup(name: str, points: list[int], order: list[int], scale: complex, shift: float = 0.0) -> ResponseSetUp:
    """Of the modes in this order, the shapes times any number."""
    values = scale * SHAPES[order][:, points]
    n = len(order)
    return ResponseSetUp(
        name, tuple((p, "z") for p in points), F[order] * (1 + shift), np.full(n, 1e-3), ZETA[order], np.full(n, 1e-3),
        values.astype(complex), np.full(values.shape, 1e-3 * abs(scale)),
    )  # fmt: skip


def test_shapes_of_all_set_ups_are_one_whatever_their_scales() -> None:
    three = [setup("one", [0, 1, 2, 3], [0, 1, 2], 1.0), setup("two", [4, 5, 0, 1], [0, 1, 2], 3j),
             setup("three", [8, 0, 6, 7, 1], [0, 1, 2], -0.2 + 0.1j)]  # fmt: skip
    found = join_responses(three)
    assert sorted(p for p, _ in found.freedoms) == list(range(9))
    whole = SHAPES[:, [p for p, _ in found.freedoms]]
    largest = np.take_along_axis(whole, np.argmax(np.abs(whole), axis=1)[:, None], axis=1)
    np.testing.assert_allclose(found.shapes, whole / largest, atol=1e-9)


def test_close_modes_that_changed_places_are_known_by_their_shapes() -> None:
    """5.0 and 5.1 Hz drift past each other by less than what separates them from any other mode."""
    other = setup("two", [0, 1, 2, 3, 8], [0, 1, 2], 2.0)
    swapped = ResponseSetUp(
        "two", other.freedoms, np.array([5.08, 5.02, 20.0]), other.frequency_sigma_hz, ZETA, other.damping_sigma,
        other.shapes, other.shape_sigma,
    )  # fmt: skip
    found = join_responses([setup("one", [0, 1, 2, 3], [0, 1, 2], 1.0), swapped])
    np.testing.assert_array_equal(found.places, [[0, 1, 2], [0, 1, 2]])


def test_modes_that_a_set_up_has_not_found_are_left_out_and_frequencies_are_weighed() -> None:
    found = join_responses([setup("one", [0, 1, 2], [0, 1, 2], 1.0), setup("two", [0, 1, 5], [0, 2], 1.0, 1e-5)])
    np.testing.assert_array_equal(found.places, [[0, 2], [0, 1]])
    np.testing.assert_allclose(found.frequency[0], F[[0, 2]] * (1 + 0.5e-5), rtol=1e-9)


def test_a_mode_that_most_set_ups_have_is_joined_and_the_others_are_looked_at() -> None:
    """Two of three found it; the third set-up's records say what it does at the sensors that only stood there."""
    three = [setup("one", [0, 1, 2], [0, 1, 2], 1.0), setup("two", [0, 1, 3], [0, 2], 2.0),
             setup("three", [0, 1, 4], [0, 1, 2], 1j)]  # fmt: skip

    def look(n: int, frequency_hz: np.ndarray, damping_ratio: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert n == 1
        np.testing.assert_allclose(frequency_hz, F)
        np.testing.assert_allclose(damping_ratio, ZETA)
        return (3j * SHAPES[:, [0, 1, 3]]), np.full((3, 3), 1e-3)

    found = join_responses(three, look)
    np.testing.assert_array_equal(found.places, [[0, 1, 2], [0, -1, 1], [0, 1, 2]])
    whole = SHAPES[:, [p for p, _ in found.freedoms]]
    largest = np.take_along_axis(whole, np.argmax(np.abs(whole), axis=1)[:, None], axis=1)
    np.testing.assert_allclose(found.shapes, whole / largest, atol=1e-9)
    unknown = join_responses(three)
    assert np.isnan(unknown.shape_sigma[1, [p for p, _ in unknown.freedoms].index(3)])
    assert np.isfinite(unknown.shape_sigma[0]).all()


def test_a_mode_of_few_set_ups_is_left_out() -> None:
    three = [setup("one", [0, 1, 2], [0, 1, 2], 1.0), setup("two", [0, 1, 3], [0, 2], 2.0),
             setup("three", [0, 1, 4], [0, 2], 1j)]  # fmt: skip
    np.testing.assert_array_equal(join_responses(three).places, [[0, 2], [0, 1], [0, 1]])


def test_shapes_at_known_poles_are_those_of_the_records() -> None:
    y = records(5, [0, 1, 2, 3])
    values, sigma = shapes_at([y], RATE_HZ, (4.0, 25.0), np.array([7.0, 11.0]), np.array([0.02, 0.02]))
    for value, s, shape in zip(values, sigma, SHAPE, strict=True):
        factor = np.vdot(shape, value) / (shape @ shape)
        assert np.all(np.abs(value - factor * shape) < 5 * s)
        assert np.all(s < 0.1 * np.abs(factor))


def test_a_set_up_that_is_off_is_named() -> None:
    """Five set-ups; in one the structure is 3 % stiffer."""
    measured = [ml.responses(records(n, p), RATE_HZ * (1.02 if n == 3 else 1), points=[k + 1 for k in p])
                for n, p in enumerate(([0, 1, 2], [0, 1, 3], [0, 1, 2], [0, 1, 3], [0, 1, 2]))]  # fmt: skip
    found = ml.identify(measured, band=(4.0, 25.0), progress=False).modal_model
    assert any(note.startswith("set-up 4 is off") for note in found.notes)
    assert np.all(found.frequency_sigma_hz > 2e-3 * found.frequency_hz)


def test_what_nothing_joins_is_named() -> None:
    with pytest.raises(DataError, match="nothing joins set-up two"):
        join_responses([setup("one", [0, 1], [0, 1], 1.0), setup("two", [2, 3], [0, 1], 1.0)])
    with pytest.raises(IdentificationError, match="no mode of set-up two"):
        join_responses([setup("one", [0, 1], [2], 1.0), setup("two", [0, 3], [0], 1.0)])


RATE_HZ, SHAPE = 64.0, np.array([[1.0, 0.8, -0.6, 0.3], [0.4, -1.0, 0.7, 0.9]])


def records(seed: int, points: list[int]) -> np.ndarray:
    """Accelerations of two modes under other noise each time."""
    rng = np.random.default_rng(seed)
    y = np.zeros((len(points), int(150 * RATE_HZ)))
    for f, shape in zip((7.0, 11.0), SHAPE, strict=True):
        omega = 2 * np.pi * f
        z = np.exp(omega * (-0.02 + 1j * np.sqrt(1 - 0.02**2)) / RATE_HZ)
        one = lfilter([1.0], [1, -2 * z.real, abs(z) ** 2], rng.standard_normal(y.shape[1]))
        y += np.outer(shape[points], one)
    return y + 1e-3 * rng.standard_normal(y.shape)


def test_recordings_are_joined_in_python_and_by_the_command(tmp_path) -> None:
    measured = [
        ml.responses(records(n, p), RATE_HZ, points=[k + 1 for k in p]) for n, p in ((1, [0, 1, 2]), (2, [3, 0, 1]))
    ]
    model = ml.identify(measured, band=(4.0, 25.0), progress=False)
    found = model.modal_model
    assert found.output_points == (1, 2, 3, 4)
    np.testing.assert_allclose(found.frequency_hz, [7.0, 11.0], rtol=5e-3)
    np.testing.assert_allclose(found.operating_shapes, SHAPE / np.array([[1.0], [-1.0]]), atol=0.03)
    files = [str(one.save(tmp_path / f"set{n}.h5")) for n, one in enumerate(measured)]
    out, page = tmp_path / "m.json", tmp_path / "r.html"
    assert main(["identify", *files, "--band", "4", "25", "--json", str(out), "--report", str(page)]) == 0
    (read,) = read_models(out)
    np.testing.assert_allclose(read.operating_shapes, found.operating_shapes, atol=1e-9)
    assert "set0" in page.read_text(encoding="utf-8")
