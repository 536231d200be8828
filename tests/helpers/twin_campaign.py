"""A small campaign made by the twin itself, block by block."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig
from modallab.core.units import Broadband, si_factor
from modallab.frf.broadband import PERIODIC
from modallab.signals.alignment import lags_s
from modallab.twin.bench import MeasurementChain, Twin
from modallab.twin.effects import apply_effect
from modallab.twin.predict import predict_hit, predict_sine
from modallab.twin.structure import TwinStructure

LENGTH = 1.0
STEP, NOISE = 10 / 32768, 0.0003
LINES = (3, 5, 6, 12, 24, 30, 32, 40, 60, 84, 90, 108)


def bench(rig: Rig, effects: tuple[Effect, ...]) -> Twin:
    assert rig.beam is not None
    structure = TwinStructure.of(rig.beam, 0.006)
    zeta = structure.zeta * np.linspace(0.7, 1.5, len(structure.zeta))
    lags = lags_s(rig)
    # The force is written down as it acts: the others lag it, or are ahead.
    chain = MeasurementChain.of(rig).as_delivered(rig, lags - lags[rig.force_channel.index])
    twin = Twin(replace(structure, youngs_modulus_pa=2.06e11, density_kg_m3=7840.0, zeta=zeta), chain)
    for effect in effects:
        twin = apply_effect(twin, effect, rig)
    return twin


def _finish(rig: Rig, block: Block, force: np.ndarray, answer: np.ndarray, rng: np.random.Generator, spoil) -> Block:
    sign = np.array([1.0 if c.direction == rig.drive_direction else -1.0 for c in rig.channels])
    per_si = [c.sensitivity(block.test) / si_factor(c.quantity, c.unit) for c in rig.channels]
    volts = np.vstack([force, answer]) * (sign * per_si)[:, None]
    volts = spoil(volts + NOISE * rng.standard_normal(volts.shape), block)
    return replace(block, samples=np.clip(np.round(volts / STEP), -32768, 32767).astype(np.int16))


def _block(rig: Rig, name: str, test: str, rate: float, point: int, **more) -> Block:
    names = tuple(c.name for c in rig.channels)
    rows = len(names)
    empty = np.zeros((rows, 1), dtype=np.int16)
    return Block(name, test, 0, rate, empty, np.full(rows, STEP), ("V",) * rows, names, drive_point=point, **more)


def make_hit(rig: Rig, twin: Twin, point: int, hit: int, rng: np.random.Generator, spoil) -> Block:
    n, start = 2048, 100 + int(rng.integers(0, 3))
    force = np.zeros(n)
    force[start : start + 9] = 60 * rng.uniform(0.8, 1.2) * np.hanning(9)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    answer = predict_hit(twin, force, 2000.0, LENGTH * point / 10, channels, x, 0.0)
    return _finish(
        rig,
        _block(rig, f"impact_p{point:02d}_{hit}", "impact", 2000.0, point),
        force * twin.chain.force_gain,
        answer * twin.chain.force_gain,
        rng,
        spoil,
    )


def sine(rig: Rig, twin: Twin, line: int, level: str, rng: np.random.Generator, spoil) -> Block:
    n, hz = 1024, line / 1.024
    amplitude = {"low": 0.1, "high": 0.4}[level] * np.exp(1j * rng.uniform(0, 2 * np.pi))
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    answer = predict_sine(twin, complex(amplitude), hz, n, 1000.0, 0.4 * LENGTH, channels, x, 0.5)
    force = np.real(amplitude * np.exp(2j * np.pi * hz * np.arange(n) / 1000.0))
    block = _block(rig, f"sine_{level}_{hz:07.3f}", "sine", 1000.0, 4, level=level, frequency_hz=round(hz, 3))
    return _finish(rig, block, force * twin.chain.force_gain, answer * twin.chain.force_gain, rng, spoil)


def drive(rig: Rig, twin: Twin, test: Broadband, rng: np.random.Generator, blocks: int = 3) -> list[Block]:
    """Blocks of a drive of 2 to 200 Hz that follow each other and begin from rest."""
    n, rate = 4096, 500.0
    hz = np.fft.rfftfreq(n if test in PERIODIC else blocks * n, 1 / rate)
    phase = np.pi * n / rate * hz**2 / 200 if test == "chirp" else rng.uniform(0, 2 * np.pi, hz.size)
    spectrum = np.where((hz > 2) & (hz < 200), np.exp(-1j * phase), 0)
    force = np.fft.irfft(spectrum)
    force = np.resize(0.4 * force / force.std(), blocks * n)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    answer = predict_hit(twin, force, rate, 0.4 * LENGTH, channels, x, 0.0)
    whole = _finish(rig, _block(rig, test, test, rate, 4), force, answer, rng, lambda volts, _: volts)
    return [
        replace(whole, name=f"{test}_{k}", order=k, samples=whole.samples[:, k * n : (k + 1) * n], first_sample=k * n)
        for k in range(blocks)
    ]


def link() -> Rig:
    """What the operator believes of the bench."""
    channels = [
        {
            "index": 0,
            "name": "force",
            "quantity": "force",
            "unit": "N",
            "sensitivity_v_per_unit": {"impact": 0.02, "sine": 0.5},
        }
    ]
    channels += [
        {
            "index": k,
            "name": f"a{k:02d}",
            "quantity": "acceleration",
            "unit": "m/s^2",
            "point": k,
            "sensitivity_v_per_unit": {"impact": 0.01, "sine": 0.1},
        }
        for k in range(1, 11)
    ]
    return Rig.model_validate(
        {
            "name": "test link",
            "beam": {
                "length_m": LENGTH,
                "width_m": 0.05,
                "thickness_m": 0.006,
                "youngs_modulus_pa": 2.05e11,
                "density_kg_m3": 7850.0,
            },
            "tolerance": {"youngs_modulus": 0.012, "thickness": 0.003, "density": 0.003},
            "points": [{"id": k, "x_m": LENGTH * k / 10} for k in range(1, 11)],
            "channels": channels,
            "converter": {"bits": 16, "range_v": 10.0, "noise_rms_v": NOISE},
            "shaker_point": 4,
        }
    )


def built(
    rig: Rig,
    *effects: Effect,
    seed: int = 1,
    tests: tuple[str, ...] = ("impact", "sine"),
    spoil: Callable[[np.ndarray, Block], np.ndarray] = lambda volts, _: volts,
    alter: Callable[[Twin], Twin] = lambda twin: twin,
) -> Campaign:
    """Campaign of a bench with effects; `spoil` may change the volts (rows, n) of each record, `alter` the bench."""
    rng = np.random.default_rng(seed)
    twin = alter(bench(rig, effects))
    blocks: list[Block] = []
    if "impact" in tests:
        blocks += [make_hit(rig, twin, point, hit, rng, spoil) for point in (6, 10, 3) for hit in range(2)]
    if "sine" in tests:
        blocks += [sine(rig, twin, line, level, rng, spoil) for level in ("low", "high") for line in LINES]
    blocks = [replace(b, order=i) for i, b in enumerate(blocks)]
    return Campaign(rig, tuple(blocks), source="made by the test")
