"""Other simulations of the bench: records read back, simulated and compared with it, and the exported twin."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from made_diagnosis import made_diagnosis
from numpy.typing import NDArray
from twin_campaign import bench, built

from modallab.cli import main
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.errors import DataError, FormatError
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import write_campaign
from modallab.formats.prediction import read_prediction, write_prediction
from modallab.formats.rig.rig_file import write_rig
from modallab.gap.design.prediction import predict_records, replace_responses
from modallab.gap.export.chain import chain_of_structure
from modallab.gap.export.forms import FORMS, FormError, measure_form, write_form
from modallab.gap.export.mjcf import mujoco_simulation, write_mjcf
from modallab.gap.export.state_space import read_state_space, state_space
from modallab.gap.model.forward import predict_record
from modallab.gap.simulations.compare import (
    SimulationComparison,
    compare_simulation,
    differing_effects,
    simulation_as_measured,
)
from modallab.gap.simulations.simulated_records import simulated_records, simulation_residual
from modallab.gap.words.verdicts import sentence_of_simulation
from modallab.reporting.simulation_report import write_simulation_report
from modallab.twin.modes import solve_modes

Array = NDArray[np.float64]
MASS = Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8})
MORE = (
    MASS,
    Effect(effect="local_damper", parameters={"c": 3.0}, place={"x": 0.53}),
    Effect(effect="ac_coupling", parameters={"corner_hz": 1.0}, place={"channel": "all"}),
    Effect(effect="loose_mount", parameters={"hz": 200.0, "zeta": 0.05}, place={"channel": 4}),
    Effect(effect="trigger_delay", parameters={"seconds": 1e-4}, place={"channel": "all"}),
    Effect(effect="gain_error", parameters={"gain": 0.8}, place={"channel": 2}),
)
ONE = ["impact_p06_0", "sine_low_023.438"]


@pytest.fixture(scope="module")
def heavy(rig: Rig) -> Campaign:
    return built(rig, MASS)


@pytest.fixture(scope="module")
def few(heavy: Campaign) -> Campaign:
    """A hit at each point: a simulation takes a while."""
    return replace(heavy, blocks=tuple(b for b in heavy.blocks if b.test == "impact" and b.name.endswith("_0")))


@pytest.fixture(scope="module")
def of_twin(rig: Rig, heavy: Campaign) -> dict[str, Array]:
    """What a simulation that lacks the mass predicts."""
    return predict_records(made_diagnosis(rig, verdict="no_gap"), heavy)


def test_a_state_space_plays_what_the_twin_plays(rig: Rig, heavy: Campaign) -> None:
    twin = replace(bench(rig, MORE), residual_compliance=1.0)
    for block in (b for b in heavy.blocks if b.name in ONE):
        system = state_space(twin, rig, block.test)
        found = simulated_records(system.simulate, heavy, [block.name])[block.name]
        own = predict_record(twin, rig, block, 35.0)
        assert np.linalg.norm(found - own) < 1e-3 * np.linalg.norm(own)


def test_a_chain_of_links_has_the_modes_of_the_beam(rig: Rig) -> None:
    structure = bench(rig, (MASS,)).structure
    found = chain_of_structure(structure, np.array([p.x_m for p in rig.points]))
    shapes = found.displacement @ found.modes
    products = shapes.T @ (found.masses_kg[:, None] * shapes)
    assert np.allclose(products[:6, :6], np.eye(6), atol=1e-3)
    assert np.allclose(found.omega, np.abs(solve_modes(structure).poles))


def test_mujoco_moves_as_the_twin_does(rig: Rig, tmp_path: Path) -> None:
    twin = bench(
        rig, (MASS, Effect(effect="clamp_translation", parameters={"k_trans": 4e5}, place={"x": 0.0}), MORE[1])
    )
    write_mjcf(tmp_path / "link.xml", twin, rig, "impact")
    force, dt = np.zeros((10, 3200)), 1 / 32000
    force[3, :96] = 50 * np.sin(np.pi * np.arange(96) / 96)
    found = mujoco_simulation(tmp_path / "link.xml", rig)(force, dt)
    own = state_space(twin, rig, "impact").simulate(force, dt)
    assert np.linalg.norm(found - own) < 0.01 * np.linalg.norm(own)


@pytest.mark.parametrize("form", ["npz", "uff"])
def test_an_exported_twin_closes_the_gap_in_its_own_form(rig: Rig, few: Campaign, form: str) -> None:
    found = measure_form(FORMS[form], made_diagnosis(rig, MASS), few, ["impact"], None)
    assert found.records == ["impact_p10_0"]
    assert found.before > 50
    assert found.after == pytest.approx(found.twin_after, abs=0.05)
    assert found.closed is not None
    assert found.closed > 0.999


def test_a_state_space_file_is_read_as_it_was_written(rig: Rig, tmp_path: Path) -> None:
    own = state_space(bench(rig, (MASS,)), rig, "impact")
    for form in ("npz", "mat"):
        path = tmp_path / f"twin.{form}"
        write_form(path, FORMS[form], made_diagnosis(rig, MASS), rig, ["impact"], 2000.0)
        found = read_state_space(path)["impact"]
        assert found.A.shape == own.A.shape
        assert np.allclose(np.linalg.eigvals(found.A), np.linalg.eigvals(own.A), rtol=1e-6)
    stepped = np.load(tmp_path / "twin.npz")
    assert np.all(np.abs(np.linalg.eigvals(stepped["Ad_impact"])) < 1)
    (tmp_path / "bad.npz").write_bytes(b"no")
    with pytest.raises(FormatError, match="is no state space"):
        read_state_space(tmp_path / "bad.npz")


def test_what_is_predicted_is_read_back_in_any_unit_and_direction(rig: Rig, tmp_path: Path) -> None:
    records = {"one": np.arange(40.0).reshape(10, 4)}
    write_prediction(tmp_path / "p.h5", rig, records)
    assert np.array_equal(read_prediction(tmp_path / "p.h5", rig)["one"], records["one"])
    with h5py.File(tmp_path / "p.h5", "r+") as file:
        file.attrs["units"] = ["g"] * 10
        file.attrs["directions"] = ["-z"] * 10
    assert np.allclose(read_prediction(tmp_path / "p.h5", rig)["one"], -9.80665 * records["one"])
    with h5py.File(tmp_path / "p.h5", "r+") as file:
        file.attrs["channels"] = [f"b{k}" for k in range(10)]
    with pytest.raises(DataError, match="lacks a01"):
        read_prediction(tmp_path / "p.h5", rig)


def test_records_are_held_against_the_bench_without_a_fit(rig: Rig, heavy: Campaign, of_twin: dict[str, Array]) -> None:
    right = predict_records(made_diagnosis(rig, MASS), heavy)
    assert simulation_residual(heavy, right).gap == pytest.approx(1.0, abs=0.06)
    assert simulation_residual(heavy, of_twin).gap > 100
    with pytest.raises(DataError, match="none of the 1 predicted"):
        simulation_residual(heavy, {"another": right[ONE[0]]})


def test_a_simulation_of_the_wrong_shape_is_rejected(heavy: Campaign) -> None:
    with pytest.raises(DataError, match="the simulation gives"):
        simulated_records(lambda force, dt: force[:3], heavy, ONE)


def test_a_simulation_is_measured_with_the_noise_of_the_bench(
    rig: Rig, heavy: Campaign, of_twin: dict[str, Array]
) -> None:
    measured = simulation_as_measured(heavy, of_twin)
    first, own = measured.blocks[0], heavy.blocks[0]
    assert np.array_equal(first.samples[0], own.samples[0] * own.scale[0])
    assert np.std(first.samples[5, :80]) == pytest.approx(0.0003, rel=0.4)


@pytest.fixture(scope="module")
def compared(rig: Rig, few: Campaign, of_twin: dict[str, Array]) -> SimulationComparison:
    return compare_simulation(few, of_twin, made_diagnosis(rig, MASS))


def test_what_the_bench_has_and_the_simulation_lacks_is_named_with_how_far_it_shrinks(
    compared: SimulationComparison,
) -> None:
    assert compared.verdict == "known"
    assert [f.effect for f in compared.lacks] == ["added_mass"]
    assert (compared.has, compared.differs) == ([], [])
    assert compared.closed is not None
    assert compared.closed > 0.99
    assert "it lacks added mass (mass 0.050 kg" in sentence_of_simulation(compared)


def test_one_effect_in_two_sizes_differs(rig: Rig) -> None:
    lighter = MASS.model_copy(update={"parameters": {"mass": 0.03}})
    lacks, has, differs = differing_effects(made_diagnosis(rig, MASS), made_diagnosis(rig, lighter))
    assert (lacks, has, len(differs)) == ([], [], 1)
    assert differing_effects(made_diagnosis(rig, MASS), made_diagnosis(rig, MASS))[2] == []


def test_a_record_that_was_not_predicted_is_named(heavy: Campaign, of_twin: dict[str, Array]) -> None:
    with pytest.raises(DataError, match="29 of 30 records, not impact_p06_0"):
        compare_simulation(heavy, {k: v for k, v in of_twin.items() if k != "impact_p06_0"})


def test_the_page_shows_who_has_what(compared: SimulationComparison, tmp_path: Path) -> None:
    write_simulation_report(tmp_path / "s.html", compared)
    page = (tmp_path / "s.html").read_text(encoding="utf-8")
    assert "the bench alone" in page
    assert SimulationComparison.model_validate_json(compared.model_dump_json()) == compared


def test_export_at_the_terminal(rig: Rig, few: Campaign, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_rig(rig, tmp_path / "rig.yaml")
    write_campaign(few, tmp_path / "c.h5")
    (tmp_path / "d.json").write_text(made_diagnosis(rig, MASS).model_dump_json(), encoding="utf-8")
    asked = ["gap", "export", str(tmp_path / "d.json"), "--rig", str(tmp_path / "rig.yaml"), "--form", "uff", "--out"]
    more = ["--on", str(tmp_path / "c.h5"), "--test", "impact", "--records", "1", "--json", str(tmp_path / "f.json")]
    assert main([*asked, str(tmp_path / "t.uff"), *more]) == 0
    assert "noise units before" in capsys.readouterr().out
    assert FormError.model_validate_json((tmp_path / "f.json").read_text(encoding="utf-8")).after < 1.3
    assert main([*asked, str(tmp_path / "t.npz")]) != 0
    assert "ends in .uff" in capsys.readouterr().err


def test_what_cannot_be_exported_leaves_no_file(rig: Rig, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_rig(rig, tmp_path / "rig.yaml")
    (tmp_path / "d.json").write_text(made_diagnosis(rig, MASS).model_dump_json(), encoding="utf-8")
    out = tmp_path / "t.npz"
    asked = ["gap", "export", str(tmp_path / "d.json"), "--rig", str(tmp_path / "rig.yaml"), "--form", "npz"]
    asked += ["--out", str(out)]
    assert main([*asked, "--on", str(tmp_path / "nowhere")]) == 2
    assert "nowhere" in capsys.readouterr().err
    assert not out.exists()
    # Steps longer than half a period of the first mode show none.
    assert main([*asked, "--rate", "2"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "the rate of 2 Hz is too low" in said
    assert "give a rate well above" in said
    assert not out.exists()


LAWS = {
    "cubic_spring": Effect(effect="cubic_spring", parameters={"k3": 4e8}, place={"x": 0.8}),
    "clearance": Effect(effect="clearance", parameters={"k_contact": 3000.0, "gap": 2e-4}, place={"x": 0.0}),
}


@pytest.mark.thorough("runs MuJoCo in small steps")
@pytest.mark.parametrize("law", LAWS)
def test_mujoco_has_the_springs_that_depend_on_the_size_of_the_motion(rig: Rig, heavy: Campaign, law: str) -> None:
    diagnosis = made_diagnosis(rig, LAWS[law])
    hit = replace(heavy, blocks=tuple(b for b in heavy.blocks if b.name == ONE[0]))
    own = predict_records(diagnosis, hit)[ONE[0]]
    linear = predict_records(made_diagnosis(rig, verdict="no_gap"), hit)[ONE[0]]
    # What the law does is no small part of it.
    assert np.linalg.norm(linear - own) > 0.1 * np.linalg.norm(own)
    found = measure_form(FORMS["mjcf"], diagnosis, replace_responses(hit, {ONE[0]: own}), ["impact"], None)
    assert found.closed is not None
    assert found.closed > 0.95


def test_what_does_not_answer_in_proportion_has_no_linear_form(rig: Rig, tmp_path: Path) -> None:
    for form, suffix in (("npz", ".npz"), ("uff", ".uff")):
        with pytest.raises(DataError, match="is not linear"):
            write_form(
                tmp_path / f"t{suffix}", FORMS[form], made_diagnosis(rig, LAWS["cubic_spring"]), rig, ["impact"], None
            )
    friction = Effect(
        effect="clamp_friction", parameters={"k_stick": 5000.0, "k_slip": 2000.0, "moment_limit": 0.3}, place={"x": 0.0}
    )
    with pytest.raises(DataError, match="MuJoCo has no spring"):
        write_form(tmp_path / "t.xml", FORMS["mjcf"], made_diagnosis(rig, friction), rig, ["impact"], None)
