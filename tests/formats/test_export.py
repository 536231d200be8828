"""Exports, read by programs of others and by our own import, bit for bit where the format holds bits."""

import json
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import nptdms
import numpy as np
import pytest
import pyuff
from exchange_records import block, campaign, counts, hit
from exchange_rigs import beam_content, beam_rig, plain_rig
from hypothesis import given, settings
from hypothesis import strategies as st
from sdypy_sep005 import Sep005Data

from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.csv.csv_frf import read_csv_modes
from modallab.formats.exporter import write_export
from modallab.formats.importer import import_sources
from modallab.formats.modes import ModeShapes
from modallab.formats.rig.rig_file import read_rig
from modallab.formats.sep005.sep005 import to_sep005
from modallab.formats.uff.uff_shapes import read_uff_shapes

RIG = beam_rig()
NAMES: dict[str, str] = {"hdf5": "c.h5", "uff": "c.uff", "csv": "c", "sep005": "c.json", "tdms": "c.tdms"}
FORMATS = list(NAMES)
ODD_HZ = 1651.6129032258063


def session() -> Campaign:
    """Two hits in counts, one with an odd rate in real numbers, and a sine block."""
    sine = {
        "test": "sine",
        "level": "low  – drive",
        "frequency_hz": 105.46875,
        "drive_point": 2,
        "order": 3,
    }
    real = {"scale": np.ones(4), "units": ("N", "m/s^2", "m/s^2", "m/s^2"), "rate_hz": ODD_HZ, "order": 2}
    return campaign(
        RIG,
        block(RIG, counts(RIG, 1), name="impact_p01_1", drive_point=1, first_sample=2**40),
        block(RIG, counts(RIG, 2).astype(np.int32), name="impact_p03_1", drive_point=3, order=1),
        block(RIG, hit(4, seed=3).astype(np.float32), name="impact_p02_1", drive_point=2, **real),
        block(RIG, hit(4, seed=4), name="sine_low_01", **sine),
    )


def frf(points: Sequence[int] = (1, 2)) -> Frf:
    rng = np.random.default_rng(5)
    shape = (3, len(points), 40)
    return Frf(
        frequency_hz=np.arange(3, 43) / 1.024,
        # As estimators leave it: lines on the first axis in memory.
        values=np.asfortranarray(rng.normal(size=shape) + 1j * rng.normal(size=shape)),
        quantity="mobility",
        outputs=("a01", "a02", "a03"),
        output_points=(1, 2, 3),
        input_points=tuple(points),
        coherence=rng.uniform(0.5, 1, shape),
    )


def model(*, is_complex: bool = False) -> ModalModel:
    shapes = np.array([[0.1, 0.4, 1.2], [0.3, -0.5, 0.9]]) + (0.25j if is_complex else 0)
    n = np.full(2, 1e-3)
    constants = shapes[:, :, None] * shapes[:, None, :]
    return ModalModel(
        method="plscf",
        test="impact",
        band_hz=(2.0, 60.0),
        frequency_hz=np.array([4.75497, 30.5944]),
        damping_ratio=np.array([0.0061, 0.006]),
        frequency_sigma_hz=n,
        damping_sigma=n,
        outputs=("a01", "a02", "a03"),
        output_points=(1, 2, 3),
        input_points=(1, 2, 3),
        modal_constants=constants,
        modal_constant_sigma=np.abs(constants),
        residuals=np.zeros((0, 3, 3)),
        shapes=shapes,
        half_power=n,
        half_power_floor=n,
    )


def written(content: Campaign, format_: str, folder: Path, *models: ModalModel) -> Path:
    out = folder / NAMES[format_]
    write_export(content, out, format_, models)
    return out


def back(out: Path) -> Campaign:
    if not out.is_dir():
        return import_sources([out], RIG)
    files = sorted(path for path in out.glob("*.csv") if path.name.startswith(("impact", "sine")))
    return import_sources(files, read_rig(out / "rig.yaml"))


def physical(one: Block) -> np.ndarray:
    return one.samples.astype(np.float64) * one.scale[:, None]


