"""AC coupling that is not the same in all channels, undone.

A first-order high-pass with the corner omega_c reads y = x - v, where v, the voltage on its capacitor, follows
dv/dt = omega_c y. So x = y + v_0 + omega_c times the integral of y: exactly, whatever the signal, but for one constant
a block, which no line but that at 0 Hz holds. Channels with one common corner all turn alike, and are left as they are.
"""

import numpy as np

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_rate
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.signals.checks import check_channels, check_positive
from modallab.signals.hit import find_hit

MIN_PRE_TRIGGER = 16
"""Samples before a hit from which a channel's zero can be read."""

BLACKMAN_HARRIS = np.array([0.35875, -0.48829, 0.14128, -0.01168])

LEAST_SAMPLES = 8
"""Fewer hold neither a level nor an integral."""


def undo_ac_coupling(values: Real, rate_hz: float, rig: Rig, drive_hz: float | None = None) -> Real:
    """(channels, n) values of a block with the AC coupling of each channel undone, if the channels differ in it.

    What a channel reads at rest is no signal and would be integrated to a ramp, so it is taken off first: the level
    before the hit; or where `drive_hz` says that there is a sine, the constant beside it under a window in which what
    still decays leaves next to nothing.

    Raises:
        DataError: values that are no records of the rig's channels or too short, a rate or a frequency that is none.
    """
    _check(values, rate_hz, rig, drive_hz)
    corners = [channel.ac_corner_hz for channel in rig.channels]
    if len(set(corners)) == 1:
        return values
    if values.shape[1] < LEAST_SAMPLES:
        found = f"{values.shape[1]} samples are too few to undo AC coupling"
        raise DataError(found, remedy=f"record at least {LEAST_SAMPLES} samples")
    hit = drive_hz is None and rig.force is not None
    weights = _before_hit(values[rig.force_channel.index]) if hit else _four_term_window(values.shape[1])
    basis = _constant_and_sine(values.shape[1], rate_hz, drive_hz)
    rows = [
        row if corner == 0 else _undo_ac_coupling(row - _level_of_row(row, basis, weights), rate_hz, corner)
        for row, corner in zip(values, corners, strict=True)
    ]
    return np.stack(rows)


def _check(values: Real, rate_hz: float, rig: Rig, drive_hz: float | None) -> None:
    check_rate(rate_hz)
    check_channels(values, len(rig.channels))
    if drive_hz is None:
        return
    check_positive(drive_hz, "the sine's frequency in Hz")
    if drive_hz >= rate_hz / 2:
        found = f"a sine at {drive_hz:g} Hz cannot be seen at a rate of {rate_hz:g} Hz"
        raise DataError(found, remedy="check the rate and the frequency of the record")


def _undo_ac_coupling(row: Real, rate_hz: float, corner_hz: float) -> Real:
    # Imported here: next to all benches have one coupling, and are not kept waiting for it.
    from scipy.interpolate import CubicSpline

    # Straight lines between samples would err by (omega dt)^2 / 12 of the correction; a spline by next to nothing.
    t = np.arange(row.size) / rate_hz
    integral = CubicSpline(t, row).antiderivative()(t)
    return row + 2 * np.pi * corner_hz * integral


def _four_term_window(n: int) -> Real:
    """Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978): four terms, side lobes at -92 dB."""
    turn = 2 * np.pi * np.arange(n) / n
    return BLACKMAN_HARRIS @ np.cos(np.outer(np.arange(len(BLACKMAN_HARRIS)), turn))


def _before_hit(force: Real) -> Real:
    """Weights that see what is before the hit only, or, where there is too little of it, the whole block."""
    try:
        first = find_hit(force).first
    except DataError:
        first = 0
    return (
        (np.arange(force.size) < first).astype(np.float64)
        if first >= MIN_PRE_TRIGGER
        else _four_term_window(force.size)
    )


def _constant_and_sine(n: int, rate_hz: float, drive_hz: float | None) -> Real:
    if drive_hz is None:
        return np.ones((n, 1))
    angle = 2 * np.pi * drive_hz * np.arange(n) / rate_hz
    return np.column_stack([np.ones(n), np.cos(angle), np.sin(angle)])


def _level_of_row(row: Real, basis: Real, weights: Real) -> float:
    root = np.sqrt(weights)
    return float(np.linalg.lstsq(basis * root[:, None], row * root, rcond=None)[0][0])
