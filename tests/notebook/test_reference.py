"""A structure against what was measured of it before: one verb, one result."""

from pathlib import Path

import numpy as np
import pytest

import modallab as ml
from modallab.core.errors import DataError

HZ = np.linspace(5.0, 200.0, 400)
SHAPES = np.array([[1.0, 0.9, 0.6, 0.2], [0.8, -0.3, -0.9, -0.6], [0.5, -0.8, 0.2, 0.9]])
OMEGA = 2 * np.pi * np.array([21.0, 68.0, 143.0])


def measured(kg: float = 0.0):
    """Receptances of three modes at four driven points, with a mass at point 2: coupled exactly, line by line."""
    w = 2 * np.pi * HZ[:, None, None]
    bare = sum(np.outer(s, s) / (o**2 - w**2 + 2j * 0.01 * o * w) for s, o in zip(SHAPES, OMEGA, strict=True))
    loaded = bare + kg * w**2 * bare[:, :, [1]] * bare[:, [1], :] / (1 - kg * w**2 * bare[:, [1], [1]][:, None])
    rng = np.random.default_rng(3)
    noise = 1e-3 * np.abs(loaded).mean() * (rng.normal(size=(2, *loaded.shape)) * [[[[1]]], [[[1j]]]]).sum(axis=0)
    points = [1, 2, 3, 4]
    return ml.frf(HZ, np.moveaxis(loaded + noise, 0, -1), inputs=points, outputs=points, quantity="receptance")


@pytest.fixture(scope="module")
def heavier():
    return ml.diagnose(measured(kg=0.05), reference=measured(), progress=False)


def test_a_mass_that_came_later_is_named_with_its_interval(heavier):
    (mass,) = heavier.effects
    assert (mass.effect, mass.place.point) == ("added_mass", 2)
    low, high = mass.interval["mass"]
    assert low < 0.05 < high
    (row,) = heavier.table().rows
    assert row[:2] == ("added_mass", "near point 2")


def test_what_was_found_is_kept_as_a_document_and_as_a_report(heavier, tmp_path: Path):
    assert '"verdict": "known"' in heavier.save(tmp_path / "gap.json").read_text(encoding="utf-8")
    assert "added mass" in heavier.save(tmp_path / "gap.html").read_text(encoding="utf-8").lower()


def test_a_structure_is_no_beam_and_holds_nothing_out(heavier):
    with pytest.raises(DataError, match="no simulated beam"):
        _ = heavier.twin
    with pytest.raises(DataError, match="no held-out records"):
        ml.diagnose(measured(), "last:0.3", reference=measured(), progress=False)


@pytest.mark.thorough("identifies and compares two campaigns once more")
def test_both_are_identified_in_a_band_that_only_a_comparison_has():
    found = ml.diagnose(measured(kg=0.05), reference=measured(), band=(5, 100), progress=False).diagnosis
    assert (found.modes, [e.effect for e in found.effects]) == ((2, 2), ["added_mass"])
    with pytest.raises(DataError, match="no effect without a reference"):
        ml.diagnose(measured(), band=(5, 100), progress=False)