@pytest.mark.parametrize("format_", FORMATS)
def test_every_record_comes_back_with_the_same_numbers_and_facts(format_: str, tmp_path: Path) -> None:
    source = session()
    found = {one.name: one for one in back(written(source, format_, tmp_path)).blocks}
    assert set(found) == {one.name for one in source.blocks}
    for one in source.blocks:
        other = found[one.name]
        np.testing.assert_array_equal(physical(other), physical(one))
        for field in ("test", "rate_hz", "units", "channels", "drive_point", "level", "frequency_hz", "first_sample"):
            assert getattr(other, field) == getattr(one, field), field


@pytest.mark.parametrize("format_", ["hdf5", "tdms"])
def test_counts_stay_counts(format_: str, tmp_path: Path) -> None:
    source = session()
    for one, other in zip(source.blocks, back(written(source, format_, tmp_path)).blocks, strict=True):
        assert other.samples.dtype == one.samples.dtype
        assert other.samples.tobytes() == one.samples.tobytes()
        np.testing.assert_array_equal(other.scale, one.scale)


@pytest.mark.parametrize("format_", ["hdf5", "uff", "csv"])
def test_frfs_come_back_bit_for_bit_with_their_coherence(format_: str, tmp_path: Path) -> None:
    source = Campaign(RIG, (), (frf(),))
    out = written(source, format_, tmp_path)
    (found,) = back(out / "frf_1.csv" if format_ == "csv" else out).frfs
    np.testing.assert_array_equal(found.values, frf().values)
    np.testing.assert_array_equal(found.coherence, frf().coherence)
    np.testing.assert_allclose(found.frequency_hz, frf().frequency_hz, rtol=1e-15)
    assert (found.quantity, found.outputs, found.input_points) == ("mobility", ("a01", "a02", "a03"), (1, 2))
    assert found.output_points == (1, 2, 3)


def test_a_table_of_frfs_that_is_not_whole_is_rejected(tmp_path: Path) -> None:
    path = written(Campaign(RIG, (), (frf(),)), "csv", tmp_path) / "frf_1.csv"
    text = path.read_text(encoding="utf-8")
    for old, new, said in (
        ("# mobility", "# motion", "none of an FRF"),
        ("im a02/p2", "im a09/p2", "a09 is no response channel"),
        ("im a02/p2", "im a02/p9", "no column 're a01/p9'"),
        ("re a01/p1", "a01", "column 'a01' is none of an FRF"),
    ):
        path.write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(ModallabError, match=said):
            back(path)


def test_another_program_reads_the_universal_file(tmp_path: Path) -> None:
    """pyuff, of which the writer uses nothing: header, nodes, records, FRFs, coherence and shapes."""
    out = written(replace(session(), frfs=(frf(),)), "uff", tmp_path, model())
    file = pyuff.UFF(str(out))
    types = [int(kind) for kind in file.get_set_types()]
    assert types == [151, 164, 15, *[58] * (4 * 4 + 12), 55, 55]
    sets = [file.read_sets(n) for n in range(len(types))]
    assert sets[0]["model_name"].strip() == "elastic link"
    assert sets[1]["units_code"] == 1
    np.testing.assert_allclose(sets[2]["x"], [0.295667, 0.591333, 0.887], rtol=1e-5)
    first = session().blocks[0]
    for n in range(4):
        assert sets[3 + n]["func_type"] == 1
        np.testing.assert_array_equal(sets[3 + n]["data"], physical(first)[n])
        assert sets[3 + n]["ordinate_axis_units_lab"].strip() == "V"
        assert sets[3 + n]["abscissa_inc"] == pytest.approx(1 / 2000, rel=1e-5)
    assert (sets[4]["rsp_node"], sets[4]["rsp_dir"], sets[4]["ref_node"]) == (1, 3, 1)
    mobility = [s for s in sets if s.get("func_type") == 4]
    np.testing.assert_array_equal(mobility[1]["data"], frf().values[0, 1])
    np.testing.assert_array_equal(mobility[1]["x"], frf().frequency_hz)
    assert (mobility[1]["rsp_node"], mobility[1]["ref_node"]) == (1, 2)
    shape = sets[-1]
    assert (shape["analysis_type"], shape["mode_n"]) == (2, 2)
    assert shape["freq"] == pytest.approx(30.5944, rel=1e-5)
    assert shape["modal_damp_vis"] == pytest.approx(0.006, rel=1e-5)
    np.testing.assert_array_equal(shape["node_nums"], [1, 2, 3])
    np.testing.assert_allclose(shape["r3"], [0.3, -0.5, 0.9])


