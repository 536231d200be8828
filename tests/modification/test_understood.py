"""What makes a response and where modes move, against closed forms and direct sums."""

from pathlib import Path

import numpy as np
import pytest
from chain import BARE
from PIL import Image
from scipy.linalg import expm

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Point
from modallab.formats.frf_file import rig_without_places
from modallab.modification.deflection import mode_deflection, motion_in_space, operating_deflection
from modallab.modification.known import KnownStructure
from modallab.modification.nodes import places_of_modes
from modallab.modification.participation import ModalParticipation, modal_participation
from modallab.reporting.behaviour_table import correlation_rows, node_rows
from modallab.reporting.figures.deflection import FRAMES, Drawing
from modallab.updating.correlation import correlate_models

FREEDOMS = tuple((p, "z") for p in (1, 2, 3, 4))


def parts(band: tuple[float, float] | None = None, after: tuple[float, float] | None = None) -> ModalParticipation:
    known = KnownStructure(BARE.model())
    return modal_participation(known, 1, 3, "velocity", band, after)


def test_shares_over_a_band_are_the_projections_of_the_modes_on_the_whole() -> None:
    low, high = 3.0, 40.0
    found = parts((low, high))
    s = 2j * np.pi * np.linspace(low, high, 200_001)
    model = BARE.model()
    omega, zeta = 2 * np.pi * model.frequency_hz, model.damping_ratio
    each = s[:, None] * model.modal_constants[:, 2, 0] / (s[:, None] ** 2 + 2 * zeta * omega * s[:, None] + omega**2)
    whole = BARE.receptance(s)[:, 2, 0] * s
    expected = np.sum(np.real(whole.conj()[:, None] * each), axis=0) / np.sum(np.abs(whole) ** 2)
    np.testing.assert_allclose(found.share, expected, atol=2e-3)
    assert found.share.sum() + found.outside == pytest.approx(1)


def test_at_a_natural_frequency_its_mode_makes_the_response() -> None:
    hz = float(BARE.model().frequency_hz[1])
    assert parts((hz, hz)).share[1] == pytest.approx(1, abs=0.05)


def test_the_deviation_of_averaged_frfs_is_that_of_repeated_tests() -> None:
    """Five hits with noise on the response, measured again and again."""
    rng, hits, times = np.random.default_rng(3), 5, 4000
    answers = 0.3 + 0.4j + 0.1 * rng.standard_normal((times, hits, 2)) @ [1, 1j]
    mean = answers.mean(axis=1)
    coherence = np.abs(mean) ** 2 / np.mean(np.abs(answers) ** 2, axis=1)
    lines = np.arange(1.0, times + 1)
    frf = Frf(lines, mean[None, None], "mobility", ("a",), (1,), (1,), coherence[None, None], averages=(hits,))
    found = [operating_deflection(frf, ((1, "z"),), hz, 1).sigma[0] for hz in lines[:200]]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(np.std(mean), rel=0.1)
    once = Frf(lines, mean[None, None], "mobility", ("a",), (1,), (1,), np.ones((1, 1, times)), averages=(1,))
    assert np.isnan(operating_deflection(once, ((1, "z"),), 3.0, 1).sigma[0])


def test_shares_at_an_instant_after_a_hit_are_those_of_the_free_motion() -> None:
    t, n, model = 0.037, 4, BARE.model()
    omega, zeta = 2 * np.pi * model.frequency_hz, model.damping_ratio
    damped = omega * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * omega * t)
    each = model.modal_constants[:, 2, 0].real * decay
    each = each * (np.cos(damped * t) - zeta * omega / damped * np.sin(damped * t))
    inverse = np.linalg.inv(BARE.mass)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ BARE.stiffness, -inverse @ BARE.damping]])
    moved = (expm(a * t) @ np.concatenate([np.zeros(n), inverse[:, 0]]))[n + 2]
    np.testing.assert_allclose(parts(after=(t, t)).share, each / moved, rtol=1e-6)
    # A time is the mean of its instants, weighted by the squares.
    assert parts(after=(0, 0.5)).share.sum() == pytest.approx(1)


