"""A structure without a beam against its modal model: a simply supported plate, whose modes have a closed form."""

import numpy as np
import pytest
from closed_form_plate import OMEGA, REFERENCE, SENSORS, A, B, X, Y, model, rig, shapes, with_mass
from scipy.linalg import eigh

from modallab.core.frf import Frf
from modallab.gap.modal.compared import compared
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.gap.modal.free import Free
from modallab.gap.modal.matching import Side
from modallab.gap.modal.weights import Weights
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.frfs import receptances_of_model
from modallab.modification.mesh import MOST, Mesh, surface_directions
from modallab.modification.shapes import shapes_of


def test_constants_hold_the_shapes_of_every_struck_point_and_what_lies_between() -> None:
    found = shapes_of(REFERENCE, rig())
    psi = np.array([found.seen[:, found.index((p, "z"))] for p in range(1, X.size + 1)]).T
    signs = np.sign(np.sum(psi * shapes(X, Y), axis=1))[:, None]
    np.testing.assert_allclose(signs * psi, shapes(X, Y), atol=1e-6)
    moved = signs[:2, 0] * found.shapes_beside((7, "z"), np.array([[0.02, 0.01, 0.0]]))[0, :2]
    np.testing.assert_allclose(moved, shapes(X[6:7] + 0.02, Y[6:7] + 0.01)[:2, 0], atol=0.03)


def test_the_derivatives_by_every_tolerance_are_those_of_differences() -> None:
    free = Free(compared(Side(REFERENCE), Side(with_mass(0.02, 0.3, 0.2)), rig()))
    u = 0.3 * np.random.default_rng(1).standard_normal(free.size)
    slopes = free.slopes(u)
    for k in (0, 1, 3, 5, 12, 15, 17, 18, 20, 40, 45, 60, 85, free.size - 1):
        step = 1e-5 * np.eye(free.size)[k]
        difference = (free.residual(u + step) - free.residual(u - step)) / 2e-5
        np.testing.assert_allclose(slopes[:, k], difference, atol=1e-5 * max(np.abs(difference).max(), 1e-3))


def test_a_structure_that_is_stiffer_as_a_whole_bends_less_outside_the_band_too() -> None:
    free = Free(compared(Side(REFERENCE), Side(REFERENCE), rig()))
    u = np.eye(free.size)[0]
    s = np.array([1e-3j])
    beside = np.full((1, *REFERENCE.modal_constants.shape[1:]), 1e-7 + 0j)
    static = free.at(s, lambda _: beside)
    stiffer = np.exp(free.deviations[0])
    np.testing.assert_allclose(static.predicted(u), static.predicted(0 * u) / stiffer, rtol=1e-4)


def test_a_misfit_counts_by_the_covariance_of_its_lines() -> None:
    """r^T (S + B B^T)^-1 r, with the inverse taken as it stands."""
    rng = np.random.default_rng(3)
    terms = rng.standard_normal((2, 6)) + 1j * rng.standard_normal((2, 6))
    misfit = rng.standard_normal((6, 1, 1)) + 1j * rng.standard_normal((6, 1, 1))
    weights = Weights.of(np.full((6, 1, 1), 0.5), terms, np.array([3.0, 1e4]).reshape(2, 1, 1))
    columns = np.concatenate([terms.real, terms.imag], axis=1).T * np.array([3.0, 1e4])
    r = np.concatenate([misfit.real, misfit.imag]).ravel()
    expected = r @ np.linalg.solve(0.25 * np.eye(12) + columns @ columns.T, r)
    assert np.sum(weights.weighed(misfit[None]) ** 2) == pytest.approx(expected, rel=1e-6)


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_a_spring_that_moves_a_mode_by_a_quarter_is_found_from_afar() -> None:
    there = shapes(np.array([0.17]), np.array([0.11]))
    squared, turned = eigh(np.diag(OMEGA**2) + 3e4 * there @ there.T)
    found = diagnose_by_model(REFERENCE, model(np.sqrt(squared), turned.T @ shapes(X, Y)), rig())
    assert np.sqrt(squared[0]) / OMEGA[0] > 1.25
    (effect,) = found.effects
    assert effect.effect == "ground_spring"
    assert effect.interval["k"][0] < 3e4 < effect.interval["k"][1]
    assert np.linalg.norm(np.array(effect.place.at_m) - [0.17, 0.11, 0.0]) < 0.02


