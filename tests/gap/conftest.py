"""A small campaign made by the twin itself, with noise and rounding: cheap, and its truth is known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from twin_campaign import LENGTH, LINES, NOISE, bench, make_hit, sine

from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.core.rig import Rig


@pytest.fixture(scope="session")
def rig() -> Rig:
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


@pytest.fixture(scope="session")
def make(rig: Rig) -> Callable[..., Campaign]:
    """Campaign of a bench with effects; `spoil` may change the volts (rows, n) of each record."""

    def build(
        *effects: Effect,
        seed: int = 1,
        tests: tuple[str, ...] = ("impact", "sine"),
        spoil: Callable[[np.ndarray, Block], np.ndarray] = lambda volts, _: volts,
    ) -> Campaign:
        rng = np.random.default_rng(seed)
        twin = bench(rig, effects)
        blocks: list[Block] = []
        if "impact" in tests:
            blocks += [make_hit(rig, twin, point, hit, rng, spoil) for point in (6, 10, 3) for hit in range(2)]
        if "sine" in tests:
            blocks += [sine(rig, twin, line, level, rng, spoil) for level in ("low", "high") for line in LINES]
        blocks = [replace(b, order=i) for i, b in enumerate(blocks)]
        return Campaign(rig, tuple(blocks), source="made by the test")

    return build
