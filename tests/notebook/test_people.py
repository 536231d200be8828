"""`import modallab as ml`: from arrays or recordings to a model in three lines, and results that show themselves."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

import modallab as ml
from modallab.cli.demo import demo_rig
from modallab.core.errors import DataError, MissingPackageError, ModallabError, PlanError, StorageError
from modallab.core.plan import ImpactPlan
from modallab.gap.report.calibrated import twin_of_rig_file
from modallab.notebook.twin import DiagnosedTwin

LINES_HZ = np.arange(2.0, 100.0, 0.5)


@pytest.fixture(scope="module")
def twin() -> ml.DiagnosedTwin:
    rig = demo_rig()
    return DiagnosedTwin(twin_of_rig_file(rig), rig)


@pytest.fixture(scope="module")
def model(twin: ml.DiagnosedTwin) -> ml.Model:
    H = twin.frf(LINES_HZ, drive=10).frf.values
    noise = np.random.default_rng(1).standard_normal(H.shape) * 1e-3
    return ml.identify(ml.frf(LINES_HZ, H + noise, inputs=10, outputs=twin.points))


@pytest.fixture(scope="module")
def recorded(small: Path) -> ml.Model:
    return ml.identify(ml.load(small), "impact", progress=False)


def test_arrays_give_the_modes_within_their_sigmas(model: ml.Model, twin: ml.DiagnosedTwin) -> None:
    true = ml_modes(twin)
    off = np.abs(model.modal_model.frequency_hz - true) / model.modal_model.frequency_sigma_hz
    assert len(model) == 3
    assert np.all(off < 5)


def ml_modes(twin: ml.DiagnosedTwin) -> np.ndarray:
    from modallab.twin.modes import solve_modes

    return solve_modes(twin.twin.structure).frequency_hz[:3]


@pytest.mark.parametrize("shape", ["lines last", "lines first", "one input", "one FRF"])
def test_arrays_may_lie_either_way(twin: ml.DiagnosedTwin, shape: str) -> None:
    H = twin.frf(LINES_HZ, drive=10).frf.values
    given = {"lines last": H, "lines first": np.moveaxis(H, -1, 0), "one input": H[:, 0], "one FRF": H[0, 0]}[shape]
    found = ml.frf(LINES_HZ, given).frf.values
    assert found.shape == (1 if shape == "one FRF" else 10, 1, LINES_HZ.size)
    assert np.array_equal(found[0, 0], H[0, 0])


def test_a_model_shows_itself_in_a_notebook_and_at_a_prompt(model: ml.Model) -> None:
    assert model._repr_html_().count("<tr>") == 4
    assert "frequency [Hz]" in repr(model.table())
    assert len(repr(model)) < 100
    assert "\n" not in repr(model)


def test_a_model_draws_its_frfs_and_its_shapes(model: ml.Model) -> None:
    assert len([a for a in model.plot_frf().axes if a.get_visible()]) == 10
    assert len([a for a in model.plot_shapes().axes if a.get_visible()]) == 3


def test_a_model_is_that_of_another_where_the_shapes_are_alike(model: ml.Model, recorded: ml.Model) -> None:
    assert np.allclose(np.diag(model.mac(model)), 1)
    # A cantilever of another length, with lighter sensors.
    assert np.all(np.diag(model.mac(recorded)) > 0.97)


def test_a_model_becomes_a_table_and_labelled_arrays(model: ml.Model) -> None:
    table, arrays = model.to_pandas(), model.to_xarray()
    assert list(table.index) == [1, 2, 3]
    assert table["frequency_hz"].tolist() == model.modal_model.frequency_hz.tolist()
    assert arrays["shape"].sel(output="y10").shape == (3,)


def test_without_pandas_one_sentence_names_the_extra(model: ml.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("modallab.core.discovery.find_spec", lambda _: None)
    with pytest.raises(MissingPackageError, match=r"pandas, which is not installed\n.*'modallab\[tables\]'"):
        model.to_pandas()


def test_a_model_is_kept_as_a_document_and_as_a_report(recorded: ml.Model, tmp_path: Path) -> None:
    document = json.loads(recorded.save(tmp_path / "models.json").read_text())
    assert document["models"][0]["frequency_hz"] == recorded.modal_model.frequency_hz.tolist()


def test_a_recording_is_short_to_read_and_can_be_kept(small: Path, tmp_path: Path) -> None:
    recording = ml.load(small)
    assert repr(recording) == "<Recording of 'test link': 6 impact records, 24 sine records>"
    assert len(ml.load(recording.save(tmp_path / "again.h5")).campaign.blocks) == 30


def test_the_state_space_is_the_frf(twin: ml.DiagnosedTwin) -> None:
    s, matrices = 2j * np.pi * LINES_HZ[40], twin.state_space(10, "receptance")
    direct = twin.frf(LINES_HZ[[40]], 10, "receptance").frf.values[:, 0, 0]
    there = matrices.C @ np.linalg.solve(s * np.eye(len(matrices.A)) - matrices.A, matrices.B)
    assert np.allclose(there[:, 0], direct, rtol=1e-3)


def test_a_step_is_that_of_the_state_space_for_a_force_that_runs_straight_and_goes_on(twin: ml.DiagnosedTwin) -> None:
    force, dt = np.random.default_rng(2).standard_normal(40), 1e-4
    _, expected, _ = signal.lsim(tuple(twin.state_space(10)), force, dt * np.arange(40))
    twin.reset()
    at_once = twin.step(force, dt, 10)
    assert np.allclose(at_once, expected.T, rtol=1e-8, atol=1e-8)
    twin.reset()
    one_by_one = np.stack([twin.step(float(newton), dt, 10) for newton in force], axis=1)
    assert np.allclose(one_by_one, at_once)


@pytest.mark.thorough("starts Python and a bench anew")
def test_a_bench_is_tested_from_a_script_without_a_guard(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import modallab as ml\nfrom modallab.core.plan import ImpactPlan\n"
        "print(ml.simulate(effect={'added_mass': {'mass': 0.05, 'x': 0.8}}, plan=ImpactPlan(points=(10,), hits=1)))\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout.strip() == "<Recording of 'elastic link, demonstration bench': 1 impact records>", done.stderr


def test_importing_it_costs_nothing_heavy_and_frf_is_a_function_before_and_after() -> None:
    code = (
        "import sys, modallab as ml; print([m for m in ('numpy', 'pydantic') if m in sys.modules]); ml.frf; "
        "import modallab.frf; print(ml.frf([1, 2, 3], [1j, 2j, 3j]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]", "<MeasuredFrf: inertance, 1 outputs, 1 inputs, 3 lines>"]


def one_mode() -> np.ndarray:
    s, pole = 2j * np.pi * LINES_HZ, 2 * np.pi * 30
    noise = np.random.default_rng(0).standard_normal((2, LINES_HZ.size)) * 1e-4
    return s**2 / (pole**2 + 0.02 * s * pole + s**2) * np.array([[1], [0.7]]) + noise


f, H = LINES_HZ, np.ones((2, 1, LINES_HZ.size)) * 1j
MISTAKES = {
    "another number of lines": (lambda: ml.frf(f[:-1], H), "does not fit 195 frequencies"),
    "amplitudes alone": (lambda: ml.frf(f, np.abs(H)), "real numbers"),
    "descending": (lambda: ml.frf(f[::-1], H), "do not ascend"),
    "a quantity there is not": (lambda: ml.frf(f, H, quantity="accelerance"), "no FRF is called 'accelerance'"),
    "too few points": (lambda: ml.frf(f, H, outputs=[1]), r"outputs=\[1\] for 2 outputs"),
    "a point twice": (lambda: ml.frf(f, H, outputs=[1, 1]), r"outputs=\[1, 1\]"),
    "no file": (lambda: ml.load("nowhere.h5"), "does not exist"),
    "a path instead of recordings": (lambda: ml.identify("campaign.h5"), r"ml\.load\('campaign.h5'\)"),
    "an array instead of FRFs": (lambda: ml.identify(H), r"ml\.frf\(f, H\)"),
    "a band upside down": (lambda: ml.identify(ml.frf(f, H), band=(80, 3)), "there is no band 80 to 3 Hz"),
    "FRFs without a resonance": (lambda: ml.identify(ml.frf(f, H)), "is stable|stands out"),
    "a method there is not": (lambda: ml.identify(ml.frf(f, H), method="lscf"), "lscf"),
    "a structure there is not": (lambda: ml.simulate("plate"), "no structure is called 'plate'"),
    "an effect there is not": (lambda: ml.simulate(effect="mass=3"), "no effect is called 'mass=3'"),
    "an effect without its place": (lambda: ml.simulate(effect="added_mass,mass=0.05"), "write it as added_mass,mass="),
    "an effect with a wrong key": (lambda: ml.simulate(effect="added_mass,m=1,x=0.8"), "has no parameter 'm'"),
    "a point there is not": (lambda: ml.simulate(plan=ImpactPlan(points=(99,))), "99"),
    "a shape that is none": (lambda: ml.frf(f[None], H), r"f has the shape \(1, 196\)"),
    "words for frequencies": (lambda: ml.frf(["a", "b"], [1j, 2j]), "f is no array of numbers"),
    "rows of two lengths": (lambda: ml.frf([1, 2], [[1j, 2j], [1j]]), "H is no array of numbers"),
    "values that are not finite": (lambda: ml.frf(f, np.where(f == 30, np.nan, H)), "H holds 2 values"),
    "outputs by name": (lambda: ml.frf(f, H, outputs=["tip", "root"]), "are not point numbers"),
    "inputs for outputs": (lambda: ml.frf(f, H, inputs=[1, 2], outputs=[10]), r"outputs=\[10\] for 2 outputs"),
    "a conjugated FRF": (lambda: ml.identify(ml.frf(f, one_mode().conj())), "the phase of H rises"),
    "one edge for a band": (lambda: ml.identify(ml.frf(f, H), band=3), "band=3 is no pair"),
    "three edges": (lambda: ml.identify(ml.frf(f, H), band=(3, 50, 90)), "is no pair"),
    "a band as text": (lambda: ml.identify(ml.frf(f, H), band="3 110"), "is no pair"),
    "a pick as text": (lambda: ml.identify(ml.frf(f, H), pick="30"), "pick='30' is no list"),
    "every mode dropped": (lambda: ml.identify(ml.frf(f, one_mode()), drop=(30,)), "no mode is left"),
    "a number for a file": (lambda: ml.load(3), "3 is no name of a file"),
    "a file that is no table": (lambda: ml.load(__file__), "holds no table of numbers"),
    "an option that is none": (lambda: ml.load(__file__, rig=demo_rig(), rate=2000), "did you mean rate_hz?"),
    "a plan that is none": (lambda: ml.simulate(plan=3), "3 is no plan"),
    "a plan with a wrong field": (lambda: ml.simulate(plan={"kind": "impact", "points": 10}), "points is 10"),
    "an effect without numbers": (lambda: ml.simulate(effect={"added_mass": 0.05}), "is no effect"),
    "a diagnosis without a beam": (lambda: ml.diagnose(ml.frf(f, H)), "beam"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_ends_in_one_sentence_and_a_remedy(mistake: str) -> None:
    make, said = MISTAKES[mistake]
    with pytest.raises(ModallabError, match=said) as caught:
        make()
    assert caught.value.remedy


def test_results_go_only_where_their_name_says(recorded: ml.Model, small: Path, tmp_path: Path) -> None:
    for save in (recorded.save, ml.load(small).save):
        with pytest.raises(StorageError, match=r"does not end in"):
            save(tmp_path / "report.docx")
    with pytest.raises(PlanError, match=r"'point:99' holds out 0 of 30 records"):
        ml.diagnose(ml.load(small), "point:99")
    with pytest.raises(DataError, match="str is no model"):
        recorded.mac("x")