def test_a_band_beyond_the_model_and_a_time_before_the_hit_are_rejected() -> None:
    with pytest.raises(DataError, match="is not within that of the model"):
        parts((3, 1e6))
    with pytest.raises(DataError, match="is no time after a hit"):
        parts(after=(-1, 1))


def string(modes: int = 4, points: int = 9) -> tuple[ModalModel, KnownStructure]:
    """A string from 0 to 10 m with sensors at 1 to 9 m: nodes of mode r are at 10 k / r."""
    x = np.arange(1.0, points + 1)
    phi = np.array([np.sin(np.pi * r * x / (points + 1)) for r in range(1, modes + 1)])
    constants = (phi[:, :, None] * phi[:, None, :1]).astype(np.complex128)
    none, zero = np.full(modes, np.nan), np.zeros(modes)
    model = BARE.model().model_copy(
        update={
            "frequency_hz": 10.0 * np.arange(1, modes + 1),
            "band_hz": (1.0, 10.0 * modes + 5),
            "damping_ratio": np.full(modes, 0.01),
            "frequency_sigma_hz": zero,
            "damping_sigma": zero,
            "outputs": tuple(f"a{p}" for p in range(1, points + 1)),
            "output_points": tuple(range(1, points + 1)),
            "modal_constants": constants,
            "modal_constant_sigma": np.zeros(constants.shape),
            "residuals": np.zeros((0, points, 1)),
            "half_power": none,
            "half_power_floor": none,
        }
    )
    return model, KnownStructure(model, rig_without_places(model.outputs, range(1, points + 1), [1], "inertance"))


def test_a_sensor_on_a_plate_is_off_in_both_directions() -> None:
    """One mode rises across and one along: a sensor off its point reads either otherwise."""
    x, y = (v.ravel() for v in np.meshgrid(*[np.linspace(0, 0.4, 4)] * 2, indexing="ij"))
    phi = np.stack([1 + 3 * x, 1 + 3 * y])
    model, known = string(2, x.size)
    model = model.model_copy(update={"modal_constants": (phi[:, :, None] * phi[:, None, :1]).astype(np.complex128)})
    rig = known.stated_rig
    points = tuple(Point(id=p.id, x_m=float(a), y_m=float(b)) for p, a, b in zip(rig.points, x, y, strict=True))
    tolerance = rig.tolerance.model_copy(update={"sensitivity": 0.0, "position_m": 1e-3})
    moved = KnownStructure(model, rig.model_copy(update={"points": points, "tolerance": tolerance})).samples.psi
    # Of either point 3e-3 over its own shape, that of the driving point included.
    expected = 3e-3 * np.sqrt(1 / phi[:, 1:] ** 2 + 1 / phi[:, :1] ** 2)
    off = np.std(np.abs(moved[:, :, 1:] / moved[:, :, :1]), axis=0) / (phi[:, 1:] / phi[:, :1])
    np.testing.assert_allclose(np.mean(off / expected, axis=1), 1, atol=0.4)


def test_nodes_between_points_lie_where_the_shape_is_zero() -> None:
    model, known = string()
    found = places_of_modes(known.structure, known.samples, model, known.rig)
    for r in range(1, 5):
        places = np.array([c.place_m[0] for c in found.crossings if c.mode == r - 1])
        sigma = np.array([c.sigma_m for c in found.crossings if c.mode == r - 1])
        truth = 10 * np.arange(1, r) / r
        assert len(places) == len(truth)
        assert np.all(np.abs(places - truth) < 2 * sigma + 1e-9)
        assert np.all(sigma < 0.5)
    assert found.nodes[1] == ((5, "z"),)
    assert found.antinode[0] == (5, "z")


