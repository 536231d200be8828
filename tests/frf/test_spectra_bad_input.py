"""No public function of the spectra answers what no bench records with a number, or with its libraries' errors."""

from dataclasses import replace

import modal_bench as bench
import numpy as np
import pytest

from modallab.core.block import Block
from modallab.core.errors import DataError, ModallabError
from modallab.core.rig import Channel, Converter, Point, Rig
from modallab.frf.estimate import lines_of_band, pre_trigger_level
from modallab.frf.stepped import stepped_frf
from modallab.signals.ac_coupling import undo_ac_coupling
from modallab.signals.alignment import align_channels
from modallab.signals.faults.whole_channels import overloaded_channels
from modallab.signals.hit import find_hit, windowed_force
from modallab.signals.signals import to_signals, to_signals_of
from modallab.signals.tone_fit import fit_at, fit_frequency, strongest_line_near
from modallab.signals.transform import bandpass, remove_mean

N, RATE = 512, 1000.0
TIME = np.arange(N) / RATE
ROWS = np.stack([np.sin(2 * np.pi * 50.3 * TIME), np.cos(2 * np.pi * 50.3 * TIME), np.sin(2 * np.pi * 20 * TIME)])
LAGS = np.array([0.0, 1e-3, 2.5e-3])


def rig(corner_hz=1.0):
    channels = [Channel(index=0, name="force", quantity="force", unit="N")]
    channels += [
        Channel(index=i, name=f"a{i:02d}", quantity="acceleration", unit="m/s^2", point=i, ac_corner_hz=corner)
        for i, corner in ((1, corner_hz), (2, 0.0))
    ]
    points = (Point(id=1, x_m=0.1), Point(id=2, x_m=0.2))
    return Rig(name="two", model="unknown", points=points, channels=tuple(channels), converter=Converter())


def rejected(call, *arguments, **named):
    """The error, which must say what was wrong and what to do."""
    with pytest.raises(ModallabError) as caught:
        call(*arguments, **named)
    assert caught.value.what
    assert caught.value.remedy
    return caught.value


def spoiled(value):
    rows = ROWS.copy()
    rows[1, 7] = value
    return rows


BAD_ROWS = {
    "NaN": spoiled(np.nan),
    "infinite": spoiled(-np.inf),
    "larger than anything": spoiled(1e200),
    "no samples": ROWS[:, :0],
    "no channels": ROWS[:0],
    "transposed": ROWS.T,
    "no axis": np.float64(3.0),
    "complex": ROWS + 0j,
    "text": ROWS.astype(str),
}
OF_ROWS = {
    "aligned": lambda v, rate=RATE: align_channels(v, rate, LAGS),
    "uncoupled": lambda v, rate=RATE: undo_ac_coupling(v, rate, rig()),
    "bandpass": lambda v, rate=RATE: bandpass(v, rate, (10.0, 100.0)),
    "fit_at": lambda v, rate=RATE: fit_at(v, rate, 50.0),
    "fit_frequency": lambda v, rate=RATE: fit_frequency(v, rate, 50.0),
}


@pytest.mark.parametrize("call", OF_ROWS)
def test_good_rows_are_taken(call):
    OF_ROWS[call](ROWS)


@pytest.mark.parametrize("bad", BAD_ROWS)
@pytest.mark.parametrize("call", [*OF_ROWS, "remove_mean"])
def test_rows_that_no_bench_records_are_rejected(call, bad):
    rejected(remove_mean if call == "remove_mean" else OF_ROWS[call], BAD_ROWS[bad])


@pytest.mark.parametrize("call", ["aligned", "uncoupled", "fit_at", "fit_frequency"])
def test_three_axes_are_no_channels(call):
    rejected(OF_ROWS[call], ROWS[None])


@pytest.mark.parametrize("call", ["aligned", "uncoupled", "fit_at", "fit_frequency"])
def test_far_too_short_records_are_rejected(call):
    assert "samples" in str(rejected(OF_ROWS[call], ROWS[:, :4]))


