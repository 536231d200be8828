"""The twin's answer on the reduced data."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.gap.reduce import ImpactData, Reduced, SineData
from modallab.twin.bench import Chain, Twin, transfer
from modallab.twin.structure import Modes, solve

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]


def forward(twin: Twin, data: Reduced) -> list[Complex]:
    """What the twin says the reduced data are: (channels, rows) for each drive point, then for the sine test."""
    modes = solve(twin.structure)
    last = data.last_order
    answers = [_impact(twin, modes, d, data, d.piece.order / last) for d in data.impacts]
    if data.sines is not None:
        hung = twin.in_sine(data.sines.pieces[0].drive_x_m)
        answers.append(_sines(twin, modes if hung is twin.structure else solve(hung), data.sines, data, last))
    return answers


def _impact(twin: Twin, modes: Modes, d: ImpactData, data: Reduced, tau: float) -> Complex:
    scale = np.sqrt(max(1e-3, 1 + twin.ei_drift * float(twin.drifted(tau))))
    poles = modes.poles * scale
    drive = modes.at(min(max(d.piece.drive_x_m + twin.hit_shift_m, 0.0), modes.length_m))[0]
    residue = _outputs(twin.chain, modes, data) * drive / scale
    source = replace(d.source, dt=d.source.dt / (1 + twin.clock)) if twin.clock else d.source
    total = np.zeros(d.rows.y.shape, dtype=np.complex128)
    forced_sum = np.zeros_like(total)
    for pole, r in ((poles, residue), (poles.conj(), residue.conj())):
        forced, tail = source.kernel(pole)
        forced_sum += r @ forced
        total += (r * transfer(twin.chain, data.channels, pole)) @ tail
    return _swap(twin.chain, data, total + transfer(twin.chain, data.channels, source.s) * forced_sum)


def _sines(twin: Twin, modes: Modes, d: SineData, data: Reduced, last: float) -> Complex:
    source = d.source
    if twin.clock:
        source = replace(source, dt=source.dt / (1 + twin.clock), frequency_hz=source.frequency_hz * (1 + twin.clock))
    tau = np.array([p.order for p in d.pieces]) / last
    scale = np.sqrt(np.maximum(1e-3, 1 + twin.ei_drift * twin.drifted(tau))) if twin.ei_drift else None
    poles = modes.poles if scale is None else modes.poles[:, None] * scale
    residue = _outputs(twin.chain, modes, data) * modes.at(d.pieces[0].drive_x_m)[0]
    up, down = np.zeros((2, len(data.channels), len(d.pieces)), dtype=np.complex128)
    rings = np.zeros((len(data.channels), *source.lines.shape), dtype=np.complex128)
    for pole, r in ((poles, residue), (poles.conj(), residue.conj())):
        a, b, decay = source.kernel(pole)
        if scale is not None:
            a, b, decay = a / scale, b / scale, decay / scale
        up += r @ a
        down += r @ b
        amplitude = np.einsum("cp,pb->cpb", r, decay) * _at_poles(twin.chain, data, pole)
        rings += np.einsum("cpb,pbk->cbk", amplitude, source.decay_shape(pole))
    at_up, at_down = (transfer(twin.chain, data.channels, sign * source.drive) for sign in (1, -1))
    share_up, share_down = source.shares()
    total = rings + (up * at_up)[:, :, None] * share_up + (down * at_down)[:, :, None] * share_down
    return _swap(twin.chain, data, total.reshape(len(data.channels), -1))


def _at_poles(chain: Chain, data: Reduced, pole: Complex) -> Complex:
    values = transfer(chain, data.channels, pole)
    return values if values.ndim == 3 else values[:, :, None]


def _outputs(chain: Chain, modes: Modes, data: Reduced) -> Complex:
    x = data.x_m + np.array([chain.shift.get(c, 0.0) for c in data.channels])
    return modes.at(np.clip(x, 0.0, modes.length_m))


def _swap(chain: Chain, data: Reduced, y: Complex) -> Complex:
    if chain.swap is None:
        return y
    order = np.arange(len(data.channels))
    i, j = (data.channels.index(c) for c in chain.swap)
    order[[i, j]] = order[[j, i]]
    return y[order]
