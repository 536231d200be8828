"""Two shakers on the simulated beam: FRFs as the finite-element twin has them, and one model from both references."""

import functools
import tempfile
from dataclasses import replace
from datetime import date
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from two_shakers import TIP, two_shakers

from modallab.acquisition.process.run import record_run
from modallab.bench.loader import open_bench
from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.hardware import Certificate
from modallab.core.model import ModalModel
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Rig
from modallab.core.units import Broadband
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.formats.exporter import write_export
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions
from modallab.formats.rig.rig_file import parse_rig
from modallab.frf.broadband import broadband_frf, driven_band
from modallab.frf.joined import joined_frf
from modallab.frf.periodic_drive import resample_blocks_to_drive_clock, without_decays
from modallab.gap.diagnosis import diagnose
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.model.modal_mass import with_scale
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import IdentifiedTest, identify_campaign
from modallab.signals.signals import Signals, to_signals, to_signals_of
from modallab.storage import Store
from modallab.storage.imported import keep_campaign
from modallab.twin.modes import solve_modes
from modallab.twin.structure import MODES, TwinStructure
from modallab_simulators.cantilever.beam import draw_damping
from modallab_simulators.cantilever.bench import CantileverBench

SEED = 1
URL = f"sim://cantilever?seed={SEED}"
TRUE_HZ = np.array([4.75495, 30.59341, 87.14636, 173.03204, 288.89950])
TRUE_DAMPING = np.array([0.0061389, 0.0060162, 0.0059400, 0.0049392, 0.0087534])
"""What the bench of this seed was built with."""
PARTS_T = 3.0
"""Student's t for the three degrees of freedom of four stretches, at 94 %."""


def link_rig() -> Rig:
    path = resources.files("modallab.cli") / "link_rig.yaml"
    return parse_rig(path.read_text(encoding="utf-8"), str(path))


@functools.cache
def rig_of(first: int, second: int) -> Rig:
    return two_shakers(link_rig().model_copy(update={"shaker_point": first}), point=second)


RIG = rig_of(4, 9)


@functools.cache
def recorded(
    signal: Broadband, shakers: str = "all", first: int = 4, second: int = 9, url: str = URL, blocks: int = 20
) -> Campaign:
    rig = rig_of(first, second)
    plan = BroadbandPlan.model_validate(
        {"signal": signal, "levels_v": {"low": 0.15}, "blocks": blocks, "shakers": shakers, "band_hz": (2.0, 400.0)}
    )
    with tempfile.TemporaryDirectory() as folder, Store(Path(folder) / "data") as store:
        bench = open_bench(url, rig)
        run = record_run(bench, rig, plan, store, lambda _: None)
        bench.close()
        return Campaign(rig, tuple(store.blocks(run)))


@functools.cache
def identified(
    signal: Broadband, shakers: str = "all", first: int = 4, second: int = 9, blocks: int = 20
) -> IdentifiedTest:
    return identify_campaign(
        recorded(signal, shakers, first, second, blocks=blocks), IdentificationOptions()
    ).identified[0]


def of_twin(frf: Frf) -> np.ndarray:
    """(outputs, inputs, lines) inertance of a finite-element beam of the true bench's stiffness, mass and damping."""
    bench = open_bench(URL, RIG)
    assert isinstance(bench, CantileverBench)
    true = bench.truth.true
    bench.close()
    assert RIG.beam is not None
    believed = {name: getattr(true, name) for name in ("youngs_modulus_pa", "thickness_m", "density_kg_m3")}
    structure = TwinStructure.of(RIG.beam.model_copy(update=believed), 0.01)
    modes = solve_modes(replace(structure, zeta=draw_damping(SEED, MODES, ())))
    s = 2j * np.pi * frf.frequency_hz
    seen = np.array([RIG.x_of(point) for point in frf.output_points if point is not None])
    columns = []
    for point in frf.input_points:
        assert point is not None
        shares = modes.shapes_at(seen) * modes.shapes_at(RIG.x_of(point))
        own, mirrored = (
            residues[:, :, None] / (s - poles[:, None])
            for residues, poles in ((shares, modes.poles), (shares.conj(), modes.poles.conj()))
        )
        columns.append((own + mirrored).sum(axis=1) + modes.remainder(seen, RIG.x_of(point))[:, None])
    return np.stack(columns, axis=1) * s**2


