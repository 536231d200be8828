"""A hit that does not answer as the others at its point is left out by name, with what is wrong; sound ones stay."""

import re
from collections.abc import Callable

import numpy as np
import pytest

from modallab.core.block import Block, Campaign
from modallab.core.rig import Channel, Point, Rig
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign, usable_blocks

RATE, N = 2048.0, 2048
NAMES = ("force", "a1", "a2", "a3")
RIG = Rig(
    name="a structure",
    model="unknown",
    points=tuple(Point(id=k, x_m=0.1 * k) for k in (1, 2, 3)),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        *(Channel(index=k, name=f"a{k}", quantity="acceleration", unit="m/s^2", point=k) for k in (1, 2, 3)),
    ),
)
FREQUENCY, DAMPING = np.array([52.0, 131.0]), np.array([0.012, 0.008])
SHAPES = np.array([[0.6, 0.9, 0.4], [0.7, -0.5, 0.8]])


def record(peak: float, seed: int, shapes: np.ndarray = SHAPES) -> np.ndarray:
    """(4, N): a half sine of 4 ms, and the accelerations that it makes, with noise."""
    t = np.arange(N) / RATE - 0.05
    force = peak * np.where((t > 0) & (t < 0.004), np.sin(np.pi * np.clip(t / 0.004, 0, 1)), 0.0)
    s, w = 2j * np.pi * np.fft.rfftfreq(8 * N, 1 / RATE), 2 * np.pi * FREQUENCY[:, None]
    modal = s**2 / (s**2 + 2 * DAMPING[:, None] * w * s + w**2)
    h = np.einsum("mo,m,mf->of", shapes, shapes[:, 0], modal)
    rows = np.vstack([force, np.fft.irfft(h * np.fft.rfft(force, 8 * N))[:, :N]])
    return rows + np.random.default_rng(seed).normal(size=rows.shape) * 1e-4 * np.abs(rows).max(axis=1, keepdims=True)


def campaign_of(rows: list[np.ndarray]) -> Campaign:
    facts = {"test": "impact", "rate_hz": RATE, "scale": np.ones(4), "channels": NAMES, "drive_point": 1}
    units = ("N", *["m/s^2"] * 3)
    return Campaign(
        RIG, tuple(Block(name=f"hit_{k}", order=k, samples=r, units=units, **facts) for k, r in enumerate(rows))
    )


def hits() -> list[np.ndarray]:
    return [record(peak, seed) for seed, peak in enumerate((60.0, 75.0, 90.0, 50.0))]


def loose(rows: np.ndarray) -> np.ndarray:
    out = rows.copy()
    out[3, 700:1000] += 0.5 * np.abs(rows[3]).max() * np.random.default_rng(9).normal(size=300)
    return out


def scaled(row: int, factor: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda rows: rows * np.where(np.arange(4) == row, factor, 1.0)[:, None]


def late(row: int, samples: int) -> Callable[[np.ndarray], np.ndarray]:
    return lambda rows: np.vstack([np.roll(r, samples) if k == row else r for k, r in enumerate(rows)])


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (scaled(2, 10.0), "channel a2 is 10 times what it is in the other hits"),
        (scaled(1, -1.0), "channel a1 is -1 times what it is in the other hits"),
        (scaled(0, 0.5), "its force is 0.5 times what it is in the other hits"),
        (late(3, 5), "channel a3 is 1 times what it is in the other hits there, and 5 samples late"),
        (late(0, -4), "its force is 1 times what it is in the other hits there, and 4 samples early"),
        (lambda rows: rows[[0, 2, 1, 3]], "channel a1 is 1 times what a2 is in the other hits"),
        (loose, r"channel a3 does not follow the force as in the other hits there, from 0\.34"),
    ],
    ids=["range", "turned", "force", "late", "force early", "swapped", "cable"],
)
def test_a_hit_at_fault_is_left_out_with_what_is_wrong(harm: Callable[[np.ndarray], np.ndarray], said: str) -> None:
    rows = hits()
    rows[1] = harm(rows[1])
    result = identify_campaign(campaign_of(rows), IdentificationOptions())
    (model,) = (item.model for item in result.identified)
    (note,) = (note for note in model.notes if "hit_1" in note)

    assert re.search(said, note)
    np.testing.assert_allclose(model.frequency_hz, FREQUENCY, rtol=1e-4)
    found = np.array(model.modal_constants)[:, :, 0].real
    np.testing.assert_allclose(found, SHAPES * SHAPES[:, :1], rtol=0.01)


