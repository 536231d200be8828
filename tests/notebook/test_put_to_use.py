"""A model put to use at a prompt: predictions from identified FRFs are those of the structure they came from."""

from pathlib import Path

import numpy as np
import pytest
from chain import BARE
from scipy.io import loadmat

import modallab as ml
from modallab.core.errors import DataError, StorageError
from modallab.core.plan import ImpactPlan

HZ = np.arange(0.5, 60.0, 0.05)


@pytest.fixture(scope="module")
def model() -> ml.Model:
    s = 2j * np.pi * HZ
    measured = (BARE.receptance(s) * s[:, None, None])[:, :, [0]]
    return ml.identify(ml.frf(HZ, np.moveaxis(measured, 0, -1), inputs=[1], quantity="mobility"), progress=False)


def test_an_frf_at_a_pair_that_was_never_measured_is_that_of_the_structure(model: ml.Model) -> None:
    found = model.frf(HZ[100:], outputs=[3], inputs=[4]).frf
    s = 2j * np.pi * HZ[100:]
    truth = (BARE.receptance(s) * s[:, None, None])[:, 2, 3]
    assert np.linalg.norm(found.values[0, 0] - truth) < 1e-3 * np.linalg.norm(truth)
    assert found.variance is not None
    off = np.abs(found.values[0, 0] - truth)
    assert np.mean(off <= 2 * np.sqrt(found.variance[0, 0])) > 0.9


def test_a_mass_and_a_spring_move_the_modes_as_they_move_those_of_the_structure(model: ml.Model) -> None:
    mass, stiffness = BARE.mass.copy(), BARE.stiffness.copy()
    mass[2, 2] += 0.4
    stiffness[1, 1] += 2e4
    truth = np.abs(type(BARE)(mass, BARE.damping, stiffness).poles()) / (2 * np.pi)
    after = model.modify(ml.Element(3, mass=0.4), at=2, spring=2e4)
    np.testing.assert_allclose(after.frequency_hz, truth, rtol=1e-4)
    assert np.all(np.abs(after.frequency_hz - truth) < 3 * after.frequency_sigma_hz)
    assert "mass 0.4 kg at 3" in repr(after)
    assert after.table().headings[:3] == ("mode", "before [Hz]", "after [Hz]")


def test_changes_of_a_changed_model_add_up(model: ml.Model) -> None:
    twice = model.modify(at=3, mass=0.2).modify(at=3, mass=0.2)
    np.testing.assert_allclose(twice.frequency_hz, model.modify(at=3, mass=0.4).frequency_hz, rtol=1e-9)


def test_the_table_of_answers_begins_with_the_smallest(model: ml.Model) -> None:
    sizes = [float(row[1].split("(")[0]) for row in model.tune(1, 10.5, "mass").rows]
    assert sizes == sorted(sizes)


def test_a_response_is_that_of_the_state_space(model: ml.Model) -> None:
    dt, force = 1 / 256, np.random.default_rng(1).standard_normal(512)
    moved = model.response(force, dt, at=1, quantity="velocity", between="linear")
    _, expected, _ = model.state_space(1, quantity="velocity").scipy().output(force, dt * np.arange(512))
    np.testing.assert_allclose(moved.values, expected.T, atol=1e-9)
    np.testing.assert_allclose(moved.error_against(moved.values), 0)
    np.testing.assert_allclose(moved.level(0, 1 / dt), moved.rms, rtol=0.05)


@pytest.mark.parametrize("ending", [".uff", ".mat", ".h5"])
def test_smoothed_frfs_are_written_for_other_programs(model: ml.Model, tmp_path: Path, ending: str) -> None:
    smoothed = model.frf(HZ[10:], outputs=[1, 2], inputs=[1, 4])
    path = smoothed.save(tmp_path / f"smooth{ending}")
    if ending == ".mat":
        np.testing.assert_allclose(loadmat(path)["H"], smoothed.frf.values)
    else:
        # The universal file holds one function for each pair; the campaign file the matrix.
        frfs = ml.load(path).campaign.frfs
        assert sum(f.values.shape[0] * f.values.shape[1] for f in frfs) == 4
    with pytest.raises(StorageError):
        smoothed.save(tmp_path / "smooth.xyz")


