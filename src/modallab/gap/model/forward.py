"""The twin's answer on the reduced data.

Modal superposition with a residual term for the modes left out (Ewins, Modal Testing, 2000), each pole through the cut-
off block as in `modallab.twin.response`. A drift scales EI, so poles by sqrt(EI) at constant damping ratios.
"""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import (
    force_amplitude,
    frequency_on_line,
    hit_with_filter_ringing,
    start_up_of_sines,
)
from modallab.gap.conditioning.rows import DataPiece, ImpactData, Reduced, SineData
from modallab.gap.model.added_motion import added_to_hits, added_to_sines
from modallab.signals.hit import windowed_force
from modallab.signals.signals import to_signals
from modallab.twin.bench import MeasurementChain, Twin, chain_transfer, exchange_plugs
from modallab.twin.modes import TwinModes, solve_modes
from modallab.twin.predict import predict_hit, predict_sine, sensor_positions
from modallab.twin.response import AveragedFrfs, HitsAtPoint, SineBlocks

S = TypeVar("S", HitsAtPoint | AveragedFrfs, SineBlocks)

APART = 0.003
"""Drift from which hits at one point are no longer alike: their mean then answers as no beam does."""


def forward(twin: Twin, data: Reduced) -> list[Complex]:
    """What the twin says the reduced data are: (channels, rows) for each drive point, then for the sine test."""
    modes = solve_modes(twin.structure)
    hung = with_shaker(twin, modes, data)
    answers = [_impact(twin, hung if d.piece.by_shaker else modes, d, data) for d in data.impacts]
    if data.sines is not None:
        answers.append(_sines(twin, hung, data.sines, data))
    return answers


def with_shaker(twin: Twin, modes: TwinModes, data: Reduced) -> TwinModes:
    """The modes while the shaker hangs on the beam: those without it where it adds nothing, or drove nothing."""
    x = data.shaker_x_m
    structure = twin.structure if x is None else twin.in_sine(x)
    return modes if structure is twin.structure else solve_modes(structure)


def _impact(twin: Twin, modes: TwinModes, d: ImpactData, data: Reduced) -> Complex:
    poles, residue = impact_residue(twin, modes, d, data)
    source = with_clock_error(d.source, twin)
    total: Complex = np.zeros(d.rows.y.shape, dtype=np.complex128)
    forced_sum = impact_residual(twin, modes, d, data)[:, None] * source.s**2
    for pole, r in ((poles, residue), (poles.conj(), residue.conj())):
        forced, tail = source.response_to_unit_residue(pole, frequency_ratios_of_hits(twin, d, data))
        forced_sum += r @ forced
        total += (r * chain_transfer(twin.chain, data.channels, pole)) @ tail
    # The FRF of a drive is that of the best linear approximation: it says nothing of a law.
    if twin.element is not None and isinstance(source, HitsAtPoint):
        forced_sum += added_to_hits(twin, modes, d, source, data)
    total += chain_transfer(twin.chain, data.channels, source.s) * forced_sum
    return exchange_plugs(twin.chain, data.channels, d.piece.test, total)


def impact_residue(twin: Twin, modes: TwinModes, d: ImpactData, data: Reduced) -> tuple[Complex, Complex]:
    """(p,) poles and (channels, p) displacement residues of hits at one point, drift included."""
    scale = float(frequency_scale_of_drift(twin, d.piece.order, data))
    x, gain = drive_point_and_gain(twin, d.piece)
    drive = modes.shapes_at(x)[0] * gain
    return modes.poles * scale, _outputs(twin.chain, modes, data) * drive / scale


def drive_point_and_gain(twin: Twin, piece: DataPiece) -> tuple[float, float]:
    """Place of the force in m, and what the beam gets of it over what is read: a shaker is screwed on, a hit is not."""
    x = piece.drive_x_m
    return (x, 1.0) if piece.by_shaker else (twin.struck_x_m(x), twin.hit_gain(x))


def frequency_scale_of_drift(twin: Twin, order: float | Real, data: Reduced) -> Real:
    """Factor that a drift has put on all frequencies at a place in time, in records."""
    return np.sqrt(np.maximum(1e-3, 1 + twin.ei_drift * twin.share_of_drift(order / data.last_order)))


def frequency_ratios_of_hits(twin: Twin, d: ImpactData, data: Reduced) -> Real | None:
    """(hits,) frequencies at each hit over those at their mean place in time; None where a mean hit says it all."""
    if abs(twin.ei_drift) < APART or not d.piece.orders:
        return None
    return frequency_scale_of_drift(twin, np.array(d.piece.orders), data) / frequency_scale_of_drift(
        twin, d.piece.order, data
    )


