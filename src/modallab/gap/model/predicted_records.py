"""Records of a campaign and what the twin says they read."""

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import harmonic, hit, on_line, rise_of, scaled
from modallab.twin.bench import Twin
from modallab.twin.predict import predict_hit, predict_sine

Array = NDArray[np.float64]


def hit_only(force: Array) -> Array:
    """The force with everything but the hit set to zero."""
    pulse, start = hit(force)
    windowed = np.zeros_like(force)
    windowed[start : start + len(pulse)] = pulse[: len(force) - start]
    return windowed


def predict_record(twin: Twin, rig: Rig, block: Block, last_order: float, ratio: float = 1.0) -> Array:
    """(channels, n) in m/s^2 at nominal sensitivities: one record from its measured force.

    Args:
        twin: the bench.
        rig: the bench as believed.
        block: the record; only its force is read.
        last_order: place in time of its campaign's last record.
        ratio: seen frequency of the sines over what was set.
    """
    force, _ = scaled(block, rig)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    drive, tau = rig.x_of(block.drive_point or 0), block.order / last_order
    if block.test == "impact":
        return predict_hit(twin, hit_only(force), block.rate_hz, drive, channels, x, tau)
    n, dt = block.n_samples, 1 / block.rate_hz
    f0 = on_line(block.frequency_hz or 0.0, n, dt) * ratio
    amplitude = harmonic(force, f0, dt)
    return predict_sine(twin, amplitude, f0, n, block.rate_hz, drive, channels, x, tau, rise_of([block]))