def test_a_mass_is_found_where_it_is() -> None:
    found = diagnose_by_model(REFERENCE, with_mass(0.06, 0.31, 0.17), rig())
    assert found.verdict == "known"
    (effect,) = found.effects
    assert effect.effect == "added_mass"
    assert effect.parameters["mass"] == pytest.approx(0.06, rel=0.1)
    assert np.linalg.norm(np.array(effect.place.at_m) - [0.31, 0.17, 0.0]) < 0.02
    assert effect.interval["mass"][0] < effect.parameters["mass"] < effect.interval["mass"][1]


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_a_gain_is_that_of_its_channel() -> None:
    found = diagnose_by_model(REFERENCE, model(OMEGA, shapes(X, Y), (1.0, 0.8, 1.0)), rig())
    (effect,) = found.effects
    assert (effect.effect, effect.place.model_dump()) == ("gain_error", {"channel": "a2"})
    assert effect.parameters["gain"] == pytest.approx(0.8, rel=0.02)


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_what_the_tolerances_explain_is_no_gap() -> None:
    bench = model(1.005 * OMEGA, shapes(X, Y), (1.01, 0.99, 1.0))
    found = diagnose_by_model(REFERENCE, bench, rig())
    assert (found.verdict, found.effects) == ("no_gap", [])


@pytest.mark.thorough("a comparison for each of three draws")
@pytest.mark.parametrize("seed", range(3))
def test_shapes_poles_and_damping_each_off_by_their_own_share_are_no_gap(seed: int) -> None:
    """Nothing says that they are off by the same share of what is usual: a scale for all of them would be bent."""
    rng = np.random.default_rng(seed)
    bench = model(OMEGA * (1 + 3e-3 * rng.standard_normal(OMEGA.size)), shapes(X, Y))
    drawn = rng.standard_normal((2, *bench.modal_constants.shape))
    constants = bench.modal_constants * (1 + 1e-3 * (drawn[0] + 1j * drawn[1]))
    damping = bench.damping_ratio * np.exp(0.3 * rng.standard_normal(OMEGA.size))
    other = bench.model_copy(update={"modal_constants": constants, "damping_ratio": damping})
    assert diagnose_by_model(REFERENCE, other, rig()).verdict == "no_gap"


@pytest.mark.parametrize("gain", [1.0, pytest.param(1.1, marks=pytest.mark.thorough("diagnoses a plate once more"))])
def test_a_mode_just_above_the_band_of_one_side_is_no_gap(gain: float) -> None:
    """What an identification makes of it in a few terms is not what a model makes of it that holds the mode."""
    hz = np.arange(5.0, 0.95 * OMEGA[-1] / (2 * np.pi), 0.05)
    s = 2j * np.pi * hz
    accelerations = (
        np.moveaxis(s[:, None, None] ** 2 * receptances_of_model(REFERENCE, s), 0, 2)
        * np.array([1.0, gain, 1.0])[:, None, None]
    )
    frf = Frf(hz, accelerations, "inertance", REFERENCE.outputs, REFERENCE.output_points, REFERENCE.input_points)
    bench, _ = identify_frf(frf, rig(), IdentificationOptions())
    assert bench.n_modes == OMEGA.size - 1
    found = diagnose_by_model(REFERENCE, bench, rig())
    assert [e.effect for e in found.effects] == ([] if gain == 1.0 else ["gain_error"])
    assert found.verdict == ("no_gap" if gain == 1.0 else "known")


def mesh() -> Mesh:
    """Nodes some 25 mm apart, the shapes with the signs that an eigensolver happens to give."""
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(0, A, 21), np.linspace(0, B, 17), indexing="ij"))
    signs = np.array([1.0, -1.0, 1.0, -1.0])
    return Mesh(np.stack([x, y, 0 * x], axis=1), {"z": (shapes(x, y) * signs[:, None]).T})


def test_between_the_points_a_mesh_tells_the_shapes() -> None:
    offsets = np.array([[0.031, 0.022, 0.0], [-0.04, 0.03, 0.0], [0.02, -0.045, 0.0]])
    for point in SENSORS:
        true = shapes(X[point - 1] + offsets[:, 0], Y[point - 1] + offsets[:, 1]).T
        off = []
        for known in (None, mesh()):
            found = shapes_of(REFERENCE, rig(), known)
            here = found.seen[:, found.index((point, "z"))] * shapes(X[point - 1], Y[point - 1])
            off.append(np.abs(np.sign(here) * found.shapes_beside((point, "z"), offsets) - true).max())
            if known is not None:
                assert np.all(found.uncertainty_beside((point, "z"), offsets) < 3e-3 * np.abs(true).max())
        assert off[1] < 0.1 * off[0]
        assert off[1] < 2e-3 * np.abs(true).max()