def test_what_a_model_explains_is_a_table_with_its_numbers(model: ml.Model, tmp_path: Path) -> None:
    shares = model.participation(1, 3, (2, 50))
    assert shares.numbers.share.sum() + shares.numbers.outside == pytest.approx(1)
    assert shares.headings[2] == "share [%]"
    assert model.nodes().numbers.motion.max() == pytest.approx(1)
    s = np.array([2j * np.pi * 20.0])
    truth = BARE.receptance(s)[0, :, 0] * s
    np.testing.assert_allclose(model.deflection(20, at=1).numbers.values, truth, rtol=1e-6)
    assert model.shape(2).save(tmp_path / "mode.gif").stat().st_size > 1000
    with pytest.raises(StorageError, match="gif"):
        model.shape(2).save(tmp_path / "mode.mp4")


def test_a_reduction_says_both_sizes_and_the_error_of_each_pair(model: ml.Model) -> None:
    found = model.reduction()
    check, sizes = model.verification, found.numbers
    off = np.abs(check.regenerated.values - check.measured.values) ** 2
    expected = np.sqrt(off.sum(axis=2) / np.sum(np.abs(check.measured.values) ** 2, axis=2))
    np.testing.assert_allclose(sizes.error, expected)
    assert sizes.measured_numbers == 2 * check.measured.values.size > 10 * sizes.model_numbers
    assert len(found.rows) == sizes.frac.size


def test_answers_of_the_inverse_have_their_numbers(model: ml.Model) -> None:
    sizes = [one.size for one in model.tune(1, 10.5, "mass").numbers if one.feasible]
    hz = model.modify(at=model.tune(1, 10.5, "mass").numbers[0].at, mass=sizes[0]).frequency_hz
    assert np.abs(hz - 10.5).min() < 1e-3
    found = model.best_absorber(mode=1, at=1, mass=0.1)
    assert found.numbers.after < found.numbers.before
    assert model.modify(found.numbers.absorber).frequency_hz.size == model.modal_model.n_modes + 1


def test_every_result_shows_itself_in_a_line_at_a_prompt(model: ml.Model) -> None:
    results = model, model.modify(mass=0.1, at=1), model.state_space(1), model.frf(HZ[10:])
    assert all("\n" not in repr(one) and len(repr(one)) < 150 for one in results)


def test_what_cannot_be_asked_is_said(model: ml.Model) -> None:
    with pytest.raises(DataError, match="use one of mass, spring"):
        model.tune(1, 10.5, by="damper")  # type: ignore[arg-type]
    with pytest.raises(DataError, match="use one of mass, spring"):
        model.free_band((10, 12), by="damper")  # type: ignore[arg-type]
    with pytest.raises(DataError, match="above 0 in kg"):
        model.best_absorber(mode=1, at=1, mass=-0.1)
    with pytest.raises(DataError, match="there is no change"):
        model.modify()
    with pytest.raises(DataError, match="2 forces at 1 points"):
        model.response(np.zeros((2, 8)), 0.01, at=1)


@pytest.mark.thorough("records two tests of the simulated bench")
def test_a_mass_on_the_simulated_bench_moves_its_modes_as_the_model_of_the_bare_one_says() -> None:
    plan = ImpactPlan(points=(10, 6, 3), hits=2)
    effects = (), "added_mass,mass=0.05,x=0.8"
    tests = [ml.simulate("link", e, seed=11, tolerances="usual", plan=plan, progress=False) for e in effects]
    bare, heavy = (ml.identify(test, "impact", progress=False) for test in tests)
    after = bare.modify(mass=0.05, at=8)
    measured = heavy.modal_model.frequency_hz
    nearest = measured[np.argmin(np.abs(after.frequency_hz[:, None] - measured), axis=1)]
    off, known = after.frequency_hz / nearest - 1, bare.modal_model.n_modes
    assert np.abs(off[:known]).max() < 2e-3
    assert np.all(np.abs(off) < 3 * after.frequency_sigma_hz / after.frequency_hz)
    # One comes in from beyond the band, where the bare model has a compliance only.
    assert np.abs(off).max() < 0.02
