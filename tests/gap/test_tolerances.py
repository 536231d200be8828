"""The tolerances of a bench as free numbers: only what is stated is free, and it moves the twin as its physics says."""

from dataclasses import replace

import numpy as np
import pytest

from modallab.core.rig import Beam, Tolerance
from modallab.gap.model.tolerances import Deviation, Scales, by_tolerance, limit_smoothly
from modallab.twin.bench import Twin
from modallab.twin.modes import solve_modes
from modallab.twin.neighbours import NeighbourStructures
from modallab.twin.structure import TwinStructure

BEAM = Beam(length_m=0.9, width_m=0.05, thickness_m=0.005, youngs_modulus_pa=2.05e11, density_kg_m3=7850.0)


def test_a_tolerance_that_is_not_stated_is_none() -> None:
    assert not Tolerance().of_assembly
    assert Tolerance().position_m == 0
    assert Tolerance(position_m=5e-4).of_assembly
    assert "position_m" not in Tolerance(sensitivity=0.01).model_dump()


def test_a_number_never_goes_far_beyond_its_tolerance() -> None:
    position = Deviation("position_m", 3.0, 1e-3)
    assert position.value(2.0) == pytest.approx(2e-3)
    assert position.value(50.0) == pytest.approx(4.5e-3)
    assert float(limit_smoothly(-50.0)) == pytest.approx(-4.5)


def test_a_root_is_never_stiffer_than_rigid() -> None:
    root = Deviation("clamp_compliance", 0.0, 2e-3, 1)
    values = [root.value(u) for u in (-9.0, -2.0, 0.0, 2.0)]
    assert values[0] > 0
    assert values == sorted(values)


@pytest.mark.parametrize("u", [0.5, -2.0, 7.0])
def test_all_numbers_at_once_are_those_one_by_one(u: float) -> None:
    listed = (
        Deviation("position_m", 3.0, 1e-3),
        Deviation("sensor_mass_kg", 3.0, 2e-3, 1),
        Deviation("clamp_compliance", 0.0, 2e-3, 1),
        Deviation("hit_position_m", 0.9, 1e-3, -1),
    )
    scales, one_by_one = Scales.of_all(listed), [d.value(u) for d in listed]
    assert scales.values(np.full(4, u)).tolist() == one_by_one
    assert scales.by_tolerance(one_by_one) == by_tolerance(zip(listed, one_by_one, strict=True))


@pytest.mark.parametrize(
    "change",
    [
        {"ei_field": np.array([1e-5, 0.0, 0.0])},
        {"mass_field": np.array([0.0, 1e-5, 0.0])},
        {"masses": ((0.45, 1e-5),)},
        {"rotation_springs": ((0.36, 1e-3),)},
        {"dampers": ((0.6, 0.501),)},
    ],
)
def test_first_order_modes_follow_a_small_change(change: dict[str, object]) -> None:
    here = replace(TwinStructure.of(BEAM, 0.006), dampers=((0.6, 0.5),))
    there = replace(here, **change)
    exact, near, before = solve_modes(there), NeighbourStructures(here).solve([there])[0], solve_modes(here)
    x = np.linspace(0.1, 0.9, 5)
    moved = exact.poles[:8] - before.poles[:8]
    assert np.allclose(near.poles[:8] - before.poles[:8], moved, atol=2e-3 * float(np.max(np.abs(moved))))
    # A shape's sign is free, a residue's is not.
    residues = [(m.shapes_at(x) * m.shapes_at(0.54)[0])[:, :6] for m in (exact, near, before)]
    step = residues[0] - residues[2]
    assert np.allclose(residues[1] - residues[2], step, atol=0.02 * float(np.max(np.abs(step))))


def test_a_twin_takes_its_hits_where_they_land() -> None:
    twin = replace(Twin(TwinStructure.of(BEAM, 0.006)), hit_offsets_m=((0.36, 2e-3),), hit_gains=((0.36, 1.01),))
    assert twin.struck_x_m(0.36) == pytest.approx(0.362)
    assert twin.struck_x_m(0.54) == 0.54
    assert twin.hit_gain(0.36) == 1.01
    assert twin.hit_gain(0.54) == 1.0


def test_neighbours_are_the_same_one_by_one_and_together() -> None:
    here = replace(
        TwinStructure.of(BEAM, 0.006), dampers=((0.6, 0.5),), losses=((0.3, 0.2, 0.01),), masses=((0.45, 0.01),)
    )
    there = [
        replace(here, youngs_modulus_pa=1.00001 * here.youngs_modulus_pa),
        replace(here, masses=((0.45, 0.01001),)),
        replace(here, dampers=((0.6, 0.501),)),
        replace(here, hung=((0.5, 0.1, 1e4),)),
    ]
    together = NeighbourStructures(here).solve(there)
    for structure, own in zip(there, together, strict=True):
        (alone,) = NeighbourStructures(here).solve([structure])
        np.testing.assert_allclose(own.poles, alone.poles, rtol=1e-12)
        np.testing.assert_allclose(own.columns, alone.columns, atol=1e-9 * float(np.max(np.abs(alone.columns))))
    assert len(together[3].poles) == len(solve_modes(there[3]).poles)
    np.testing.assert_allclose(together[3].poles, solve_modes(there[3]).poles)
