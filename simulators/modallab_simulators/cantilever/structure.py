"""The beam in time: modal superposition, exact between internal samples, seen through the anti-alias filter.

Each mode is a first-order complex oscillator z' = p z + f (see `basis`): a point moves as Im(sum of c z) with
c = psi(x) psi(x_f) / s, its velocity is Im(sum of c p z) + Im(sum of c) f, its acceleration Im(sum of c p^2 z) +
Im(sum of c p) f + Im(sum of c) f'. Modes above the internal rate's reach answer quasi-statically, with what they add
to the static flexibility. A sensor's own dynamics add their poles to those of the beam.

The filter is linear as the beam is, so both are applied at once: a filtered output is a fixed combination of the state
at the filter's far end and of the force samples since. The state is all a stretch needs to know of the past.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.drifting_structure import relative_sign
from modallab_simulators.cantilever.loads import BLOCK, BeamLoad, DistributedLoad, Load, SensorOutput
from modallab_simulators.cantilever.recursion import (
    DELAY,
    REACH,
    LinearRecursion,
    difference_taps,
    lowpass_taps,
    modal_taps,
    plain_feeds,
    point_transfer,
    sensed_feeds,
    state_taps,
)

_TINY = 1e-150
_ALONG = 101
"""Places along the beam at which shapes are compared."""


@dataclass(frozen=True, eq=False, slots=True)
class _Filter:
    """The filter of rows sampled alike, and what a filtered oscillator owes to each force sample."""

    taps: Real
    modal: Complex128
    tail: Complex128


class LinearStructure:
    """Turns forces into what the converter sees, one stretch of BLOCK delivered samples after another."""

    def __init__(self, basis: Basis, outputs: Sequence[SensorOutput], rate_hz: float, oversample: int) -> None:
        self._oversample = oversample
        self._step_s = 1 / (rate_hz * oversample)
        self._basis = basis
        self._outputs = tuple(outputs)
        self._x = np.array([o.x_m for o in outputs])
        self._wait = max(0, ceil(max(o.later_s for o in outputs) * rate_hz - 1e-9))
        self._span = 2 * DELAY + self._wait
        self._columns = self._span + 3
        self._fft = _fast_length(BLOCK + self._columns + 1)
        owned = [pole for o in outputs for pole in o.sensor.poles]
        self._poles = np.concatenate([basis.poles, np.array(owned, dtype=np.complex128)])
        self._scan = LinearRecursion(self._poles, oversample * self._step_s, BLOCK)
        self._filters = self._filters_of()
        self._gains = self._output_gains()
        tails = np.stack([self._filters[o.later_s].tail for o in outputs])
        # Im(g z) = Im(g) Re(z) + Re(g) Im(z), with z stored as pairs.
        seen = self._gains * tails
        self._seen = np.stack([seen.imag, seen.real], axis=2).reshape(len(outputs), -1)
        self._drive_taps = state_taps(self._poles, self._step_s, oversample)
        self._inputs: dict[
            tuple[float, float, Load, bool, DistributedLoad | None, int], tuple[Complex128, Complex128]
        ] = {}

    @property
    def oversample(self) -> int:
        """Internal samples per delivered one."""
        return self._oversample

    @property
    def basis(self) -> Basis:
        """What is integrated in time."""
        return self._basis

    @property
    def places_m(self) -> Real:
        """Where each output is, (outputs,)."""
        return self._x

    @property
    def force_delay(self) -> int:
        """Delivered samples by which the force is delayed."""
        return DELAY + self._wait

    @property
    def at_rest(self) -> Complex128:
        """The state of a beam that has never moved."""
        return np.zeros(len(self._poles), dtype=np.complex128)

    def state_from(self, other: "LinearStructure", state: Complex128) -> Complex128:
        """This structure's state where displacement and velocity of every mode are those of another's."""
        count = len(self._basis.poles)
        p, q, z = self._basis.poles, other._basis.poles, state[:count]
        place = z.imag / other._basis.scale
        taken = state.copy()
        moved = z.real + (q.real - p.real) * place + 1j * place * self._basis.scale
        taken[:count] = moved * self._same_way(other)
        return taken

    def _same_way(self, other: "LinearStructure") -> Real:
        """-1 for each mode whose shape stands upside down to the other structure's, else 1, (modes,)."""
        at = np.linspace(0.0, self._basis.modes.length_m, _ALONG)
        return relative_sign(self._basis.shapes(at), other._basis.shapes(at))

    def times(self, block: int) -> tuple[int, int]:
        """First internal sample and number of those whose force the stretch `block` needs."""
        first = (block * BLOCK - self._span - 1) * self._oversample
        return first, (BLOCK + self._columns - 1) * self._oversample

    def advance(self, state: Complex128, drives: Sequence[BeamLoad]) -> tuple[Real, Complex128]:
        """Filtered outputs of one stretch in SI units, (outputs, BLOCK), and the state for the next."""
        if not drives:
            if not state.any():
                return np.zeros((len(self._outputs), BLOCK)), state
            states, after = self._scan.undriven_states(state)
            return self._seen @ states.view(np.float64).T, _flushed(after)
        driving = np.zeros((BLOCK, len(state)), dtype=np.complex128)
        spectrum = np.zeros((len(self._outputs), self._fft // 2 + 1), dtype=np.complex128)
        for drive in drives:
            into, kernel = self._input(drive)
            self._put(driving, drive.force_n, into)
            spectrum += self._filtered(drive.force_n, kernel)
        states, after = self._scan.driven_states(state, driving)
        seen = np.fft.irfft(spectrum, self._fft, axis=1)[:, self._columns - 1 : self._columns - 1 + BLOCK]
        seen += self._seen @ states.view(np.float64).T
        return seen, _flushed(after)

    def skip(self, state: Complex128, drives: Sequence[BeamLoad]) -> Complex128:
        """The state after a stretch of which nobody wants the outputs."""
        if not drives:
            return _flushed(self._scan.undriven_states(state)[1]) if state.any() else state
        driving = np.zeros((BLOCK, len(state)), dtype=np.complex128)
        for drive in drives:
            self._put(driving, drive.force_n, self._input(drive)[0])
        return _flushed(self._scan.driven_states(state, driving)[1])

    def _put(self, driving: Complex128, force: Real, into: Complex128) -> None:
        """Add what a force puts into the oscillators between delivered samples."""
        width = self._drive_taps.shape[0]
        windows = np.lib.stride_tricks.sliding_window_view(force, width)[self._oversample - REACH :: self._oversample]
        windows = np.ascontiguousarray(windows[:BLOCK])
        only = np.flatnonzero(into)
        if len(only) == len(into):
            driving += (windows @ self._drive_taps.view(np.float64)).view(np.complex128) * into
        else:
            taps = np.ascontiguousarray(self._drive_taps[:, only]).view(np.float64)
            driving[:, only] += (windows @ taps).view(np.complex128) * into[only]

    def _filtered(self, force: Real, kernel: Complex128) -> Complex128:
        phases = np.ascontiguousarray(force.reshape(-1, self._oversample).T)
        return np.einsum("cjf,jf->cf", kernel, np.fft.rfft(phases, self._fft, axis=1))

    def _filters_of(self) -> dict[float, _Filter]:
        wait = self._wait * self._oversample
        filters: dict[float, _Filter] = {}
        for later_s in dict.fromkeys(o.later_s for o in self._outputs):
            taps = lowpass_taps(self._oversample, later_s / self._step_s, wait)
            filters[later_s] = _Filter(taps, *modal_taps(self._poles, self._step_s, taps))
        return filters

    def _output_gains(self) -> Complex128:
        """What each output sees of each oscillator of unit input, (outputs, poles)."""
        poles, scale = self._basis.poles, self._basis.scale
        psi = self._basis.shapes(self._x)
        gains = np.zeros((len(self._outputs), len(self._poles)), dtype=np.complex128)
        place = len(poles)
        for row, output in enumerate(self._outputs):
            if output.kind != "motion":
                continue
            gains[row, : len(poles)] = psi[row] * poles**output.order / scale * output.sensor.response_at(poles)
            for pole, residue in zip(output.sensor.poles, output.sensor.residues, strict=True):
                gains[row, place] = (2j if pole.imag else 1j) * residue
                place += 1
        return gains

    def _input(self, drive: BeamLoad) -> tuple[Complex128, Complex128]:
        key = (drive.x_m, drive.volts_per_n, drive.load, drive.seen, drive.spread, drive.shaker)
        if key not in self._inputs:
            if len(self._inputs) > 64:
                self._inputs.clear()
            into, feeds = self._coupling(drive)
            self._inputs[key] = (into, self._kernel(self._impulse_taps(into, feeds)))
        return self._inputs[key]

    def _coupling(self, drive: BeamLoad) -> tuple[Complex128, Real]:
        """What a unit load puts into each oscillator, (poles,), and at once into each output, (outputs, 3)."""
        basis, at = self._basis, np.array([drive.x_m])
        if drive.spread is not None:
            psi, rest = drive.spread.psi, drive.spread.rest
        elif drive.load == "base":
            psi, rest = basis.participation, basis.base_remainder(self._x)
        else:
            put = 1 if drive.load == "moment" else 0
            psi, rest = basis.shapes(at, put)[0], basis.remainder(self._x, drive.x_m, put)
        shares = basis.shapes(self._x) * psi / basis.scale
        into, feeds = [psi.astype(np.complex128)], np.zeros((len(self._outputs), 3))
        for row, output in enumerate(self._outputs):
            if output.kind == "motion":
                plain = plain_feeds(shares[row], basis.poles, rest[row], output.order, drive.load == "base")
                feeds[row] = sensed_feeds(plain, output.sensor)
                c = shares[row] * basis.poles**output.order
                into.append(np.array([point_transfer(c, basis.poles, plain, q) for q in output.sensor.poles], complex))
            elif output.shaker == drive.shaker:
                felt = 1.0 if drive.seen else 0.0
                feeds[row, 0] = felt if output.kind == "force" else drive.volts_per_n
        return np.concatenate(into), feeds

    def _impulse_taps(self, into: Complex128, feeds: Real) -> Real:
        """Filtered output per force sample since the filter's far end, (outputs, taps)."""
        directs = np.stack([difference_taps(order, self._step_s) for order in range(3)])
        rows: list[Real] = []
        for row, output in enumerate(self._outputs):
            chain = self._filters[output.later_s]
            rows.append(((self._gains[row] * into) @ chain.modal).imag + np.convolve(chain.taps, feeds[row] @ directs))
        return np.array(rows)

    def _kernel(self, taps: Real) -> Complex128:
        padded = np.zeros((len(taps), self._columns * self._oversample))
        padded[:, self._oversample - REACH : self._oversample - REACH + taps.shape[1]] = taps
        phases = padded.reshape(len(taps), self._columns, self._oversample)[:, ::-1].transpose(0, 2, 1)
        return np.fft.rfft(np.ascontiguousarray(phases), self._fft, axis=2)


def _flushed(state: Complex128) -> Complex128:
    # A state that has died away would soon cost denormal arithmetic.
    state[np.abs(state) < _TINY] = 0
    return state


def _fast_length(least: int) -> int:
    """The smallest length of at least so many samples whose transform is fast: of the primes 2, 3 and 5 alone."""
    length = least
    while 30**20 % length:
        length += 1
    return length
