"""A resonance that goes with its amplitude is one mode with a backbone: harmonic balance of a cubic spring."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modallab.core.block import Block, Campaign
from modallab.core.rig import Channel, Point, Rig
from modallab.frf.estimate import impact_frf
from modallab.identification.backbone import DriveLevel, backbone_notes, backbone_of, is_nonlinear
from modallab.identification.options import IdentificationOptions
from modallab.pipelines.identify import identify_campaign, usable_blocks
from modallab.signals.signals import Signals

RATE_HZ, SAMPLES, STEPS = 1024.0, 2048, 6
MASS, HZ, ZETA = 2.0, 30.0, 0.006
OMEGA = 2 * np.pi * HZ
RIG = Rig(
    name="cubic spring",
    model="unknown",
    points=(Point(id=1, x_m=0.0),),
    channels=(
        Channel(index=0, name="force", quantity="force", unit="N", point=1),
        Channel(index=1, name="a1", quantity="acceleration", unit="m/s^2", point=1),
    ),
)


def hit(newton: float, cubic: float, order: int) -> Block:
    """One mass on a spring with a cubic part, hit for 10 ms, by Runge and Kutta's fourth order."""
    h, n = 1 / (RATE_HZ * STEPS), SAMPLES * STEPS
    t = np.arange(2 * n + 1) * h / 2
    force = newton * np.sin(np.pi * np.clip((t - 0.05) / 0.01, 0, 1)) ** 2
    half, x, v = force.tolist(), 0.0, 0.0
    rows = np.empty(SAMPLES)

    def acceleration(f: float, x: float, v: float) -> float:
        return (f - cubic * x**3) / MASS - OMEGA**2 * x - 2 * ZETA * OMEGA * v

    for k in range(n):
        f0, f1, f2 = half[2 * k], half[2 * k + 1], half[2 * k + 2]
        a = acceleration(f0, x, v)
        if k % STEPS == 0:
            rows[k // STEPS] = a
        b = acceleration(f1, x + h / 2 * v, v + h / 2 * a)
        c = acceleration(f1, x + h / 2 * v + h * h / 4 * a, v + h / 2 * b)
        d = acceleration(f2, x + h * v + h * h / 2 * b, v + h * c)
        x, v = x + h * v + h * h * (a + b + c) / 6, v + h * (a + 2 * b + 2 * c + d) / 6
    noise = np.random.default_rng(order).normal(size=(2, SAMPLES)) * [[0.01], [0.002]]
    samples = np.stack([force[: 2 * n : 2 * STEPS], rows]) + noise
    return Block(
        name=f"hit_{order}",
        test="impact",
        order=order,
        rate_hz=RATE_HZ,
        samples=samples,
        scale=np.ones(2),
        units=("N", "m/s^2"),
        channels=("force", "a1"),
        drive_point=1,
    )


@cache
def campaign(cubic: float) -> Campaign:
    return Campaign(RIG, tuple(hit(newton, cubic, k) for k, newton in enumerate((15, 15, 50, 50, 90, 90))))


CUBIC = 5e9
"""In N/m^3: the hardest hit bends the resonance by some of its widths."""


def levels_of(signals: list[Signals]) -> list[DriveLevel]:
    pairs = [signals[0:2], signals[2:4], signals[4:6]]
    shift = np.log(300.0) * RATE_HZ / SAMPLES
    return [
        DriveLevel(str(k), impact_frf([p], RIG, (10.0, 100.0), damping_shift=shift), p) for k, p in enumerate(pairs)
    ]


def test_frequency_follows_the_square_of_the_amplitude_with_one_sensor() -> None:
    signals, _, _ = usable_blocks(campaign(CUBIC), campaign(CUBIC).of("impact"))
    weak = replace(campaign(CUBIC), blocks=campaign(CUBIC).blocks[:2])
    model = identify_campaign(weak, IdentificationOptions(band_hz=(10.0, 100.0))).identified[0].model
    found = backbone_of(model, levels_of(signals)).backbone
    mode = int(np.argmin(np.abs(model.frequency_hz - HZ)))
    expected = HZ + 3 * CUBIC * found.amplitude_m[mode] ** 2 / (8 * MASS * OMEGA) / (2 * np.pi)
    assert expected[-1] - HZ > 0.5
    np.testing.assert_allclose(found.frequency_hz[mode] - HZ, expected - HZ, rtol=0.12)
    assert is_nonlinear(found)[mode]
    assert "hardens" in backbone_notes(found)[0]


@pytest.mark.thorough("identifies six hits twice")
def test_a_resonance_that_hardens_is_one_mode_and_called_nonlinear() -> None:
    (found,) = identify_campaign(campaign(CUBIC), IdentificationOptions(band_hz=(10.0, 100.0))).identified
    near = found.model.frequency_hz[np.abs(found.model.frequency_hz / HZ - 1) < 0.2]
    assert near.size == 1
    assert near[0] == pytest.approx(HZ, rel=3e-3)
    assert found.model.backbone is not None
    assert any(note.startswith("Nonlinear: mode 1 hardens") for note in found.model.notes)


def test_a_linear_structure_has_no_backbone() -> None:
    (found,) = identify_campaign(campaign(0.0), IdentificationOptions(band_hz=(10.0, 100.0))).identified
    assert found.model.backbone is None
    np.testing.assert_allclose(found.model.frequency_hz, [HZ], rtol=1e-4)