def settled(signal: Broadband) -> list[Signals]:
    signals = to_signals_of(recorded(signal).blocks, RIG)
    band = driven_band(signals)
    signals = resample_blocks_to_drive_clock(signals, band)
    return without_decays(signals, poles_of(2 * np.pi * TRUE_HZ, TRUE_DAMPING), band)


AGAIN = pytest.mark.thorough("records and identifies with two shakers again")


@pytest.mark.parametrize("signal", ["pseudo-random", pytest.param("chirp", marks=AGAIN)])
def test_all_frfs_of_a_periodic_drive_are_the_twins_within_their_noise(signal: Broadband) -> None:
    """Both forces with their signs and units: one is read in lbf, against the drive, in the midst of the channels."""
    signals = settled(signal)
    frf = broadband_frf(signals, RIG, driven_band(signals))
    assert frf.values.shape[:2] == (10, 2)
    assert frf.input_points == (4, 9)
    assert frf.variance is not None
    square = np.abs(frf.values - of_twin(frf)) ** 2 / frf.variance
    assert square.mean() == pytest.approx(1.0, abs=0.35)
    # A complex number's square over its variance is exponential.
    assert np.median(square) == pytest.approx(np.log(2), rel=0.25)
    # Each of the twenty FRFs, none of which has another sign or unit.
    assert square.mean(axis=2).max() < 2


@AGAIN
@pytest.mark.parametrize("signal", ["random", "burst-random"])
def test_all_frfs_of_a_random_drive_are_the_twins(signal: Broadband) -> None:
    signals = to_signals_of(recorded(signal).blocks, RIG)
    frf = joined_frf(signals, RIG, driven_band(signals))
    assert frf.input_points == (4, 9)
    assert frf.variance is not None
    square = np.abs(frf.values - of_twin(frf)) ** 2 / frf.variance
    # The variance is that of a line's own noise: the polynomials, which average over lines, have less.
    assert 0.2 < np.median(square) < np.log(2)


def test_multiple_coherence_is_what_all_forces_explain() -> None:
    """By one force alone a response is explained in part: by both, but for its noise, whole."""
    signals = settled("pseudo-random")
    both = broadband_frf(signals, RIG, (10.0, 390.0)).coherence
    assert both is not None
    assert np.median(both) > 0.999
    alone = broadband_frf([replace(s, forces=s.forces[0]) for s in signals], RIG, (10.0, 390.0)).coherence
    assert alone is not None
    assert np.median(alone) < 0.8


@AGAIN
@pytest.mark.parametrize("signal", ["pseudo-random", "random"])
def test_the_model_of_both_references_is_the_benchs(signal: Broadband) -> None:
    found = identified(signal)
    model = found.model
    assert model.input_points == (4, 9)
    np.testing.assert_allclose(model.frequency_hz[:5], TRUE_HZ, rtol=2e-4)
    np.testing.assert_allclose(model.damping_ratio[1:5], TRUE_DAMPING[1:], rtol=0.02)
    assert found.assessment is not None
    verdicts = {v.assumption: v.holds for v in found.assessment.verdicts}
    assert verdicts["reciprocity"]
    assert verdicts["driving point"]


@AGAIN
def test_what_still_fades_from_the_start_of_each_wave_is_no_change_of_the_structure() -> None:
    """The lowest mode of this bench rings for ten seconds: the first half of every wave holds more of it."""
    campaign = recorded("pseudo-random", url="sim://cantilever?seed=0", blocks=16)
    assessment = identify_campaign(campaign, IdentificationOptions()).identified[0].assessment
    assert assessment is not None
    assert next(v for v in assessment.verdicts if v.assumption == "time invariance").value < 0.02


@AGAIN
def test_both_shakers_find_the_modes_that_one_finds_within_what_both_state() -> None:
    one, both = identified("pseudo-random", "first").model, identified("pseudo-random").model
    assert one.input_points == (4,)
    for name, sigma in (("frequency_hz", "frequency_sigma_hz"), ("damping_ratio", "damping_sigma")):
        joint = np.hypot(getattr(one, sigma)[:5], getattr(both, sigma)[:5])
        apart = np.abs(getattr(one, name)[:5] - getattr(both, name)[:5])
        assert np.all(apart < PARTS_T * joint), name


