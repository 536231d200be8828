"""Which block and which sensor stand for a test in a figure."""

import numpy as np

from modallab.core.block import Block, Campaign
from modallab.core.rig import Rig
from modallab.core.units import Test

PAPER_SINE_HZ = 28 / 1.024
"""27.34 Hz, FFT line 28: the sine test the paper draws."""


def example_block(campaign: Campaign, test: Test) -> Block | None:
    """The block a figure shows: the sine block nearest to the paper's, or the first hit; None if there is none."""
    blocks = campaign.of(test)
    if test == "sine":
        blocks = tuple(b for b in blocks if b.frequency_hz is not None)
        return min(blocks, key=lambda b: abs((b.frequency_hz or 0) - PAPER_SINE_HZ), default=None)
    return blocks[0] if blocks else None


def farthest_sensor(rig: Rig, outputs: tuple[str, ...]) -> int:
    """Place among `outputs` of the sensor farthest from the clamp (the paper's point 10); the last if none has one."""
    x = [distance_from_clamp(rig, name) for name in outputs]
    known = [i for i, value in enumerate(x) if np.isfinite(value)]
    return max(known, key=lambda i: x[i]) if known else len(outputs) - 1


def distance_from_clamp(rig: Rig, output: str) -> float:
    """Distance of a channel from the clamp in m; NaN if its place is not known."""
    point = next((c.point for c in rig.channels if c.name == output), None)
    return float("nan") if point is None else rig.x_of(point)


def sensor_label(output: str, point: int | None) -> str:
    """How a sensor is called in a figure: by its point, else by its channel."""
    return f"Point {point}" if point is not None else f"Channel {output}"
