"""What the accelerometers read, sample by sample, from the measured force of a record that began from rest."""

from dataclasses import replace

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.twin.bench import MeasurementChain, Twin, chain_transfer, exchange_plugs
from modallab.twin.modes import TwinModes, solve_modes
from modallab.twin.nonlinear.element import couple_to_modes
from modallab.twin.nonlinear.records import (
    added_acceleration,
    element_response_in_hit,
    element_response_in_sine,
    prepared_steps,
)
from modallab.twin.response import HitsAtPoint, SineBlocks, SineStartUp


def predict_hit(
    twin: Twin, force_n: Real, rate_hz: float, drive_x_m: float, channels: tuple[int, ...], x_m: Real, tau: float
) -> Real:
    """(channels, n) what the chain reads of a hit: m/s^2, or m/s and m where it integrates.

    Args:
        twin: the bench.
        force_n: (n,) force in N, zero outside the hit.
        rate_hz: rate the record states.
        drive_x_m: point of the hit.
        channels: rows of the accelerometers.
        x_m: their places.
        tau: place of the record in the campaign's time, 0 to 1.
    """
    n, dt = len(force_n), 1 / rate_hz / (1 + twin.clock)
    modes = drifted_modes(solve_modes(twin.structure), twin.ei_drift, float(twin.share_of_drift(tau)))
    x = twin.struck_x_m(drive_x_m)
    struck = np.flatnonzero(force_n)
    first, last = (int(struck[0]), int(struck[-1]) + 1) if len(struck) else (0, 1)
    spectrum = np.fft.rfft(force_n)
    lines = np.arange(float(len(spectrum)))
    one = np.ones((1, len(lines)), dtype=np.complex128)
    source = HitsAtPoint(lines, n, dt, force_n[None, first:last], np.array([first]), one)
    residue = _outputs_of_modes(twin.chain, modes, channels, x_m) * modes.shapes_at(x)[0]
    forced_sum = np.zeros((len(channels), len(lines)), dtype=np.complex128)
    total = np.zeros_like(forced_sum)
    for poles, r in ((modes.poles, residue), (modes.poles.conj(), residue.conj())):
        forced, tail = source.response_to_unit_residue(poles)
        forced_sum += r @ forced
        total += (r * chain_transfer(twin.chain, channels, poles)) @ tail
    forced_sum += twin.residual_compliance * np.outer(_out_of_band_response(twin, modes, channels, x_m, x), source.s**2)
    chain = chain_transfer(twin.chain, channels, source.s)
    if twin.element is not None and len(struck):
        stiff = twin.modes_felt_by(modes)
        own = couple_to_modes(twin.element, twin.structure, stiff)
        gain = twin.hit_gain(drive_x_m)
        added = element_response_in_hit(prepared_steps(stiff, own, dt, x), gain * force_n[first:last], first, n)
        seen = added_acceleration(stiff, own, _outputs_of_modes(twin.chain, stiff, channels, x_m), added, dt)
        total += np.nan_to_num(chain) * np.fft.rfft(seen, axis=1) / gain
    # A high-pass has no answer at rest: 0 / 0 there.
    total += np.nan_to_num(chain) * forced_sum * spectrum
    record = twin.hit_gain(drive_x_m) * np.fft.irfft(total, n=n, axis=1)
    # An integral knows no constant: what begins from rest begins at 0.
    rows = [i for i, channel in enumerate(channels) if channel in twin.chain.integrals]
    record[rows] -= record[rows, :1]
    return exchange_plugs(twin.chain, channels, "impact", record)


