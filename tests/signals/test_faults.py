"""Faults of the chain in samples: named by channel and time, in numbers of every kind; sound records have none."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from modallab.core.block import Block, Campaign
from modallab.core.errors import DataError
from modallab.core.rig import Channel, Point, Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.undamaged_records import undamaged_records
from modallab.signals.faults.all_faults import find_faults
from modallab.signals.faults.repeats import SampleFault
from modallab.signals.faults.whole_channels import LOWEST_LINE

Rows = NDArray[np.float64]
N, RATE_HZ = 4096, 2000.0
RIG = Rig(
    name="two sensors",
    model="unknown",
    points=(Point(id=1, x_m=0.1), Point(id=2, x_m=0.2)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1),
        Channel(index=2, name="a2", quantity="acceleration", unit="m/s^2", point=2),
    ),
)


def record(kind: str, seed: int, noise: float = 1e-3, rate_hz: float = RATE_HZ) -> Rows:
    """(3, n) a force and the accelerations of three modes at two places, with noise as a share of the largest."""
    rng = np.random.default_rng(seed)
    force, t = np.zeros(N), np.arange(N) / rate_hz
    if kind == "hit":
        k = int(rng.integers(4, 20))
        force[100 : 100 + k] = 80 * np.sin(np.pi * (np.arange(k) + rng.uniform()) / (k + 1)) ** 2
    elif kind == "sine":
        force = 10 * np.sin(2 * np.pi * rng.uniform(5, 300) * t)
    else:
        force = rng.normal(size=N) * 10
        force[(N // 2 if kind == "burst" else N) :] = 0
    omega, rows = 2 * np.pi * np.fft.rfftfreq(4 * N, 1 / rate_hz), [force]
    for _ in range(2):
        own = zip(
            rng.choice([-1, 1], 3) * rng.uniform(0.3, 1, 3),
            (40.0, 75.0, 180.0),
            rng.uniform(0.001, 0.02, 3),
            strict=True,
        )
        h = sum(a * -(omega**2) / ((2 * np.pi * f) ** 2 - omega**2 + 4j * np.pi * z * f * omega) for a, f, z in own)
        rows.append(np.fft.irfft(np.fft.rfft(force, 4 * N) * h)[:N])
    clean = np.stack(rows)
    return clean + noise * np.abs(clean).max(axis=1, keepdims=True) * rng.normal(size=clean.shape)


def counts(rows: Rows, bits: int, gain: float = 0.8) -> Rows:
    return np.round(rows / np.abs(rows).max(axis=1, keepdims=True) * gain * 2 ** (bits - 1))


def digits(rows: Rows, n: int) -> Rows:
    return np.array([[float(f"{v:.{n}g}") for v in row] for row in rows])


NUMBERS: dict[str, Callable[[Rows], NDArray[Any]]] = {
    "double": lambda r: r,
    "single": lambda r: r.astype(np.float32),
    "16 bits": lambda r: counts(r, 16).astype(np.int16),
    "12 bits": lambda r: counts(r, 12),
    "10 bits, low gain": lambda r: counts(r, 10, 0.1),
    "four digits": lambda r: digits(r, 4),
    "two places": lambda r: np.round(r, 2),
}


def block(samples: NDArray[Any], name: str = "record", rate_hz: float = RATE_HZ) -> Block:
    units, channels = ("N", "m/s^2", "m/s^2"), ("force", "a1", "a2")
    return Block(name, "impact", 0, rate_hz, samples, np.ones(3), units, channels)


@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("kind", ["hit", "random", "burst", "sine"])
def test_sound_records_have_no_fault(kind: str, numbers: str) -> None:
    for seed, noise in enumerate((0.0, 1e-6, 1e-4, 1e-2)):
        for rate_hz in (512.0, 2000.0, 51200.0):
            found = find_faults(block(NUMBERS[numbers](record(kind, seed, noise, rate_hz)), rate_hz=rate_hz), RIG)
            assert not found, (noise, rate_hz, *map(str, found))


def at_share(row: Rows, share: float) -> Rows:
    top = share * np.abs(row).max()
    return np.clip(row, -top, top)


def held(row: Rows, ratio: float) -> Rows:
    return row[(np.floor(np.floor(np.arange(N) / ratio) * ratio)).astype(int)]


def straight(row: Rows, ratio: float) -> Rows:
    knots = np.arange(0, N, ratio)
    return np.interp(np.arange(N), knots, row[np.round(knots).astype(int) % N])


def stopped(row: Rows, value: float | None, samples: int) -> Rows:
    changed = row.copy()
    changed[200 : 200 + samples] = row[200] if value is None else value
    return changed


def one_off(row: Rows, factor: float) -> Rows:
    changed = row.copy()
    changed[1500] = factor * np.abs(row).max()
    return changed


def with_last_step(row: Rows, share: float) -> Rows:
    """Cut off, with noise of a step of the converter behind the stage that did it."""
    step = share * np.abs(row).max() / 8000
    noise = np.random.default_rng(5).integers(-1, 2, row.size)
    return np.where(np.abs(row) > 8000 * step, np.sign(row) * 8000 + noise, np.round(row / step)) * step


def warming(row: Rows) -> Rows:
    return row + 20 * np.abs(row).max() * (1 - np.exp(-4 * np.arange(row.size) / row.size))


CHAIN: dict[str, tuple[Callable[[Rows], Rows], str]] = {
    "both ends": (lambda r: at_share(r, 0.6), "flat"),
    "upper end": (lambda r: np.minimum(r, 0.6 * r.max()), "flat tops"),
    "both ends, noise behind": (lambda r: with_last_step(r, 0.5), "flat"),
    "zero that drifts": (warming, "zero drifts"),
    "no sensor": (lambda r: 1e-3 * np.random.default_rng(6).integers(-1, 2, r.size), "at most 2 steps"),
    "held 2": (lambda r: held(r, 2), "held for 2 samples"),
    "held 2.5": (lambda r: held(r, 2.5), "held for"),
    "held 8": (lambda r: held(r, 8), "held for 8 samples"),
    "straight 2": (lambda r: straight(r, 2), "straight lines"),
    "straight 4": (lambda r: straight(r, 4), "straight lines over 4 samples"),
    "zero": (lambda r: stopped(r, 0.0, 10), "stands still at 0"),
    "last value": (lambda r: stopped(r, None, 20), "stands still"),
    "dead from then on": (lambda r: stopped(r, None, N), "stands still"),
    "exponent": (lambda r: one_off(r, 1e6), "neighbouring samples do not explain"),
}


@pytest.mark.parametrize("fault", CHAIN)
@pytest.mark.parametrize("kind", ["hit", "random", "sine"])
def test_a_fault_is_named_with_its_channel(kind: str, fault: str) -> None:
    make, words = CHAIN[fault]
    for seed in range(3):
        rows = record(kind, seed, 1e-4)
        rows[1] = make(rows[1])
        found = find_faults(block(rows), RIG)
        assert any(f.channel == "a1" and words in f.what for f in found), list(map(str, found))
        assert {f.channel for f in found} == {"a1"}


def test_a_part_that_is_held_is_named_where_it_begins() -> None:
    for seed in range(5):
        rows = 1e-6 * counts(record("hit", seed, 1e-2), 16)
        rows[0, 2500:] = held(rows[0], 5)[2500:]
        (found,) = find_faults(block(rows), RIG)
        assert (found.channel, found.what) == ("force", "values held for 5 samples, as from a slower converter")
        assert abs(found.first_s - 2500 / RATE_HZ) < 40 / RATE_HZ


def test_it_is_named_with_its_time() -> None:
    rows = record("random", 1)
    rows[1] = stopped(rows[1], 0.0, 10)
    assert find_faults(block(rows), RIG) == (SampleFault("a1", "stands still at 0 while it should move", 0.1, 10),)
    rows = record("hit", 1)
    rows[2] = one_off(rows[2], 100)
    (found,) = find_faults(block(rows), RIG)
    assert (found.channel, found.first_s, found.samples) == ("a2", 0.75, 1)


def test_a_fast_ringing_cut_off_for_a_sample_or_two_at_a_time_is_named_and_equal_tops_are_none() -> None:
    t = np.arange(N) / RATE_HZ
    for seed in range(10):
        rng = np.random.default_rng(seed)
        ringing = rng.uniform(90, 110) * np.exp(-6 * t) * np.sin(2 * np.pi * rng.uniform(300, 380) * t)
        rows = record("hit", seed, 1e-4)
        rows[1] = np.clip(ringing + 0.01 * rng.normal(size=N), -1e9, rng.uniform(30, 60))
        assert [f.channel for f in find_faults(block(rows), RIG) if "flat tops" in f.what] == ["a1"]
        tone = 20 * np.sin(2 * np.pi * rng.uniform(5, 400) * t + rng.uniform(0, 6))
        for sound in (tone, np.round(tone, 2), np.round(tone * 3), np.tile(np.round(ringing[:512], 3), 8)):
            rows[1] = sound
            assert not [f for f in find_faults(block(rows), RIG) if "flat" in f.what]


@pytest.mark.parametrize("kind", ["hit", "random"])
def test_a_buffer_that_was_written_twice_is_named(kind: str) -> None:
    rows = record(kind, 1, 1e-4)
    rows[:, 400:528] = rows[:, 272:400]
    (found,) = find_faults(block(rows), RIG)
    assert "repeats exactly" in found.what
    assert (found.first_s, found.samples) == (400 / RATE_HZ, 128)


def test_a_hit_of_three_samples_is_none() -> None:
    rows = record("hit", 1, 1e-4)
    rows[0] *= 1e-3
    rows[0, 40:43] = np.abs(rows[0]).max() * np.array([1e4, 2e4, 1e4])
    assert find_faults(block(rows), RIG) == ()


def test_a_shock_that_all_channels_feel_is_none() -> None:
    rows = record("random", 2, 1e-3)
    rows[:, 1500] += 1e4 * np.abs(rows).max(axis=1)
    assert find_faults(block(rows), RIG) == ()


def test_a_spoilt_record_is_left_out_by_name_and_none_left_is_an_error() -> None:
    good, bad = record("hit", 1), record("hit", 2)
    bad[0] = np.minimum(bad[0], 0.6 * bad[0].max())
    campaign = Campaign(RIG, (block(good, "good"), block(bad, "bad")), source="a.h5")
    kept, _, notes = undamaged_records(campaign, campaign.blocks)
    assert [b.name for b in kept] == ["good"]
    assert "faults in their samples: bad, channel force: flat tops at" in notes[0]
    with pytest.raises(DataError, match="every record has a fault: bad, channel force: flat tops"):
        undamaged_records(campaign, campaign.blocks[1:])


def test_a_response_at_fault_in_most_records_is_left_out_of_all_and_no_record_for_its_sake() -> None:
    rows = [record("hit", seed) for seed in range(1, 6)]
    for one in rows[:3]:
        one[1] = 0.25
    rows[4][2] = np.minimum(rows[4][2], 0.5 * rows[4][2].max())
    campaign = Campaign(RIG, tuple(block(one, f"h{k}") for k, one in enumerate(rows)), source="a.h5")
    kept, rig, notes = undamaged_records(campaign, campaign.blocks)
    assert [b.name for b in kept] == ["h0", "h1", "h2", "h3"]
    assert [c.name for c in rig.channels] == ["force", "a2"]
    assert all(b.channels == ("force", "a2") and len(b.samples) == 2 for b in kept)
    said = "h0, dead, all values are 0.25, 4096 samples from 0 s on"
    assert notes[0] == f"Left out, channel a1, at fault in 3 of 5 records: {said}."
    assert "h4, channel a2: flat tops" in notes[1]


def test_a_hit_whose_force_is_dead_is_left_out_by_name_and_the_others_are_read_and_identified(tmp_path: Path) -> None:
    rows = [record("hit", seed, 1e-4) for seed in range(1, 6)]
    rows[2][0] = 0.25
    blocks = tuple(replace(block(one, f"h{k}"), order=k, drive_point=1) for k, one in enumerate(rows))
    write_campaign(Campaign(RIG, blocks, source="a.h5"), tmp_path / "a.h5")
    model = identify_campaign(read_campaign(tmp_path / "a.h5"), IdentificationOptions()).identified[0].model
    assert any("h2, channel force: dead, all values are 0.25" in note for note in model.notes)
    without = identify_campaign(Campaign(RIG, blocks[:2] + blocks[3:]), IdentificationOptions()).identified[0].model
    np.testing.assert_array_equal(model.frequency_hz, without.frequency_hz)


def test_responses_alone_do_not_ask_for_the_force() -> None:
    rows = record("random", 1)
    rows[0] = 0
    campaign = Campaign(RIG, (block(rows),), source="a.h5")
    kept, rig, notes = undamaged_records(campaign, campaign.blocks, {"force"})
    assert (kept[0].channels, [c.name for c in rig.channels], notes) == (("a1", "a2"), ["a1", "a2"], ())
    with pytest.raises(DataError, match="channel force: dead"):
        undamaged_records(campaign, campaign.blocks)


@pytest.mark.parametrize("kind", ["hit", "random"])
def test_a_zero_that_goes_away_at_a_shock_and_comes_back_within_the_record_drifts(kind: str) -> None:
    for seed in range(8):
        rng, rows = np.random.default_rng(seed), record(kind, seed, 1e-4)
        t = np.arange(N) / N - rng.uniform(0.05, 0.6)
        shock = rng.choice([-1, 1]) * rng.uniform(3, 5) * np.abs(rows[1]).max()
        rows[1] += np.where(t > 0, shock * np.exp(-np.maximum(t, 0) / rng.uniform(0.15, 0.6)), 0)
        assert [f.channel for f in find_faults(block(rows), RIG) if "zero drifts" in f.what] == ["a1"]


def test_a_mode_of_the_lowest_line_that_is_looked_at_is_no_drift() -> None:
    t = np.arange(N) / RATE_HZ
    for turns in np.linspace(LOWEST_LINE, 8, 40):
        rows = record("hit", 1, 1e-4)
        for zeta in (0.0, 0.01, 0.03):
            omega = 2 * np.pi * turns * RATE_HZ / N
            rows[1] = np.exp(-zeta * omega * t) * np.sin(omega * t + turns)
            assert not [f for f in find_faults(block(rows), RIG) if "drifts" in f.what], (turns, zeta)
