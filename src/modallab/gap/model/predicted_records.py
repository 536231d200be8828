"""Records of a campaign and what the twin says they read."""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import force_amplitude, frequency_on_line, hit_with_filter_ringing, onset_of_sines
from modallab.signals.hit import windowed_force
from modallab.signals.signals import to_signals
from modallab.twin.bench import Twin
from modallab.twin.predict import predict_hit, predict_sine


def predict_record(twin: Twin, rig: Rig, block: Block, last_order: float, ratio: float = 1.0) -> Real:
    """(channels, n) in SI units along the drive: one record from its measured force.

    Args:
        twin: the bench.
        rig: the bench as believed.
        block: the record; only its force is read.
        last_order: place in time of its campaign's last record.
        ratio: seen frequency of the sines over what was set.
    """
    signals = to_signals(block, rig)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    drive, tau = rig.x_of(block.drive_point or 0), block.order / last_order
    if block.test == "impact":
        force = windowed_force(signals.force, hit_with_filter_ringing(signals))
        return predict_hit(twin, force, block.rate_hz, drive, channels, x, tau)
    n, dt = block.n_samples, 1 / block.rate_hz
    f0 = frequency_on_line(block.frequency_hz or 0.0, n, dt) * ratio
    amplitude = force_amplitude(signals, f0)
    return predict_sine(twin, amplitude, f0, n, block.rate_hz, drive, channels, x, tau, onset_of_sines([block]))
