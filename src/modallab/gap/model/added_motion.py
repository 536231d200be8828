"""What an element that does not answer in proportion adds to the reduced data, stepped in time record by record.

It is stepped once for all numbers that only turn what the sensors read: gains, places, delays come after it.
"""

from collections import OrderedDict
from collections.abc import Callable
from threading import Lock
from typing import Any

import numpy as np

from modallab.core.arrays import Complex
from modallab.gap.conditioning.rows import ImpactData, Reduced, SineData
from modallab.twin.bench import Twin
from modallab.twin.modes import TwinModes, undamped_modes_key
from modallab.twin.nonlinear.element import ModalCoupling, NonlinearLaw, couple_to_modes
from modallab.twin.nonlinear.records import element_response_in_hit, element_response_in_sine, prepared_steps
from modallab.twin.nonlinear.steps import ModalSteps
from modallab.twin.predict import drifted_modes, sensor_positions
from modallab.twin.response import HitsAtPoint, SineBlocks

_KEPT: OrderedDict[tuple[object, ...], tuple[object, Any, Any]] = OrderedDict()
_MOST = 24
_LOCK = Lock()


def added_to_hits(twin: Twin, modes: TwinModes, d: ImpactData, source: HitsAtPoint, data: Reduced) -> Complex:
    """(channels, lines) acceleration per N that the element adds to the hits at one point, before the chain."""
    assert twin.element is not None
    x, gain = twin.struck_x_m(d.piece.drive_x_m), twin.hit_gain(d.piece.drive_x_m)
    share = float(twin.share_of_drift(d.piece.order / data.last_order)) if twin.ei_drift else 0.0
    modes = drifted_modes(twin.modes_felt_by(modes), twin.ei_drift, share)
    own = couple_to_modes(twin.element, twin.structure, modes)

    def step() -> tuple[Complex, Complex]:
        total, pushed = None, None
        steps = prepared_steps(modes, own, source.dt, x)
        for pulse, first, weight in zip(source.pulses, source.first, source.weights, strict=True):
            motion, force = element_response_in_hit(steps, gain * pulse, int(first), source.n).on_lines(source.lines)
            total = motion * weight if total is None else total + motion * weight
            pushed = force * weight if pushed is None else pushed + force * weight
        assert total is not None
        assert pushed is not None
        return total, pushed

    motion, force = _remembered(twin, (x, gain, share), d, source.dt, step)
    return _read(twin, modes, own, data, source.s, motion, force)


def added_to_sines(twin: Twin, modes: TwinModes, d: SineData, source: SineBlocks, data: Reduced) -> Complex:
    """(channels, blocks, lines) acceleration that the element adds to the sines, per n / 2 and per N."""
    assert twin.element is not None
    element, structure = twin.element, twin.in_sine(d.pieces[0].drive_x_m)
    x = d.pieces[0].drive_x_m
    shares = [float(twin.share_of_drift(p.order / data.last_order)) if twin.ei_drift else 0.0 for p in d.pieces]
    modes = twin.modes_felt_by(modes)
    of_block = [drifted_modes(modes, twin.ei_drift, share) for share in shares]
    same = couple_to_modes(element, structure, modes)
    owns = [couple_to_modes(element, structure, m) if twin.ei_drift else same for m in of_block]

    def step() -> tuple[list[Complex], list[Complex]]:
        steps = [prepared_steps(modes, same, source.dt, x)] * len(owns)
        if twin.ei_drift:
            steps = [prepared_steps(m, own, source.dt, x) for m, own in zip(of_block, owns, strict=True)]
        stepped = [_in_block(source, j, s, own.law) for j, (s, own) in enumerate(zip(steps, owns, strict=True))]
        # Fewer modes are followed in time where the steps are long.
        return [motion for motion, _ in stepped], [force for _, force in stepped]

    motion, force = _remembered(twin, (tuple(shares),), d, source.dt, step)
    answers = [
        _read(twin, m, own, data, s, a, b)
        for m, own, s, a, b in zip(of_block, owns, source.s, motion, force, strict=True)
    ]
    return np.stack(answers, axis=1)


def _in_block(
    source: SineBlocks, j: int, steps: Callable[[int], ModalSteps], law: NonlinearLaw
) -> tuple[Complex, Complex]:
    """What an element adds to the motion of the modes in a block of a sine, and its force, per n / 2 and per N."""
    rise = source.rise
    found = element_response_in_sine(
        steps,
        law,
        complex(source.force[j]),
        float(source.frequency_hz[j]),
        source.n,
        source.dt,
        float(rise.history_s[j]),
        float(rise.ramp_s[j]),
        bool(rise.cosine[j]),
        source.coarse,
    )
    motion, force = found.on_lines(source.lines[j])
    per_newton = 2 / source.n / source.force[j]
    return motion * per_newton, force * per_newton


def _read(
    twin: Twin, modes: TwinModes, own: ModalCoupling, data: Reduced, s: Complex, motion: Complex, force: Complex
) -> Complex:
    """(channels, lines) acceleration where the accelerometers sit."""
    psi = modes.shapes_at(sensor_positions(twin.chain, modes, data.channels, data.x_m))
    p = len(motion) // 2
    swing = 2 * psi[:, :p] * modes.poles[:p] ** 2
    straight = 2 * np.real((psi[:, :p] * modes.poles[:p]) @ own.shapes[:, :p].T)
    total = swing.real @ motion[:p] - swing.imag @ motion[p:] + straight @ force
    # The modes that follow at once, by their exact response to the element's force.
    poles, above, rows = modes.poles[p:, None], psi[:, p:], own.shapes[:, p:].T
    up, down = (rows @ force) / (s - poles), (rows.conj() @ force) / (s - poles.conj())
    return total + s**2 * (above @ up + above.conj() @ down)


def _remembered(twin: Twin, more: tuple[object, ...], d: ImpactData | SineData, dt: float, step: Any) -> Any:
    s = twin.structure if isinstance(d, ImpactData) else twin.in_sine(d.pieces[0].drive_x_m)
    key = (
        undamped_modes_key(s),
        s.dampers,
        s.zeta.tobytes(),
        twin.element,
        twin.ei_drift,
        twin.residual_compliance,
        dt,
        *more,
        id(d),
    )
    with _LOCK:
        if key in _KEPT:
            _KEPT.move_to_end(key)
            return _KEPT[key][1:]
    motion, force = step()
    with _LOCK:
        # The data are kept along: their number stays theirs.
        _KEPT[key] = d, motion, force
        while len(_KEPT) > _MOST:
            _KEPT.popitem(last=False)
    return motion, force