def test_the_best_point_is_at_no_mode_s_node_and_the_words_name_the_points_that_miss_one() -> None:
    model, known = string()
    found = places_of_modes(known.structure, known.samples, model, known.rig)
    point, least = found.best_freedom
    assert least == pytest.approx(max(found.motion.min(axis=0)))
    assert f"Hit or mount a sensor at point {point[0]}" in node_rows(found).caption
    assert "point 5 misses mode 2" in node_rows(found).caption


def test_without_places_no_node_between_points_is_named() -> None:
    known = KnownStructure(BARE.model())
    rows = node_rows(places_of_modes(known.structure, known.samples, known.model, None))
    assert rows.headings[-1] == "points near a node"


def measured(inputs: tuple[int, ...], outputs: tuple[int, ...]) -> Frf:
    hz = np.arange(1.0, 50.0, 0.5)
    s = 2j * np.pi * hz
    values = (BARE.receptance(s) * s[:, None, None])[:, [p - 1 for p in outputs]][:, :, [p - 1 for p in inputs]]
    names = tuple(f"a{p}" for p in outputs)
    return Frf(hz, np.ascontiguousarray(np.moveaxis(values, 0, -1)), "mobility", names, outputs, inputs)


def test_a_deflection_shape_is_the_column_of_the_driven_point_at_the_nearest_line() -> None:
    frf = measured((1,), (1, 2, 3, 4))
    found = operating_deflection(frf, FREEDOMS, 12.3, 1)
    assert found.frequency_hz == 12.5
    s = np.array([2j * np.pi * 12.5])
    np.testing.assert_allclose(found.values, BARE.receptance(s)[0, :, 0] * s)


def test_a_roving_hammer_shows_the_same_shape_by_reciprocity() -> None:
    found = operating_deflection(measured((1, 2, 3, 4), (1,)), FREEDOMS[:1], 12.5, 1)
    expected = operating_deflection(measured((1,), (1, 2, 3, 4)), FREEDOMS, 12.5, 1)
    assert found.freedoms == expected.freedoms
    np.testing.assert_allclose(found.values, expected.values)
    with pytest.raises(DataError, match="no force acted at point 9"):
        operating_deflection(measured((1,), (1, 2)), FREEDOMS[:2], 12.5, 9)


def test_a_mode_is_drawn_moving_once_to_and_fro(tmp_path: Path) -> None:
    _, known = string()
    found = mode_deflection(known.structure, known.samples, 2)
    np.testing.assert_allclose(np.abs(found.values), np.abs(np.sin(np.pi * np.arange(1, 10) / 5)), atol=1e-9)
    assert known.rig is not None
    Drawing(known.rig, motion_in_space(known.rig, found), "mode 2").save(tmp_path / "mode.gif")
    with Image.open(tmp_path / "mode.gif") as picture:
        assert getattr(picture, "n_frames", 1) == FRAMES
        assert picture.info["loop"] == 0


def test_modes_of_two_models_are_paired_by_their_shapes() -> None:
    """The other has its modes in another order, 2 % higher, and a sensor at point 4 that shows another one."""
    model, known = string()
    order = [1, 0, 2]
    constants = model.modal_constants[order].copy()
    constants[:, 3] = constants[:, 1]
    other = model.model_copy(
        update={
            "frequency_hz": 1.02 * model.frequency_hz[:3],
            "damping_ratio": model.damping_ratio[:3],
            "frequency_sigma_hz": np.zeros(3),
            "damping_sigma": np.zeros(3),
            "modal_constants": constants,
        }
    )
    found = correlate_models(known, KnownStructure(other, known.rig))
    assert found.pairs == ((0, 1), (1, 0), (2, 2))
    assert found.alone == ((3,), ())
    assert found.freedoms[int(np.argmin(found.comac))] == (4, "z")
    np.testing.assert_allclose(found.frequency_hz[2], [30.0, 30.6])
    assert "Modes of the first model alone: 4" in correlation_rows(found).caption


def test_models_without_common_points_are_not_compared() -> None:
    _, known = string()
    with pytest.raises(DataError, match="share 0 points"):
        correlate_models(known, KnownStructure(BARE.model()))