@pytest.mark.parametrize("rate", [-1000.0, 0.0, np.nan, np.inf])
@pytest.mark.parametrize("call", OF_ROWS)
def test_a_rate_that_is_none_is_rejected(call, rate):
    assert f"{rate} Hz" in str(rejected(OF_ROWS[call], ROWS, rate))


@pytest.mark.parametrize("bad", ["NaN", "infinite", "larger than anything"])
@pytest.mark.parametrize("call", [find_hit, lambda v: strongest_line_near(v, RATE, 50.0)], ids=["hit", "strongest"])
def test_one_record_that_no_bench_records_is_rejected(call, bad):
    for one in (BAD_ROWS[bad][1], ROWS, ROWS[0][:0], ROWS[0] + 0j):
        rejected(call, one)


@pytest.mark.parametrize("lags", [LAGS * np.nan, LAGS[:2], -LAGS, 1e3 * LAGS, LAGS[:, None], LAGS + np.inf], ids=str)
def test_lags_that_no_converter_has_are_rejected(lags):
    rejected(align_channels, ROWS, RATE, lags)


@pytest.mark.parametrize("bad_hz", [np.nan, np.inf, -5.0, 0.0, 500.0, 600.0])
def test_a_frequency_that_cannot_be_in_the_record_is_rejected(bad_hz):
    for call in (fit_at, fit_frequency):
        rejected(call, ROWS, RATE, bad_hz)
    rejected(strongest_line_near, ROWS[0], RATE, bad_hz)
    rejected(undo_ac_coupling, ROWS, RATE, rig(), bad_hz)


def test_a_fit_without_a_step_is_rejected():
    for none in (0, -3):
        rejected(fit_frequency, ROWS[:2], RATE, 50.0, none)


def test_channels_that_are_flat_have_no_sine_and_lead_no_other_astray():
    flat = np.vstack([ROWS[:1], np.ones((1, N)), np.zeros((1, N))])
    fit = fit_frequency(flat, RATE, 50.0)
    assert fit.frequency_hz == pytest.approx(50.3, rel=1e-6)
    np.testing.assert_allclose(np.abs(fit.amplitude), [1, 0, 0], atol=1e-9)
    for row in flat[1:]:
        assert strongest_line_near(row, RATE, 50.0) == 50.0


@pytest.mark.parametrize("band", [(np.nan, 100.0), (10.0, np.inf), (100.0, 10.0), (0.0, 10.0), (-5.0, 9.0), (10, 900)])
def test_a_band_that_is_none_is_rejected(band):
    rejected(bandpass, ROWS, RATE, band)


def test_a_lower_edge_that_asks_for_more_taps_than_any_memory_holds_is_rejected():
    assert "1e-09 Hz" in str(rejected(bandpass, ROWS, RATE, (1e-9, 100.0)))


@pytest.mark.parametrize("band", [(np.nan, 9.0), (9.0, np.nan), (90.0, 9.0), (3.0, 4.0), (-9.0, -3.0), (600.0, 900.0)])
def test_a_band_without_lines_is_rejected(band):
    rejected(lines_of_band, N, RATE, band)
    rejected(lines_of_band, 0, RATE, (10.0, 100.0))


HIT = np.random.default_rng(0).normal(0, 0.01, N)
HIT[40:46] += [10, 40, 60, 50, 20, 5]


@pytest.mark.parametrize("threshold", [np.nan, 0.0, -5.0, np.inf])
def test_a_threshold_that_is_none_is_rejected(threshold):
    assert find_hit(HIT).peak == 42
    rejected(find_hit, HIT, threshold)


def test_a_force_without_a_hit_has_none():
    for force in (np.zeros(N), np.ones(N), np.sin(2 * np.pi * 50 * TIME), HIT[:4] * 0):
        rejected(find_hit, force)


def test_a_hit_is_taken_out_of_its_own_force_alone():
    hit = find_hit(HIT)
    for other in (HIT[: hit.first], HIT[None], HIT * np.nan):
        rejected(windowed_force, other, hit)
    rejected(windowed_force, HIT, replace(hit, first=-3))