def test_hits_that_scatter_about_their_point_stay() -> None:
    random = np.random.default_rng(4)
    rows = []
    for seed, peak in enumerate(random.uniform(20, 100, 6)):
        # The place of a hit moves what it gives to each mode.
        moved = SHAPES.copy()
        moved[:, 0] *= random.normal(1, 0.08, 2)
        rows.append(record(peak, seed, moved))
    kept, _, notes = usable_blocks(campaign_of(rows), campaign_of(rows).blocks)
    assert len(kept) == 6
    assert not notes


def test_of_two_hits_that_differ_neither_is_blamed() -> None:
    rows = hits()[:2]
    rows[1] = scaled(2, 10.0)(rows[1])
    campaign = campaign_of(rows)
    kept, _, _ = usable_blocks(campaign, campaign.blocks)
    assert len(kept) == 2


def unplugged(rows: np.ndarray) -> np.ndarray:
    out = rows.copy()
    out[2, 900:] = 1e-4 * np.abs(rows[2]).max() * np.random.default_rng(5).normal(size=N - 900)
    return out


def shortened(rows: np.ndarray) -> np.ndarray:
    out = rows.copy()
    out[3] = np.r_[rows[3, :800], rows[3, 820:], rows[3, 40:60]]
    return out


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (unplugged, r"channel a2 holds only noise from 0\.4[34]"),
        (shortened, r"channel a3 lacks 20 samples from 0\.3[89]"),
    ],
    ids=["unplugged", "lost"],
)
def test_a_channel_that_changes_late_is_named_though_the_frf_hardly_shows_it(
    harm: Callable[[np.ndarray], np.ndarray], said: str
) -> None:
    rows = hits()
    rows[3] = harm(rows[3])
    kept, _, notes = usable_blocks(campaign_of(rows), campaign_of(rows).blocks)
    assert [s.block.name for s in kept] == ["hit_0", "hit_1", "hit_2"]
    assert re.search(said, notes[0])


def cut_off(share: float) -> Callable[[np.ndarray], np.ndarray]:
    """The force does not pass a share of its peak; noise of the converter lies behind."""

    def harm(rows: np.ndarray) -> np.ndarray:
        out = rows.copy()
        noise = np.random.default_rng(3).normal(size=N) * 1e-4 * rows[0].max()
        out[0] = np.minimum(rows[0], share * rows[0].max()) + noise
        return out

    return harm


@pytest.mark.parametrize("share", [0.6, 0.75, 0.85])
def test_a_force_that_is_cut_off_beneath_its_noise_is_named_by_its_top_or_by_the_responses(share: float) -> None:
    rows = hits()
    rows[1] = cut_off(share)(rows[1])
    kept, _, notes = usable_blocks(campaign_of(rows), campaign_of(rows).blocks)
    assert [s.block.name for s in kept] == ["hit_0", "hit_2", "hit_3"]
    assert re.search(r"hit_1.*(flat tops at|its force is cut off at \d+(\.\d+)? N: the responses ask for)", notes[0])


def test_a_second_contact_is_named_and_stays_in_the_model() -> None:
    rows = hits()
    again = record(30.0, 7)
    rows[2] = rows[2] + np.roll(again, 800, axis=1) * (np.arange(N) >= 800)
    kept, _, notes = usable_blocks(campaign_of(rows), campaign_of(rows).blocks)
    assert len(kept) == 4
    assert [n for n in notes if re.search(r"hit_2: the force has a second contact of 3\d(\.\d)? % from 0\.43", n)]
