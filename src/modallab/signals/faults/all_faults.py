"""All faults that the samples of a block show."""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.core.units import Quantity
from modallab.signals.faults.drop_outs import drop_outs
from modallab.signals.faults.flat_tops import flat_tops
from modallab.signals.faults.repeats import Fault, repeated_in_all_channels, repeated_values, steps_of
from modallab.signals.faults.spikes import find_spikes
from modallab.signals.faults.whole_channels import constant_channels, is_dead_channel, is_zero_drift, overloads
from modallab.signals.hit import find_hit

LEAST_SAMPLES = 64
"""Fewer show too little of how a channel moves."""


def faults_of(block: Block, rig: Rig) -> tuple[Fault, ...]:
    """Faults of the chain in a block: overloads, dead channels, flat tops, held values, drop-outs, drift, lone values.

    Each needs what no sound channel does, whatever its noise and resolution; limits are given with each kind.

    Args:
        block: finite samples (channels, n).
        rig: which channels are forces.
    """
    if over := overloads(block, rig):
        return over
    rows = block.samples.astype(np.float64)
    found = list(constant_channels(rows, block.channels, [c.name for c in rig.forces[: len(block.driven_points)]]))
    if block.n_samples < LEAST_SAMPLES:
        return tuple(found)
    steps = np.stack([steps_of(row) for row in rows])
    quantities = {channel.name: channel.quantity for channel in rig.channels}
    for row, name, step in zip(rows, block.channels, steps, strict=True):
        noise = _noise_of_hit(row) if block.test == "impact" and quantities.get(name) == "force" else None
        found += _faults_of_row(row, name, step, block.rate_hz, quantities.get(name), noise)
    return (
        *found,
        *repeated_in_all_channels(rows, block.rate_hz, block.channels, steps),
        *find_spikes(rows, block.rate_hz, block.channels, steps),
    )


def _noise_of_hit(row: Real) -> float | None:
    try:
        return find_hit(row).noise
    except DataError:
        return None


def _faults_of_row(
    row: Real, name: str, steps: Real, rate_hz: float, quantity: Quantity | None, noise: float | None
) -> tuple[Fault, ...]:
    if found := is_dead_channel(row, name, steps):
        return found
    tops = flat_tops(row, rate_hz, name, steps, noise)
    held = repeated_values(row, rate_hz, name, steps)
    # What is held everywhere has no drop-outs of its own; neither has a channel at the end of its range.
    lost = () if tops or held else drop_outs(row, rate_hz, name, steps, force=quantity == "force")
    # Only accelerations keep their mean: a structure may end where it was not, and a force may be let go.
    return (*tops, *held, *lost, *(is_zero_drift(row, rate_hz, name) if quantity == "acceleration" else ()))
