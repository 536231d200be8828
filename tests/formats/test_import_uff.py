"""Universal files: time records and FRFs, as text and binary, by node and direction."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from exchange_records import DATA, RATE_HZ, hit, receptances, times, uff_set, write_hit_uff, write_uff
from exchange_rigs import beam_rig, plain_rig

from modallab.core.errors import DataError, FormatError, ModallabError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.formats.importer import import_sources
from modallab.formats.options import ImportOptions
from modallab.formats.uff.uff_functions import read_functions

RIG = beam_rig()
LINES = np.arange(1.0, 65.0)


def rejected(kind: type[ModallabError], path: Path, rig: Rig = RIG) -> str:
    with pytest.raises(kind) as caught:
        import_sources([path], rig)
    assert str(path) in str(caught.value)
    assert caught.value.remedy
    return str(caught.value)


def frf_sets(kind: int = 4, node: int = 2, direction: int = 3, **fields: Any) -> list[dict[str, Any]]:
    return [
        uff_set(
            values,
            LINES,
            kind,
            rsp_node=k,
            rsp_dir=3,
            ref_node=node,
            ref_dir=direction,
            **({"ordinate_spec_data_type": 8, "ordinate_axis_units_lab": "m"} | fields),
        )
        for k, values in enumerate(receptances(), start=1)
    ]


def read_frf(path: Path, rig: Rig = RIG) -> Frf:
    (frf,) = import_sources([path], rig).frfs
    return frf


def test_an_analysers_binary_file_reads_as_recorded() -> None:
    first, second = read_functions(DATA / "analyser_58b.uff").functions
    assert (first.node, first.direction, first.unit, first.kind) == (1, 3, "m/s^2", 1)
    assert (second.node, len(second.values)) == (2, 1024)
    single = [0.08014834, 0.00711253, 0.08974795]
    np.testing.assert_allclose(first.values[:3], single, rtol=1e-6)
    assert first.values[-1] == np.float32(0.05160994827747345)


def test_an_analysers_text_file_reads_as_written() -> None:
    (function,) = read_functions(DATA / "analyser_58.uff").functions
    assert function.values[:3].tolist() == [-1.47553e-02, -1.72957e-02, -1.66101e-02]
    assert (len(function.values), function.unit, function.names[0]) == (603, "Pa", "Mic 01")


def test_what_is_measured_without_force_or_on_no_channel_is_reported() -> None:
    assert "no time record for channel force beside sets 1, 2" in rejected(
        DataError, DATA / "analyser_58b.uff", plain_rig("1+Z", "2+Z")
    )
    message = rejected(DataError, DATA / "analyser_58.uff")
    assert "set 1, 'Mic 01.0Scalar' in 'Pa', without a node, is no single channel of the rig" in message


@pytest.mark.parametrize("binary", [False, True])
def test_time_records_find_their_channels_by_node_and_direction(tmp_path: Path, binary: bool) -> None:
    samples = hit(4)
    path = write_hit_uff(tmp_path / "hit_1.uff", samples[[0, 1, 2, 3]], binary=binary, force_node=2)
    (block,) = import_sources([path], RIG).blocks
    assert (block.name, block.rate_hz, block.drive_point) == ("hit_1", RATE_HZ, 2)
    assert block.units == ("N", "m/s^2", "m/s^2", "m/s^2")
    np.testing.assert_allclose(block.samples, samples, rtol=1e-10)


def test_an_opposite_direction_turns_the_sign(tmp_path: Path) -> None:
    samples = hit(2)
    force = uff_set(samples[0], times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="N")
    path = write_uff(
        tmp_path / "a.uff", force, *(uff_set(samples[1] * k, times(), 1, rsp_node=k, rsp_dir=-3) for k in (1, 2, 3))
    )
    (block,) = import_sources([path], RIG).blocks
    assert block.scale.tolist() == [1.0, -1.0, -1.0, -1.0]


@pytest.mark.parametrize("apart", [True, False])
def test_a_channel_that_comes_again_is_of_the_next_hit(tmp_path: Path, apart: bool) -> None:
    sets = []
    for seed in (1, 2, 3):
        force, response = hit(2, seed=seed)
        sets.append(uff_set(force, times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="N"))
        sets.append(uff_set(response, times(), 1))
    sets = sets if apart else [*sets[::2], *sets[1::2]]
    campaign = import_sources([write_uff(tmp_path / "hits.uff", *sets)], plain_rig())
    assert [(b.name, b.order) for b in campaign.blocks] == [("hits_1", 0), ("hits_2", 1), ("hits_3", 2)]
    np.testing.assert_allclose(campaign.blocks[2].samples, hit(2, seed=3), rtol=1e-10)


def test_channels_are_found_by_name_before_anything_else(tmp_path: Path) -> None:
    force, *rest = hit(4)
    sets = [uff_set(force, times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="lbf")]
    sets += [uff_set(row, times(), 1, rsp_ent_name=name) for row, name in zip(rest, ("A03", "A02", "A01"), strict=True)]
    (block,) = import_sources([write_uff(tmp_path / "a.uff", *sets)], RIG).blocks
    np.testing.assert_allclose(block.samples, [force, *rest[::-1]], rtol=1e-10)
    assert block.units[0] == "lbf"


def test_a_unit_is_taken_from_the_label_else_from_what_it_measures_in_si(tmp_path: Path) -> None:
    force, response = hit(2)
    sets = [
        uff_set(force, times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="NONE"),
        uff_set(response, times(), 1, ordinate_axis_units_lab="G"),
    ]
    (block,) = import_sources([write_uff(tmp_path / "a.uff", *sets)], plain_rig()).blocks
    assert block.units == ("N", "g")


@pytest.mark.parametrize(
    ("code", "length", "force", "unit"), [(5, 1e3, 1e3, "mN"), (7, 39.37008, 0.2248089, "lbf"), (9, 1.0, 1e-3, "kN")]
)
def test_without_a_label_the_units_of_dataset_164_count(
    tmp_path: Path, code: int, length: float, force: float, unit: str
) -> None:
    rows = hit(2)
    sets = [
        uff_set(rows[0], times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="NONE"),
        uff_set(rows[1], times(), 1, ordinate_axis_units_lab="g"),
    ]
    units = {"type": 164, "units_code": code, "length": length, "force": force}
    (block,) = import_sources([write_uff(tmp_path / "a.uff", units, *sets)], plain_rig()).blocks
    assert block.units == (unit, "g")
    message = rejected(DataError, write_uff(tmp_path / "b.uff", units | {"units_code": 2}, *sets), plain_rig())
    assert f"set 2 has no unit label, and dataset 164 says no unit of force: code 2, {length:g} to a metre" in message


def test_frfs_at_uneven_lines_keep_their_lines(tmp_path: Path) -> None:
    lines = np.geomspace(10, 90, 64)
    sets = [content | {"x": lines, "abscissa_spacing": 0} for content in frf_sets()]
    frf = read_frf(write_uff(tmp_path / "frf.uff", *sets))
    np.testing.assert_allclose(frf.frequency_hz, lines, rtol=5e-6)  # six digits
    np.testing.assert_allclose(frf.values[:, 0, :], receptances(), rtol=1e-9)


def test_of_a_force_and_a_response_at_one_place_each_is_found_by_what_it_measures(tmp_path: Path) -> None:
    rows = hit(2)
    force = plain_rig().channels[0].model_copy(update={"point": 1})
    sensor = plain_rig().channels[1].model_copy(update={"point": 1})
    rig = plain_rig().model_copy(update={"channels": (force, sensor), "points": RIG.points})
    at = {"rsp_node": 1, "rsp_dir": 3}
    sets = [
        uff_set(rows[1], times(), 1, **at),
        uff_set(rows[0], times(), 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="N", **at),
    ]
    (block,) = import_sources([write_uff(tmp_path / "a.uff", *sets)], rig).blocks
    np.testing.assert_allclose(block.samples, rows, rtol=1e-9)


def test_the_rate_is_whole_where_the_printed_step_allows_it(tmp_path: Path) -> None:
    rows = hit(2)
    axis = np.arange(256) / 65536
    force = uff_set(rows[0], axis, 1, ordinate_spec_data_type=13, ordinate_axis_units_lab="N")
    path = write_uff(tmp_path / "a.uff", force, uff_set(rows[1], axis, 1))
    assert b"1.52588e-05" in path.read_bytes()
    assert import_sources([path], plain_rig()).blocks[0].rate_hz == 65536.0


def test_what_pyuff_writes_is_read(tmp_path: Path) -> None:
    for number, content in enumerate(frf_sets()):
        pyuff.UFF(str(tmp_path / "peer.uff")).write_sets(content, "add" if number else "overwrite")
    np.testing.assert_allclose(read_frf(tmp_path / "peer.uff").values[:, 0, :], receptances(), rtol=1e-9)


@pytest.mark.parametrize("binary", [False, True])
def test_frfs_become_a_matrix_in_si_and_rig_directions(tmp_path: Path, binary: bool) -> None:
    frf = read_frf(write_uff(tmp_path / "frf.uff", *frf_sets(), binary=binary))
    assert (frf.quantity, frf.outputs, frf.output_points, frf.input_points) == (
        "receptance", ("a01", "a02", "a03"), (1, 2, 3), (2,),
    )  # fmt: skip
    np.testing.assert_allclose(frf.frequency_hz, LINES)
    np.testing.assert_allclose(frf.values[:, 0, :], receptances(), rtol=1e-9)


@pytest.mark.parametrize(
    ("unit", "per", "quantity", "factor"),
    [
        ("m/s^2", "N", "inertance", 1.0),
        ("g", "N", "inertance", 9.80665),
        ("mm/s", "kN", "mobility", 1e-6),
        ("m/s^2/N", "NONE", "inertance", 1.0),
        ("(m/s)/N", "NONE", "mobility", 1.0),
        ("1/kg", "NONE", "inertance", 1.0),
    ],
)
def test_units_of_frfs(tmp_path: Path, unit: str, per: str, quantity: str, factor: float) -> None:
    plain = {"ordinate_spec_data_type": 0, "orddenom_spec_data_type": 0}
    sets = frf_sets(ordinate_axis_units_lab=unit, orddenom_axis_units_lab=per, **plain)
    frf = read_frf(write_uff(tmp_path / "frf.uff", *sets))
    assert frf.quantity == quantity
    np.testing.assert_allclose(frf.values[:, 0, :], factor * receptances(), rtol=1e-9)


def test_several_inputs_and_coherences(tmp_path: Path) -> None:
    gamma = [dict(s, data=np.full(64, 0.75), func_type=6) for s in (*frf_sets(node=2), *frf_sets(node=3))]
    frf = read_frf(write_uff(tmp_path / "frf.uff", *frf_sets(node=2), *frf_sets(node=3, direction=-3), *gamma))
    assert frf.input_points == (2, 3)
    np.testing.assert_allclose(frf.values[:, 1], -frf.values[:, 0], rtol=1e-9)
    assert frf.coherence is not None
    np.testing.assert_allclose(frf.coherence, 0.75)


def spoilt(values: Any = None, axis: Any = None, **fields: Any) -> list[dict[str, Any]]:
    sets = frf_sets()
    for content in sets[1:2] if axis is None else sets:
        content.update(fields)
        content["data"] = content["data"] if values is None else values
        content["x"] = content["x"] if axis is None else axis
    return sets


REPEATED = np.concatenate([LINES[:-1], LINES[-2:-1]])

CASES: list[tuple[str, list[dict[str, Any]], str]] = [
    ("magnitude only", spoilt(np.abs(receptances()[1])), "channel a02: its FRF is magnitude only"),
    ("real part only", spoilt(receptances()[1].real), "channel a02: its FRF is real at every line"),
    ("NaN", spoilt(np.full(64, np.nan + 0j)), "channel a02: 64 lines of its FRF are NaN or infinite"),
    ("mirror", spoilt(np.r_[receptances()[1][:32], receptances()[1][31::-1].conj()]), "mirrors the lower"),
    ("repeated", spoilt(axis=REPEATED, abscissa_spacing=0), "the frequency axis does not ascend"),
    ("descending", spoilt(axis=LINES[::-1]), "the frequency axis descends"),
    ("other lines", spoilt(x=LINES * 2), "set 2: its lines are not those of set 1"),
    ("unit", spoilt(ordinate_axis_units_lab="Pa"), "set 2 has the unit 'Pa' per 'N', which is no FRF's"),
    ("kinds mixed", spoilt(ordinate_axis_units_lab="g"), "the FRFs are of several kinds: inertance, receptance"),
    ("no such node", spoilt(rsp_node=9), "set 2, 'NONE' in 'm', node 9 +z, is no single channel of the rig"),
    ("no such axis", spoilt(rsp_dir=1), "set 2, 'NONE' in 'm', node 2 +x, is no single channel of the rig"),
    ("rotation", spoilt(rsp_dir=6), "node 2 rotation about +z, is no single channel"),
    ("reference axis", spoilt(ref_dir=1), "set 2, reference: direction +x is not that of the rig, +z"),
    ("field that helps", spoilt(ref_dir=1), "set drive_direction in the rig file to +x"),
    ("twice", spoilt(rsp_node=1), "sets 1 and 2 are both the FRF of channel a01 to node 2"),
    ("gap", frf_sets()[:2], "no FRF of channel a03"),
    ("gap in matrix", [*frf_sets(), *frf_sets(node=1)[:2]], "no FRF of channel a03 to node 1"),
    ("unknown input", frf_sets(node=8), "node 8 is no point of the rig, which has 1, 2, 3"),
    ("spectra only", frf_sets(kind=2), "holds neither time records nor FRFs, only auto spectrum"),
]


@pytest.mark.parametrize(("sets", "words"), [c[1:] for c in CASES], ids=[c[0] for c in CASES])
def test_bad_frfs_are_rejected_by_name(tmp_path: Path, sets: list[dict[str, Any]], words: str) -> None:
    assert words in rejected(DataError, write_uff(tmp_path / "frf.uff", *sets))


def test_a_dead_output_among_frfs_is_left_out_by_name(tmp_path: Path) -> None:
    campaign = import_sources([write_uff(tmp_path / "frf.uff", *spoilt(np.zeros(64, complex)))], RIG)
    assert campaign.frfs[0].outputs == ("a01", "a03")
    np.testing.assert_allclose(campaign.frfs[0].values[:, 0], receptances()[[0, 2]], rtol=1e-9)
    assert "channel a02: its FRF is zero at every line, and left out" in campaign.provenance["notes"]


def test_bad_time_records_are_rejected_by_name(tmp_path: Path) -> None:
    uneven = times()
    uneven[100:] += 1e-3
    sets = [uff_set(row, uneven, 1, rsp_node=k, rsp_dir=3, abscissa_spacing=0) for k, row in enumerate(hit(3), start=1)]
    force = uff_set(hit(4)[3], uneven, 1, ordinate_axis_units_lab="N", ordinate_spec_data_type=13, abscissa_spacing=0)
    assert "set 1: the time axis is uneven" in rejected(DataError, write_uff(tmp_path / "a.uff", force, *sets))
    short = [
        uff_set(row[: 256 - k], times(256 - k), 1, rsp_node=k, rsp_dir=3) for k, row in enumerate(hit(4)[1:], start=1)
    ]
    force = uff_set(hit(4)[0], times(), 1, ordinate_axis_units_lab="N", ordinate_spec_data_type=13)
    message = rejected(DataError, write_uff(tmp_path / "b.uff", force, *short))
    assert "channel a01 (set 2) has 255 samples at 2000 Hz from 0 s, channel force (set 1) has 256" in message
    pressure = uff_set(hit(2)[1], times(), 1, ordinate_axis_units_lab="Pa", rsp_ent_name="pressure")
    message = rejected(DataError, write_uff(tmp_path / "c.uff", force, pressure), plain_rig())
    assert "set 2, 'NONE' in 'Pa', without a node, is no single channel of the rig" in message


@pytest.mark.parametrize("name", ["analyser_58.uff", "analyser_58b.uff"])
@pytest.mark.parametrize("share", [0.05, 0.3, 0.7, 0.995])
def test_a_file_cut_off_is_reported(tmp_path: Path, name: str, share: float) -> None:
    raw = (DATA / name).read_bytes()
    path = tmp_path / "cut.uff"
    path.write_bytes(raw[: int(share * len(raw))])
    message = rejected(FormatError, path)
    assert "is cut off" in message or "cannot be decoded" in message


def test_values_that_are_missing_within_a_set_are_counted(tmp_path: Path) -> None:
    lines = (DATA / "analyser_58.uff").read_text().splitlines(keepends=True)
    path = tmp_path / "short.uff"
    path.write_text("".join(lines[:40] + lines[60:]))
    assert "set 1: is cut off or damaged: 483 of 603 values are there" in rejected(FormatError, path)


def test_ordinates_of_an_unknown_type_are_reported(tmp_path: Path) -> None:
    path = write_uff(tmp_path / "a.uff", *frf_sets(), binary=True)
    path.write_bytes(path.read_bytes().replace(b"         6        64", b"         3        64", 1))
    assert "set 1: has ordinates of type 3; the format knows 2, 4, 5 and 6" in rejected(FormatError, path)


def test_a_universal_file_that_is_none_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "report.uff"
    path.write_text("Measurement report\n")
    assert "is no universal file: it has no line '    -1'" in rejected(FormatError, path)


def test_sets_of_other_kinds_are_left_out_and_noted(tmp_path: Path) -> None:
    spectrum = uff_set(np.ones(64), LINES, 2)
    notes = import_sources([write_uff(tmp_path / "a.uff", spectrum, *frf_sets())], RIG).provenance["notes"]
    assert notes == "a.uff: left out auto spectrum"


def test_options_name_the_drive_point(tmp_path: Path) -> None:
    path = write_hit_uff(tmp_path / "hit.uff", hit(4), force_node=2)
    (block,) = import_sources([path], RIG, ImportOptions(drive_point=3)).blocks
    assert block.drive_point == 3


def test_an_exponential_window_that_frfs_were_made_with_is_kept_with_them(tmp_path: Path) -> None:
    (frf,) = import_sources([write_uff(tmp_path / "frf.uff", *frf_sets())], RIG, ImportOptions(window_s=0.5)).frfs
    assert frf.damping_shift == 2.0
