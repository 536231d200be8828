"""How the reduced data answer small changes of the beam: every effect on it acts through poles and residues alone.

One evaluation of the kernels and of their slopes by the pole serves all free numbers; what a number does to the poles
and to the residues comes from the eigenvalue problem, which is far smaller than the data. Each answer is then one
product of these changes with the kernels.

The chain rule through poles and residues; Fox and Kapoor, AIAA J. 6 (1968), 2426, give their derivatives in closed
form, here they are differences of two small eigenvalue problems.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.core.units import Test
from modallab.gap.conditioning.rows import ImpactData, Reduced, SineData
from modallab.gap.model.forward import (
    drive_point_and_gain,
    frequency_ratios_of_hits,
    frequency_scale_of_drift,
    sine_drift,
    with_clock_error,
    with_shaker,
)
from modallab.twin.bench import MeasurementChain, Twin, chain_transfer, exchange_plugs, is_frequency_independent
from modallab.twin.elements import shape_rows
from modallab.twin.modes import TwinModes, have_same_modes, solve_modes
from modallab.twin.neighbours import NeighbourStructures
from modallab.twin.predict import sensor_positions
from modallab.twin.structure import TwinStructure

Numbers = tuple[Complex, Complex, Real]
"""(twins, p) poles, (twins, channels, p) residues and (twins, channels) static remainder."""


@dataclass(frozen=True, eq=False, slots=True)
class ManyModes:
    """The modes of many twins, and where their accelerometers sit.

    Attributes:
        poles: (twins, p); NaN for a twin with other modes.
        columns: (twins, n, p) as in `TwinModes`; NaN too.
        out_of_band: of each twin, as in `TwinModes`.
        sensors: (twins, channels, n) rows that take a shape at the accelerometers.
        outputs: (twins, channels, p) shapes there, which all drive points share.
        length_m: of the beam.
    """

    poles: Complex
    columns: Complex
    out_of_band: tuple[Real, ...]
    sensors: Real
    outputs: Complex
    length_m: float

    @classmethod
    def of(cls, modes: Sequence[TwinModes], sensors: Real, count: int) -> Self:
        """Of twins whose accelerometers sit there, with so many modes as a rule."""
        poles = np.full((len(modes), count), np.nan, dtype=np.complex128)
        columns: Complex = np.full((len(modes), sensors.shape[2], count), np.nan, dtype=np.complex128)
        for k, own in enumerate(modes):
            if len(own.poles) == count:
                poles[k], columns[k] = own.poles, own.columns
        out_of_band = tuple(m.out_of_band for m in modes)
        return cls(poles, columns, out_of_band, sensors, sensors @ columns, modes[0].length_m)

    def at(self, x_m: Sequence[float]) -> tuple[Complex, Real]:
        """(twins, p) shapes at one place on each twin, and (twins, channels) static m per N that others add there."""
        rows = np.array([shape_rows(x, self.length_m)[0] for x in x_m])
        pushed = np.array([given @ row for given, row in zip(self.out_of_band, rows, strict=True)])
        return (rows[:, None] @ self.columns)[:, 0], (self.sensors @ pushed[:, :, None])[:, :, 0]


def sensor_rows(twins: Sequence[Twin], modes: TwinModes, data: Reduced) -> Real:
    """(twins, channels, n) rows that take a shape at the accelerometers of each twin."""
    first, *others = twins
    usual = shape_rows(sensor_positions(first.chain, modes, data.channels, data.x_m), modes.length_m)
    rows = [usual]
    for twin in others:
        moved = twin.chain.shift != first.chain.shift
        x = sensor_positions(twin.chain, modes, data.channels, data.x_m) if moved else None
        rows.append(usual if x is None else shape_rows(x, modes.length_m))
    return np.array(rows)


def hit_numbers(twins: Sequence[Twin], modes: ManyModes, d: ImpactData, data: Reduced) -> Numbers:
    """The numbers of hits at one point, on twins that drift alike."""
    scale = float(frequency_scale_of_drift(twins[0], d.piece.order, data))
    x, gains = zip(*(drive_point_and_gain(t, d.piece) for t in twins), strict=True)
    drive, static = modes.at(x)
    gain = np.array(gains)[:, None]
    residue = modes.outputs * (drive * gain / scale)[:, None]
    return modes.poles * scale, residue, static * gain * _shares(twins) / scale**2


def sine_numbers(twins: Sequence[Twin], modes: ManyModes, d: SineData) -> Numbers:
    """The numbers of the sine test, without drift."""
    drive, static = modes.at([d.pieces[0].drive_x_m] * len(twins))
    return modes.poles, modes.outputs * drive[:, None], static * _shares(twins)


def _shares(twins: Sequence[Twin]) -> Real:
    return np.array([[t.residual_compliance] for t in twins])


Kernel = Callable[[Complex], Complex]
"""From (p,) poles to (channels or 1, p, rows), the answers per unit residue at gain 1."""
Follow = Callable[[Sequence[Twin], ManyModes], Numbers]
"""From twins and their modes to what their answers follow from."""

SLOPE = 1e-6
"""Relative step of a pole for the slopes of the kernels."""


class Tangent:
    """The answers of a twin on the data, and how they change with its structure, places and gains."""

    def __init__(self, twin: Twin, data: Reduced) -> None:
        """Evaluate the kernels of `twin` on `data`."""
        self.data, self.twin = data, twin
        modes = self._modes = solve_modes(twin.structure)
        self._hung = with_shaker(twin, modes, data)
        self._parts = [_of_hits(twin, self._hung if d.piece.by_shaker else modes, d, data) for d in data.impacts]
        if data.sines is not None:
            self._parts.append(_of_sines(twin, self._hung, data.sines, data))

    def changes(self, twins: Sequence[Twin], near: int = 0) -> list[Complex]:
        """(twins, channels, rows) each: what twins of nearly the same structure, places and gains add.

        Args:
            twins: the other twins.
            near: so many of them, the last, are solved to first order only.

        Returns:
            NaN for a twin of which a mode swings that does not here, or the other way round: there no slope leads.
        """
        first, usual = len(twins) - near, len(self._modes.poles)
        modes = neighbouring_modes(self._modes, self.twin.structure, [t.structure for t in twins], first)
        sensors = sensor_rows([self.twin, *twins], self._modes, self.data)[1:]
        by_hand = by_shaker = ManyModes.of(modes, sensors, usual)
        if (x := self.data.shaker_x_m) is not None:
            hung = self._all_hung(twins, modes, x, first)
            by_shaker = by_hand if hung is modes else ManyModes.of(hung, sensors, len(self._hung.poles))
        chain, channels = self.twin.chain, self.data.channels
        own = [by_hand if p.test == "impact" else by_shaker for p in self._parts]
        zipped = zip(self._parts, own, strict=True)
        return [exchange_plugs(chain, channels, p.test, p.changes(twins, m, self.data)) for p, m in zipped]

    def _all_hung(self, twins: Sequence[Twin], modes: list[TwinModes], x_m: float, first: int) -> list[TwinModes]:
        """The modes while the shaker hangs on them."""
        here, hung = self.twin.in_sine(x_m), [t.in_sine(x_m) for t in twins]
        if here is self.twin.structure and all(s is t.structure for s, t in zip(hung, twins, strict=True)):
            return modes
        return neighbouring_modes(self._hung, here, hung, first)


def neighbouring_modes(
    modes: TwinModes, here: TwinStructure, there: Sequence[TwinStructure], first: int
) -> list[TwinModes]:
    """The modes of structures next to one whose modes are known; those of the first of them exactly."""
    found = [solve_modes(s) for s in there[:first]]
    moved = [k for k in range(first, len(there)) if not have_same_modes(there[k], here)]
    near = dict(zip(moved, NeighbourStructures(here).solve([there[k] for k in moved]), strict=True)) if moved else {}
    return [*found, *(near.get(k, modes) for k in range(first, len(there)))]


def _gains(chain: MeasurementChain, data: Reduced) -> Real:
    return np.array([chain.gain.get(c, 1.0) for c in data.channels]) / chain.force_gain


@dataclass(frozen=True, eq=False, slots=True)
class _Part:
    """Answers of one kind of data, as sums of kernels.

    Attributes:
        test: impact or sine.
        numbers: what the answers of a twin follow from.
        kernels: (channels or 1, 4 p + 1, 2 rows) what real and imaginary parts of the residues, of the residues times
            their pole's change, and the remainder do to the rows (real and imaginary in turn) at gain 1.
        poles: (p,) of the twin in the middle.
        residue: (channels, p) of it.
        residual: (channels,) of it.
        gains: (channels,) of it.
    """

    test: Test
    numbers: Follow
    kernels: Real
    poles: Complex
    residue: Complex
    residual: Real
    gains: Real

    def changes(self, twins: Sequence[Twin], modes: ManyModes, data: Reduced) -> Complex:
        """(twins, channels, rows) what the twins with these modes add."""
        poles, residue, residual = self.numbers(twins, modes)
        dp, dr, ds = poles - self.poles, residue - self.residue, residual - self.residual
        louder = (np.array([_gains(t.chain, data) for t in twins]) / self.gains - 1)[:, :, None]
        moved = dr + louder * self.residue
        turned = self.residue * dp[:, None]
        static = ds[:, :, None] + louder * self.residual[:, None]
        weights = np.concatenate([moved.real, moved.imag, turned.real, turned.imag, static], axis=2)
        return self._summed(weights * self.gains[:, None])

    def _summed(self, weights: Real) -> Complex:
        if len(self.kernels) == 1:
            flat = weights.reshape(-1, weights.shape[2]) @ self.kernels[0]
            return flat.view(np.complex128).reshape(*weights.shape[:2], -1)
        summed: Real = np.matmul(weights.transpose(1, 0, 2), self.kernels)
        return summed.view(np.complex128).transpose(1, 0, 2)


def _part(
    test: Test, numbers: Follow, kernel: Kernel, static: Complex, middle: tuple[Twin, TwinModes], data: Reduced
) -> _Part:
    twin, modes = middle
    many = ManyModes.of([modes], sensor_rows([twin], modes, data), len(modes.poles))
    poles, residue, residual = (own[0] for own in numbers([twin], many))
    up, up_slope = _with_slope(kernel, poles)
    down, down_slope = _with_slope(kernel, poles.conj())
    parts = (up + down, 1j * (up - down), up_slope + down_slope, 1j * (up_slope - down_slope), static[:, None])
    kernels = np.ascontiguousarray(np.concatenate(parts, axis=1)).view(np.float64)
    return _Part(test, numbers, kernels, poles, residue, residual, _gains(twin.chain, data))


def _with_slope(kernel: Kernel, poles: Complex) -> tuple[Complex, Complex]:
    here = kernel(poles)
    return here, (kernel(poles * (1 + SLOPE)) - here) / (poles * SLOPE)[:, None]


def _unit(chain: MeasurementChain, data: Reduced) -> Callable[[Complex], Complex]:
    """(channels or 1, ...) what the chain makes of an acceleration at complex frequencies (...), but for the gains."""
    if is_frequency_independent(chain):
        return lambda s: np.ones((1, *s.shape), dtype=np.complex128)
    own = replace(chain, gain={}, force_gain=1.0)
    return lambda s: chain_transfer(own, data.channels, s)


def _of_hits(twin: Twin, modes: TwinModes, d: ImpactData, data: Reduced) -> _Part:
    source, unit = with_clock_error(d.source, twin), _unit(twin.chain, data)
    on_lines, ratios = unit(source.s), frequency_ratios_of_hits(twin, d, data)

    def kernel(poles: Complex) -> Complex:
        forced, tail = source.response_to_unit_residue(poles, ratios)
        return on_lines[:, None] * forced + unit(poles)[:, :, None] * tail

    def numbers(twins: Sequence[Twin], m: ManyModes) -> Numbers:
        return hit_numbers(twins, m, d, data)

    return _part(d.piece.test, numbers, kernel, on_lines * source.s**2, (twin, modes), data)


def _of_sines(twin: Twin, modes: TwinModes, d: SineData, data: Reduced) -> _Part:
    source, unit = with_clock_error(d.source, twin), _unit(twin.chain, data)
    drift = sine_drift(twin, d, data)
    scale = np.ones(len(d.pieces)) if drift is None else drift
    up, down = ((unit(sign * source.drive))[:, :, None] * s for sign, s in zip((1, -1), source.shares(), strict=True))

    def kernel(poles: Complex) -> Complex:
        p = poles if drift is None else poles[:, None] * drift
        a, b, decay = (k / scale for k in source.response_to_unit_residue(p))
        at = unit(p) if drift is not None else unit(p)[:, :, None]
        total = up[:, None] * a[:, :, None] + down[:, None] * b[:, :, None]
        total += (decay * at)[..., None] * source.decay_shape(p)
        return total.reshape(len(total), len(poles), -1)

    def numbers(twins: Sequence[Twin], m: ManyModes) -> Numbers:
        return sine_numbers(twins, m, d)

    static = (up + down) * (source.drive**2 / scale**2)[:, None]
    return _part("sine", numbers, kernel, static.reshape(len(static), -1), (twin, modes), data)


def differ_smoothly(twin: Twin, other: Twin) -> bool:
    """Whether two twins differ in no more than structure, places and gains, and answer in proportion."""
    if twin.element is not None or other.element is not None:
        return False
    fields = ("corner_hz", "mounts", "delay_s", "skew_s", "swap", "lag_s", "own_corner_hz", "low_pass_hz")
    same_chain = all(getattr(other.chain, f) == getattr(twin.chain, f) for f in fields)
    return same_chain and all(getattr(twin, f) == getattr(other, f) for f in ("ei_drift", "drift_curve", "clock"))