@pytest.mark.thorough("diagnoses a plate of ten points")
def test_a_sensor_that_stands_elsewhere_is_found_by_the_mesh_to_a_millimetre() -> None:
    moved = (0.024, -0.017)
    psi = shapes(X, Y)
    elsewhere = shapes(np.array([X[6] + moved[0]]), np.array([Y[6] + moved[1]]))[:, 0]
    bench = model(OMEGA, psi)
    constants = bench.modal_constants.copy()
    constants[:, 1] = elsewhere[:, None] * psi
    found = diagnose_by_model(REFERENCE, bench.model_copy(update={"modal_constants": constants}), rig(), mesh())
    (effect,) = found.effects
    assert (effect.effect, effect.place.model_dump()) == ("position_error", {"channel": "a2"})
    assert (effect.parameters["dx"], effect.parameters["dy"]) == pytest.approx(moved, abs=1e-3)


def test_of_a_large_mesh_the_nodes_about_the_points_are_kept() -> None:
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-2 * A, 3 * A, 200), np.linspace(0, B, 60), indexing="ij"))
    points = np.stack([X, Y, 0 * X], axis=1)
    kept = Mesh(np.stack([x, y, 0 * x], axis=1), {"z": np.zeros((x.size, 4))}).near_points(points)
    assert len(kept.places_m) <= MOST == len(kept.motion["z"])
    away = np.linalg.norm(kept.places_m[:, None] - points[None], axis=2).min(axis=1)
    assert away.max() < 0.4 * A
    # Wherever a change may be looked for, a node is near.
    there = points[:, None] + np.array([[0.03, 0.0, 0.0], [0.0, 0.03, 0.0], [-0.03, 0.02, 0.0]])
    near = np.linalg.norm(there.reshape(-1, 1, 3) - kept.places_m[None], axis=2).min(axis=1)
    assert near.max() < 0.03


AROUND = np.arange(24) * np.pi / 12
TUBE = np.array([(x, 0.05 * np.cos(a), 0.05 * np.sin(a)) for x in np.linspace(0, 1.2, 49) for a in AROUND])
LATTICE = np.stack([v.ravel() for v in np.meshgrid(*[np.linspace(0, 1, 11)] * 3, indexing="ij")], axis=1)


def test_on_a_tube_a_place_is_moved_along_the_axis_alone_where_the_wall_bends_away() -> None:
    here = np.array([0.6, 0.0, 0.05])
    for axis in "yz":
        found = surface_directions(TUBE, here, axis, 0.07)
        assert found is not None
        np.testing.assert_allclose(np.abs(found), [[1, 0, 0], [0, 0, 0]], atol=1e-9)
    near = surface_directions(TUBE, here, "z", 0.02)
    assert near is not None
    np.testing.assert_allclose(np.sort(np.abs(near), axis=0), [[0, 0, 0], [1, 1, 0]], atol=1e-6)


def test_at_the_edge_of_a_plate_both_directions_stay() -> None:
    known = mesh().places_m
    found = surface_directions(known, np.array([A, B, 0.0]), "z", 0.1)
    assert found is not None
    np.testing.assert_allclose(found @ found.T, np.eye(2), atol=1e-9)
    np.testing.assert_allclose(found[:, 2], 0, atol=1e-9)


@pytest.mark.parametrize("nodes", [LATTICE, LATTICE[:121:11]], ids=["body", "line"])
def test_nodes_that_are_no_surface_say_no_tangents(nodes: np.ndarray) -> None:
    assert surface_directions(nodes, nodes[len(nodes) // 2], "z", 0.1) is None


@pytest.mark.thorough("two diagnoses of ten channels, 5 s each")
@pytest.mark.parametrize(("factor", "said"), [(0.9, "stiffer"), (1.1, "softer")])
def test_of_a_computed_reference_whose_only_fault_is_e_it_is_said(factor: float, said: str) -> None:
    computed = {"method": "finite_elements"}
    reference = model(OMEGA * np.sqrt(factor), shapes(X, Y)).model_copy(update=computed)
    found = diagnose_by_model(reference, REFERENCE, rig())
    assert found.verdict == "no_gap"
    (note,) = (one for one in found.notes if "as a whole" in one)
    assert said in note
    assert "Young's modulus" in note
