"""Poles of the ring-down after the hits, without any model of the beam: where the fits begin.

An eigensystem realization of the decays of all accelerometers after hits. Their inputs are not known, so that the poles
come from the shift of the observability matrix alone.
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import hit_with_filter_ringing
from modallab.identification.realization import block_hankel, state_poles
from modallab.signals.signals import to_signals

ROWS = 24
"""Block rows of the Hankel matrix."""
LEAST_S = 0.25
"""Ring-down from which poles can be had."""
ORDERS = (16, 20, 24)
"""Model orders that must agree on a pole."""


def ring_down_poles(blocks: Sequence[Block], rig: Rig, keep: Sequence[int], top_hz: float = 260.0) -> Complex:
    """Poles with 0 < frequency < top_hz that several model orders agree on, sorted by frequency; rad/s.

    Args:
        blocks: hits.
        rig: the bench.
        keep: indices of the accelerometers to use.
        top_hz: end of the band.
    """
    decays = [d for b in blocks if (d := _decay_after_hit(b, rig, keep, top_hz)) is not None]
    if not decays:
        return np.zeros(0, dtype=np.complex128)
    dt = decays[0][1]
    n = min(d.shape[1] for d, _ in decays)
    columns = n - ROWS
    hankel = np.concatenate([block_hankel(d[:, None], ROWS, columns) / np.linalg.norm(d) for d, _ in decays], axis=1)
    # It has far more columns than rows, of which only the left singular vectors are needed.
    values, vectors = np.linalg.eigh(hankel @ hankel.T)
    left = vectors[:, ::-1] * np.sqrt(np.maximum(values[::-1], 0))
    sets = [_poles_of(left[:, :order], len(keep), dt, top_hz) for order in ORDERS]
    agreed = [p for p in sets[-1] if all(len(s) and np.min(np.abs(s - p)) < 0.004 * abs(p) for s in sets[:-1])]
    return np.array(sorted(agreed, key=abs), dtype=np.complex128)


def _decay_after_hit(block: Block, rig: Rig, keep: Sequence[int], top_hz: float) -> tuple[Real, float] | None:
    """(channels, n) after the hit, and s between samples; None where next to nothing comes after it."""
    signals = to_signals(block, rig)
    motion, start = signals.responses, hit_with_filter_ringing(signals).stop
    step = max(1, int(block.rate_hz / (2.2 * top_hz)))
    length = motion.shape[1] - start
    if length < LEAST_S * block.rate_hz:
        return None
    spectrum = np.fft.rfft(motion[list(keep), start:], axis=1)
    hz = np.fft.rfftfreq(length, 1 / block.rate_hz)
    smooth = np.fft.irfft(spectrum * (1 / (1 + (hz / (1.05 * top_hz)) ** 16)), n=length, axis=1)
    # The cut at both ends rings under the filter: leave those samples out.
    edge = int(block.rate_hz / top_hz)
    return smooth[:, edge : length - edge : step], step / block.rate_hz


def _poles_of(left: Real, outputs: int, dt: float, top_hz: float) -> Complex:
    shift = np.linalg.lstsq(left[:-outputs], left[outputs:], rcond=None)[0]
    poles = state_poles(shift, dt)
    zeta = -poles.real / np.abs(poles)
    good = (poles.imag > 2 * np.pi) & (poles.imag < 2 * np.pi * top_hz) & (zeta > -0.01) & (zeta < 0.3)
    return poles[good].astype(np.complex128)