def predict_sine(
    twin: Twin,
    amplitude_n: complex,
    frequency_hz: float,
    n: int,
    rate_hz: float,
    drive_x_m: float,
    channels: tuple[int, ...],
    x_m: Real,
    tau: float,
    rise: SineStartUp | None = None,
) -> Real:
    """(channels, n) accelerations in m/s^2 of a sine block, with what rings on from its start.

    Args:
        twin: the bench.
        amplitude_n: complex amplitude of the force: f(t) = Re(amplitude exp(j omega t)).
        frequency_hz: its frequency on the stated clock.
        n: samples.
        rate_hz: rate the record states.
        drive_x_m: point of the shaker.
        channels: rows of the accelerometers.
        x_m: their places.
        tau: place of the record in the campaign's time, 0 to 1.
        rise: of one block: how the sine came about; None for the usual.
    """
    dt = 1 / rate_hz / (1 + twin.clock)
    rise = rise or SineStartUp.usual(1)
    world_hz = frequency_hz * (1 + twin.clock)
    modes = drifted_modes(solve_modes(twin.in_sine(drive_x_m)), twin.ei_drift, float(twin.share_of_drift(tau)))
    source = SineBlocks(
        np.zeros((1, 1)), np.array([world_hz]), n, dt, np.array([amplitude_n]), rise.with_clock_error(twin.clock)
    )
    residue = _outputs_of_modes(twin.chain, modes, channels, x_m) * modes.shapes_at(drive_x_m)[0]
    t = np.arange(n) * dt
    drive = source.drive[0]
    up = np.zeros(len(channels), dtype=np.complex128)
    down, rings = np.zeros_like(up), np.zeros((len(channels), n))
    for poles, r in ((modes.poles, residue), (modes.poles.conj(), residue.conj())):
        a, b, decay = source.response_to_unit_residue(poles)
        up += r @ a[:, 0]
        down += r @ b[:, 0]
        # The kernel's decay is per n / 2 and per unit of the complex amplitude.
        weight = r * chain_transfer(twin.chain, channels, poles) * decay[:, 0] * n / 2 * amplitude_n
        rings += np.real(weight @ np.exp(poles[:, None] * t))
    residual = twin.residual_compliance * _out_of_band_response(twin, modes, channels, x_m, drive_x_m) * drive**2
    up, down = up + residual, down + residual
    steady = up * chain_transfer(twin.chain, channels, np.array(drive)) * amplitude_n
    steady_down = down * chain_transfer(twin.chain, channels, np.array(-drive)) * np.conj(amplitude_n)
    forced = np.real(np.outer(steady, np.exp(drive * t)) + np.outer(steady_down, np.exp(-drive * t))) / 2
    if twin.element is not None:
        stiff = twin.modes_felt_by(modes)
        own = couple_to_modes(twin.element, twin.in_sine(drive_x_m), stiff)
        began = source.rise
        times = float(began.history_s[0]), float(began.ramp_s[0]), bool(began.cosine[0])
        added = element_response_in_sine(
            prepared_steps(stiff, own, dt, drive_x_m), own.law, amplitude_n, world_hz, n, dt, *times
        )
        seen = np.fft.rfft(
            added_acceleration(stiff, own, _outputs_of_modes(twin.chain, stiff, channels, x_m), added, dt), axis=1
        )
        s = 2j * np.pi * np.fft.rfftfreq(n, dt)
        rings += np.fft.irfft(np.nan_to_num(chain_transfer(twin.chain, channels, s)) * seen, n=n, axis=1)
    return exchange_plugs(twin.chain, channels, "sine", forced + rings)


def drifted_modes(modes: TwinModes, ei_drift: float, tau: float) -> TwinModes:
    """Modes after EI has changed by its share of the drift."""
    if not ei_drift:
        return modes
    scale = float(np.sqrt(max(1e-3, 1 + ei_drift * tau)))
    return replace(
        modes,
        poles=modes.poles * scale,
        columns=modes.columns / np.sqrt(scale),
        out_of_band=modes.out_of_band / scale**2,
    )


def sensor_positions(chain: MeasurementChain, modes: TwinModes, channels: tuple[int, ...], x_m: Real) -> Real:
    """(channels,) places where the accelerometers truly sit, none beyond the beam's ends."""
    x = x_m + np.array([chain.shift.get(c, 0.0) for c in channels])
    return np.clip(x, 0.0, modes.length_m)


def _outputs_of_modes(chain: MeasurementChain, modes: TwinModes, channels: tuple[int, ...], x_m: Real) -> Complex:
    return modes.shapes_at(sensor_positions(chain, modes, channels, x_m))


def _out_of_band_response(twin: Twin, modes: TwinModes, channels: tuple[int, ...], x_m: Real, drive_x_m: float) -> Real:
    return modes.remainder(sensor_positions(twin.chain, modes, channels, x_m), drive_x_m)