COUNTS = np.array([[0, 100, 3, 1], [1, 2, 3, 4], [4, 2, 4, 5]], np.int16)
BLOCK = Block("r", "impact", 0, RATE, COUNTS, np.full(3, 1e-3), ("V",) * 3, ("force", "a01", "a02"))
BAD_BLOCKS = {
    "NaN": replace(BLOCK, samples=COUNTS * np.nan),
    "infinite": replace(BLOCK, samples=np.where(COUNTS == 5, np.inf, COUNTS)),
    "no samples": replace(BLOCK, samples=COUNTS[:, :0]),
    "no channels": replace(BLOCK, samples=COUNTS[:0]),
    "one axis": replace(BLOCK, samples=COUNTS[0]),
    "a row too few": replace(BLOCK, samples=COUNTS[:2]),
    "scale of nothing": replace(BLOCK, scale=np.array([1e-3, 0, 1e-3])),
    "scale NaN": replace(BLOCK, scale=np.array([1e-3, np.nan, 1e-3])),
    "scales too few": replace(BLOCK, scale=np.full(2, 1e-3)),
    "units too few": replace(BLOCK, units=("V", "V")),
    "channels too few": replace(BLOCK, channels=("force", "a01")),
    "other channels": replace(BLOCK, channels=("force", "a02", "a01")),
    "flags too few": replace(BLOCK, overload=(True,)),
    "rate below zero": replace(BLOCK, rate_hz=-1.0),
    "rate NaN": replace(BLOCK, rate_hz=np.nan),
}


@pytest.mark.parametrize("bad", BAD_BLOCKS)
@pytest.mark.parametrize("call", [overloaded_channels, to_signals])
def test_a_block_whose_parts_do_not_fit_is_rejected(call, bad):
    direct = rig(corner_hz=0.0)
    call(BLOCK, direct)
    assert "record r" in str(rejected(call, BAD_BLOCKS[bad], direct))


def test_a_channel_turned_by_its_scale_reaches_full_scale_at_the_same_volts():
    full = replace(BLOCK, samples=np.where(COUNTS == 5, 10_000, COUNTS).astype(np.int32))
    assert overloaded_channels(full, rig()) == overloaded_channels(replace(full, scale=-full.scale), rig()) == ("a02",)


@pytest.fixture(scope="module")
def stepped():
    rng = np.random.default_rng(4)
    blocks = bench.sine_blocks(bench.modes(rng, 2), rng, np.array([5.0, 6.0, 7.0]), settle_s=1.0)
    return to_signals_of(blocks, bench.rig(5))


def test_a_force_without_the_sine_that_was_set_is_rejected(stepped):
    first, *others = stepped
    for set_to in (None, np.nan, -5.0, 900.0, 7.0):
        bad = replace(first, block=replace(first.block, frequency_hz=set_to))
        rejected(stepped_frf, [bad, *others], bench.rig(5))


def test_signals_that_are_no_records_cannot_be_made(stepped):
    first = stepped[0]
    for change in (
        {"responses": first.responses * np.nan},
        {"responses": first.responses.T},
        {"responses": first.responses[:-1]},
        {"responses": first.responses[0]},
        {"forces": first.force[:-1]},
        {"forces": first.force * np.inf},
        {"forces": first.force + 0j},
        {"forces": first.force[None, None]},
        {"outputs": first.outputs[:-1]},
        {"rate_hz": np.nan},
        {"rate_hz": -1000.0},
    ):
        assert first.block.name in str(rejected(lambda change=change: replace(first, **change)))


def test_sine_blocks_that_make_no_stepped_test_are_rejected(stepped):
    first, *others = stepped
    for bad in (
        replace(first, responses=np.vstack([first.responses[:-1], 0 * first.responses[-1:]])),
        replace(first, forces=first.force * 0),
        replace(first, rate_hz=2 * first.rate_hz),
        replace(first, block=replace(first.block, drive_point=1)),
        replace(first, block=replace(first.block, test="impact")),
    ):
        rejected(stepped_frf, [bad, *others], bench.rig(5))
    rejected(stepped_frf, stepped, bench.rig(4))
    rejected(stepped_frf, [], bench.rig(5))


def test_a_pre_trigger_level_needs_a_hit(stepped):
    with pytest.raises(DataError):
        pre_trigger_level(stepped[0])