@AGAIN
def test_what_one_shaker_hardly_sees_the_other_does() -> None:
    """Near a node of mode 3 stands the first, near one of mode 2 the second: each alone knows that mode worse."""
    both = identified("pseudo-random", "all", 5, 8, 10).model
    from_5 = identified("pseudo-random", "first", 5, 8, 10).model
    from_8 = identified("pseudo-random", "first", 8, 5, 10).model
    # Mode 3 from point 5 alone, mode 2 from point 8 alone.
    assert participation(from_5)[2] < 0.2 < 0.45 < participation(both)[2]
    assert participation(from_8)[1] < 0.2 < 0.45 < participation(both)[1]
    assert both.damping_sigma[1] < 0.5 * from_8.damping_sigma[1]
    for model in (from_5, from_8, both):
        np.testing.assert_allclose(model.frequency_hz[:5], TRUE_HZ, rtol=1e-4)


def participation(model: ModalModel) -> np.ndarray:
    """(modes,) size of the best driven constant of each mode, over that of the mode's largest in the shape."""
    constants = np.abs(np.array(model.modal_constants))
    return np.array([c.max() for c in constants]) / np.abs(constants).max()


def test_records_of_several_forces_are_kept_in_files_and_in_the_store(tmp_path: Path) -> None:
    campaign = recorded("pseudo-random")
    write_campaign(campaign, tmp_path / "two.h5")
    read = read_campaign(tmp_path / "two.h5", RIG)
    assert [b.driven_points for b in read.blocks] == [(4, 9)] * 20
    with Store(tmp_path / "data") as store:
        runs = keep_campaign(store, read, "import://two.h5")
        kept = [block for run in runs for block in store.blocks(run)]
        plan = store.catalogue.run(runs[0]).plan
    assert [b.driven_points for b in kept] == [(4, 9)] * 20
    assert isinstance(plan, BroadbandPlan)
    assert plan.shakers == "all"
    for one, other in zip(campaign.blocks, kept, strict=True):
        np.testing.assert_array_equal(to_signals(one, RIG).forces, to_signals(other, RIG).forces)


@AGAIN
def test_what_knows_one_force_says_so(tmp_path: Path) -> None:
    """None of it takes the record for one that the first shaker drove alone."""
    campaign = recorded("pseudo-random")
    with pytest.raises(DataError, match="the points 4 and 9 were driven at the same time"):
        _ = to_signals(campaign.blocks[0], RIG).force
    with pytest.raises(DataError, match="a record in uff names one point of one force"):
        write_export(campaign, tmp_path / "two.uff", "uff")
    with pytest.raises(DataError, match="the rig has 2 force channels, and a diagnosis models one force only"):
        diagnose(campaign)
    model = identified("pseudo-random").model
    with pytest.raises(DataError, match="2 shakers drove the bench at once, and a comparison knows the gain of one"):
        diagnose_by_model(model, model, RIG)
    one_shaker = [replace(b, also_driven=()) for b in campaign.blocks]
    write_export(replace(campaign, blocks=tuple(one_shaker)), tmp_path / "one.uff", "uff")
    with pytest.raises(DataError, match="no time record for channel force_tip"):
        import_sources([tmp_path / "one.uff"], RIG, ImportOptions(test="pseudo-random", volts=True))
    mixed = to_signals_of([*campaign.blocks[:4], *one_shaker[4:8]], RIG)
    with pytest.raises(DataError, match="driven at other points"):
        broadband_frf(mixed, RIG, (10.0, 300.0))
    with pytest.raises(DataError, match="driven at other points"):
        identify_campaign(replace(campaign, blocks=(*campaign.blocks[:8], *one_shaker[8:])), IdentificationOptions())
    with pytest.raises(DataError, match="3 forces drove, and the rig has 2 force channels"):
        to_signals(replace(campaign.blocks[0], also_driven=(9, 2)), RIG)


@AGAIN
def test_the_scale_is_as_uncertain_as_the_least_certain_force() -> None:
    certificates = {
        c.name: Certificate(serial=c.serial, date=date(2026, 1, 1), uncertainty_percent=2.0 if c.name == TIP else 0.5)
        for c in RIG.forces
    }
    channels = tuple(c.model_copy(update={"certificate": certificates.get(c.name)}) for c in RIG.channels)
    rig = RIG.model_copy(update={"channels": channels})
    both = with_scale(identified("pseudo-random").model, rig).scale_uncertainty
    one = with_scale(identified("pseudo-random", "first").model, rig).scale_uncertainty
    assert both is not None
    assert one is not None
    assert both.force == pytest.approx(0.01)
    assert one.force == pytest.approx(0.0025)