def impact_residual(twin: Twin, modes: TwinModes, d: ImpactData, data: Reduced) -> Real:
    """(channels,) static displacement per N of hits at one point that the modes left out add, drift included."""
    drive, gain = drive_point_and_gain(twin, d.piece)
    softer = float(frequency_scale_of_drift(twin, d.piece.order, data)) ** 2
    share = twin.residual_compliance / softer * gain
    return share * modes.remainder(_sensor_positions(twin.chain, modes, data), drive)


def sine_residual(twin: Twin, modes: TwinModes, d: SineData, data: Reduced, scale: Real | None) -> Real:
    """(channels, blocks) the same in the sine test."""
    softer = np.ones(len(d.pieces)) if scale is None else scale**2
    static = modes.remainder(_sensor_positions(twin.chain, modes, data), d.pieces[0].drive_x_m)
    return twin.residual_compliance * np.outer(static, 1 / softer)


def with_clock_error(source: S, twin: Twin) -> S:
    """The source on the clock of the world."""
    if not twin.clock:
        return source
    if isinstance(source, SineBlocks):
        hz, rise = source.frequency_hz * (1 + twin.clock), source.rise.with_clock_error(twin.clock)
        return replace(source, dt=source.dt / (1 + twin.clock), frequency_hz=hz, rise=rise)
    return replace(source, dt=source.dt / (1 + twin.clock))


def sine_drift(twin: Twin, d: SineData, data: Reduced) -> Real | None:
    """(blocks,) factor on the frequencies at each block; None without a drift."""
    if not twin.ei_drift:
        return None
    return frequency_scale_of_drift(twin, np.array([p.order for p in d.pieces]), data)


def sine_residue(
    twin: Twin, modes: TwinModes, d: SineData, data: Reduced, scale: Real | None
) -> tuple[Complex, Complex]:
    """(p,) or (p, blocks) poles and (channels, p) residues of the sine test, those without drift."""
    poles = modes.poles if scale is None else modes.poles[:, None] * scale
    return poles, _outputs(twin.chain, modes, data) * modes.shapes_at(d.pieces[0].drive_x_m)[0]


def _sines(twin: Twin, modes: TwinModes, d: SineData, data: Reduced) -> Complex:
    source = with_clock_error(d.source, twin)
    scale = sine_drift(twin, d, data)
    poles, residue = sine_residue(twin, modes, d, data, scale)
    up = sine_residual(twin, modes, d, data, scale) * source.drive**2
    down = up.copy()
    rings = np.zeros((len(data.channels), *source.lines.shape), dtype=np.complex128)
    for pole, r in ((poles, residue), (poles.conj(), residue.conj())):
        a, b, decay = source.response_to_unit_residue(pole)
        if scale is not None:
            a, b, decay = a / scale, b / scale, decay / scale
        up += r @ a
        down += r @ b
        amplitude = r[:, :, None] * decay * chain_at_poles(twin.chain, data, pole)
        shape = source.decay_shape(pole)
        rings += np.moveaxis(np.moveaxis(amplitude, 2, 0) @ np.moveaxis(shape, 1, 0), 0, 1)
    at_up, at_down = (chain_transfer(twin.chain, data.channels, sign * source.drive) for sign in (1, -1))
    share_up, share_down = source.shares()
    if twin.element is not None:
        rings += chain_transfer(twin.chain, data.channels, source.s) * added_to_sines(twin, modes, d, source, data)
    total = rings + (up * at_up)[:, :, None] * share_up + (down * at_down)[:, :, None] * share_down
    return exchange_plugs(twin.chain, data.channels, "sine", total.reshape(len(data.channels), -1))


def chain_at_poles(chain: MeasurementChain, data: Reduced, pole: Complex) -> Complex:
    """(channels, p, blocks or 1) what the chain makes of a decay at each pole."""
    values = chain_transfer(chain, data.channels, pole)
    return values if values.ndim == 3 else values[:, :, None]


def _sensor_positions(chain: MeasurementChain, modes: TwinModes, data: Reduced) -> Real:
    return sensor_positions(chain, modes, data.channels, data.x_m)


def _outputs(chain: MeasurementChain, modes: TwinModes, data: Reduced) -> Complex:
    return modes.shapes_at(_sensor_positions(chain, modes, data))


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
    return predict_sine(twin, amplitude, f0, n, block.rate_hz, drive, channels, x, tau, start_up_of_sines([block]))