def test_complex_shapes_carry_their_pole(tmp_path: Path) -> None:
    file = pyuff.UFF(str(written(session(), "uff", tmp_path, model(is_complex=True))))
    shape = file.read_sets(len(file.get_set_types()) - 2)
    pole = shape["eig"]
    assert abs(pole) / (2 * np.pi) == pytest.approx(4.75497, rel=1e-5)
    assert -pole.real / abs(pole) == pytest.approx(0.0061, rel=1e-4)
    assert shape["modal_a"] == pytest.approx(2j * pole.imag, rel=1e-5)
    np.testing.assert_allclose(shape["r3"], [0.1 + 0.25j, 0.4 + 0.25j, 1.2 + 0.25j])


@pytest.mark.parametrize("is_complex", [False, True])
def test_modes_come_back_from_a_universal_file_with_its_six_digits(is_complex: bool, tmp_path: Path) -> None:
    source = model(is_complex=is_complex)
    out = written(session(), "uff", tmp_path, source, source.model_copy(update={"test": "sine"}))
    found = read_uff_shapes(out, RIG)
    assert [one.title for one in found] == ["elastic link, impact, plscf", "elastic link, sine, plscf"]
    for one in found:
        _same_modes(one, source, rtol=1e-5)
        np.testing.assert_allclose(one.modal_mass_kg, 1.0, rtol=1e-5)
    assert read_uff_shapes(written(session(), "uff", tmp_path), RIG) == ()


def test_modes_come_back_from_a_table_bit_for_bit(tmp_path: Path) -> None:
    source = model(is_complex=True)
    found = read_csv_modes(written(session(), "csv", tmp_path, source) / "modes_impact.csv", RIG)
    _same_modes(found, source, rtol=0)
    assert found.title == "plscf"
    with pytest.raises(FormatError, match="none of a table of modes"):
        read_csv_modes(tmp_path / "c" / "impact_p01_1.csv", RIG)


def _same_modes(found: ModeShapes, source: ModalModel, rtol: float) -> None:
    assert source.shapes is not None
    assert (found.outputs, found.output_points) == (source.outputs, source.output_points)
    np.testing.assert_allclose(found.frequency_hz, source.frequency_hz, rtol=rtol)
    np.testing.assert_allclose(found.damping_ratio, source.damping_ratio, rtol=10 * rtol)
    np.testing.assert_allclose(found.shapes, source.shapes, rtol=rtol)


def test_shapes_follow_the_sense_of_the_channels_and_must_stand_where_the_rig_does(tmp_path: Path) -> None:
    out = written(session(), "uff", tmp_path, model())
    turned = RIG.model_copy(
        update={
            "channels": tuple(c.model_copy(update={"direction": "-z"}) if c.name == "a02" else c for c in RIG.channels)
        }
    )
    # Readings of a sensor mounted against the drive have been turned, and so are the shapes.
    (found,) = read_uff_shapes(out, turned)
    np.testing.assert_allclose(found.shapes, model().shapes, rtol=1e-5)
    (tmp_path / "turned").mkdir()
    of_turned = written(replace(session(), rig=turned), "uff", tmp_path / "turned", model())
    r3 = [[one["r3"] for one in pyuff.UFF(str(path)).read_sets() if one["type"] == 55] for path in (out, of_turned)]
    np.testing.assert_allclose(*r3, rtol=1e-5)
    moved = RIG.model_copy(
        update={"points": tuple(p.model_copy(update={"x_m": p.x_m + 0.01 * (p.id == 3)}) for p in RIG.points)}
    )
    with pytest.raises(DataError, match=r"nodes 1 and 3 are 0\.591333 m apart, the rig's points 0\.601333 m"):
        read_uff_shapes(out, moved)
    # Another origin is the same bench.
    shifted = RIG.model_copy(update={"points": tuple(p.model_copy(update={"x_m": p.x_m - 0.1}) for p in RIG.points)})
    assert len(read_uff_shapes(out, shifted)) == 1


def test_shapes_of_another_program_are_read_with_their_modal_mass(tmp_path: Path) -> None:
    """As pyuff writes them: a normal mode of 4 kg, and a forced response that is no mode."""
    path = tmp_path / "other.uff"
    file = pyuff.UFF(str(path))
    for mode, analysis in ((1, 2), (2, 5)):
        file.write_sets(_shape_of_pyuff(mode, analysis), "add")
    (found,) = read_uff_shapes(path, RIG)
    assert (found.title, found.modal_mass_kg.tolist()) == ("other bench", [4.0])
    assert found.frequency_hz == pytest.approx([12.5])
    assert found.damping_ratio == pytest.approx([0.02])
    np.testing.assert_allclose(found.shapes, [[0.5, -1.0, 2.0]])


def _shape_of_pyuff(mode: int, analysis: int) -> dict[str, object]:
    zeros = np.zeros(3)
    return pyuff.prepare_55(
        model_type=1, id1="other bench", id2="NONE", id3="NONE", id4="NONE", id5="NONE",
        analysis_type=analysis, data_ch=2, spec_data_type=8, data_type=2,
        r1=zeros, r2=zeros, r3=np.array([0.5, -1.0, 2.0]), n_data_per_node=3, node_nums=np.array([1, 2, 3]),
        load_case=1, mode_n=mode, freq=12.5, modal_m=4.0, modal_damp_vis=0.02, modal_damp_his=0.0, freq_step_n=1,
    )  # fmt: skip


def test_another_program_reads_the_tdms_file_in_units_and_in_counts(tmp_path: Path) -> None:
    """npTDMS, of which the writer uses nothing."""
    source = session()
    file = nptdms.TdmsFile.read(written(source, "tdms", tmp_path))
    assert [group.name for group in file.groups()] == [one.name for one in source.blocks]
    for one in source.blocks:
        for n, name in enumerate(one.channels):
            channel = file[one.name][name]
            np.testing.assert_array_equal(channel.read_data(scaled=False), one.samples[n])
            np.testing.assert_array_equal(channel[:], physical(one)[n])
            assert channel.properties["unit_string"] == one.units[n]
            assert channel.time_track()[1] == pytest.approx(1 / one.rate_hz, rel=1e-12)


def test_tdms_of_another_program_is_imported(tmp_path: Path) -> None:
    """As npTDMS writes it: samples in two segments, channels in another order, no remark of ours."""
    samples = hit(4)
    path = tmp_path / "other.tdms"
    with nptdms.TdmsWriter(path) as out:
        for half in (slice(0, 100), slice(100, 256)):
            rows = [
                nptdms.ChannelObject(
                    "hit", c.name, samples[c.index, half], {"wf_increment": 5e-4, "unit_string": c.unit}
                )
                for c in reversed(RIG.channels)
            ]
            out.write_segment(rows)
    (found,) = import_sources([path], RIG).blocks
    np.testing.assert_array_equal(found.samples, samples)
    assert (found.name, found.rate_hz, found.units) == ("hit", 2000.0, ("N", "m/s^2", "m/s^2", "m/s^2"))


def test_series_are_what_sep005_demands(tmp_path: Path) -> None:
    """By the checker of those who wrote the proposal."""
    series = to_sep005(session())
    assert len(series) == 16
    for one in (*series, *json.loads(written(session(), "sep005", tmp_path).read_text(encoding="utf-8"))):
        checked = Sep005Data.model_validate(one)
        assert checked.fs in (2000.0, ODD_HZ)
    assert [one.get("quantity") for one in series[8:12]] == ["f", "a", "a", "a"]


def test_a_table_of_csv_is_plain_numbers_with_units(tmp_path: Path) -> None:
    out = written(replace(session(), frfs=(frf(),)), "csv", tmp_path, model())
    assert sorted(path.name for path in out.iterdir()) == [
        "frf_1.csv",
        "impact_p01_1.csv",
        "impact_p02_1.csv",
        "impact_p03_1.csv",
        "modes_impact.csv",
        "rig.yaml",
        "sine_low_01.csv",
    ]
    lines = (out / "impact_p01_1.csv").read_text(encoding="utf-8").splitlines()
    assert lines[1] == "time [s],force [V],a01 [V],a02 [V],a03 [V]"
    table = np.genfromtxt(out / "modes_impact.csv", delimiter=",", skip_header=2)
    np.testing.assert_array_equal(table[:, 0], model().frequency_hz)
    np.testing.assert_array_equal(table[:, 6], model().shapes[:, 1].real)
    table = np.genfromtxt(out / "frf_1.csv", delimiter=",", skip_header=2)
    np.testing.assert_array_equal(table[:, 1] + 1j * table[:, 2], frf().values[0, 0])


def test_what_has_no_place_is_reported(tmp_path: Path) -> None:
    both = replace(session(), frfs=(frf(),))
    reported = write_export(both, tmp_path / "c.tdms", "tdms", [model()])
    assert reported == (
        "tdms holds time records only; FRFs were left out",
        "tdms has no place for modal models; they were left out",
    )
    with pytest.raises(DataError, match="no time records"):
        write_export(Campaign(RIG, (), (frf(),)), tmp_path / "c.json", "sep005")
    with pytest.raises(DataError, match="too long for a universal file"):
        write_export(campaign(RIG, block(RIG, counts(RIG), name="n" * 120)), tmp_path / "c.uff", "uff")
    assert not (tmp_path / "c.uff").exists()
    without = model().model_copy(update={"shapes": None, "shapes_unavailable": "one sensor"})
    with pytest.raises(DataError, match="has no shapes: one sensor"):
        write_export(session(), tmp_path / "c.uff", "uff", [without])


def test_a_remark_that_contradicts_the_times_is_rejected(tmp_path: Path) -> None:
    out = written(session(), "csv", tmp_path)
    path = out / "impact_p01_1.csv"
    path.write_text(path.read_text(encoding="utf-8").replace('"rate_hz":2000.0', '"rate_hz":1999.0'), encoding="utf-8")
    with pytest.raises(FormatError, match="its remark says 1999 Hz, its times 2000 Hz"):
        back(out)
    path.write_text(path.read_text(encoding="utf-8").replace('"test":"impact"', '"test":"dance"'), encoding="utf-8")
    with pytest.raises(FormatError, match="is damaged"):
        back(out)


@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_a_damaged_tdms_file_is_an_error_or_other_numbers_never_a_crash(data: st.DataObject, tmp_path_factory) -> None:
    folder = tmp_path_factory.mktemp("tdms")
    rig = plain_rig()
    path = written(campaign(rig, block(rig, counts(rig)[:, :8])), "tdms", folder)
    content = bytearray(path.read_bytes())
    if data.draw(st.booleans()):
        path.write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
        with pytest.raises(ModallabError):
            import_sources([path], rig)
        return
    content[data.draw(st.integers(0, len(content) - 1))] ^= data.draw(st.integers(1, 255))
    path.write_bytes(content)
    with suppress(ModallabError):
        # TDMS has no checksums: a changed sample is another number, a changed structure an expected error.
        assert import_sources([path], rig).blocks[0].channels == ("force", "acceleration")


def test_a_tdms_file_that_announces_more_scales_than_it_has_bytes_is_rejected(tmp_path: Path) -> None:
    rig = plain_rig()
    path = written(campaign(rig, block(rig, counts(rig)[:, :8])), "tdms", tmp_path)
    with nptdms.TdmsFile.open(path) as found:
        objects = [
            nptdms.ChannelObject(c.group_name, c.name, c[:], c.properties) for g in found.groups() for c in g.channels()
        ]
    objects[0].properties["NI_Number_Of_Scales"] = 2**30
    with nptdms.TdmsWriter(path) as out:
        out.write_segment(objects)
    with pytest.raises(FormatError, match="announces 1073741824 scales"):
        import_sources([path], rig)


def test_a_campaign_of_hdf5_is_the_campaign(tmp_path: Path) -> None:
    source = replace(session(), frfs=(frf(),), provenance={"seed": "7"})
    found = read_campaign(written(source, "hdf5", tmp_path))
    assert found.provenance == {"seed": "7"}
    assert found.rig == RIG
    assert beam_content()["name"] == found.rig.name
