"""The beam in time: modal superposition, exact between internal samples, seen through the anti-alias filter.

Each mode is a first-order complex oscillator z' = p z + f with p = -zeta omega + j omega_d, so that at unit modal mass
q = Im(z) / omega_d, q' = Im(p z) / omega_d and q'' = Im(p^2 z) / omega_d + f. Modes above the internal rate's reach
answer quasi-statically, with what they add to the static flexibility.

The filter is linear as the beam is, so both are applied at once: a filtered output is a fixed combination of the state
at the filter's far end and of the force samples since. The state is all a stretch needs to know of the past.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft

from modallab_simulators.cantilever.antialias import DELAY, lowpass
from modallab_simulators.cantilever.beam import CantileverBeam
from modallab_simulators.cantilever.hold import REACH, TAPS, difference_taps
from modallab_simulators.cantilever.lift import modal_taps, state_taps
from modallab_simulators.cantilever.scan import Complex, Scan

Floats = NDArray[np.float64]

BLOCK = 960
"""Delivered samples in one stretch: with the filter's length it fills an FFT of 1024."""

_SPAN = 2 * DELAY
_COLUMNS = _SPAN + 3
_FFT = BLOCK + _COLUMNS + 1
_TINY = 1e-150


@dataclass(frozen=True, eq=False, slots=True)
class ModalBasis:
    """The modes that are integrated in time: the first len(omega) of the beam."""

    beam: CantileverBeam
    omega: Floats
    zeta: Floats

    @property
    def poles(self) -> Complex:
        """p = -zeta omega + j omega sqrt(1 - zeta^2)."""
        return self.omega * (-self.zeta + 1j * np.sqrt(1 - self.zeta**2))

    def shapes(self, x_m: Floats) -> Floats:
        """At unit modal mass in kg^-1/2, (points, modes)."""
        return self.beam.shapes(x_m, len(self.omega))

    def remainder(self, x_m: Floats, force_x_m: float) -> Floats:
        """Static flexibility of all modes beyond, in m/N, (points,)."""
        own = self.shapes(x_m) * self.shapes(np.array([force_x_m])) / self.omega**2
        return self.beam.flexibility(x_m, force_x_m) - own.sum(axis=1)


@dataclass(frozen=True, slots=True)
class Output:
    """What one channel sees.

    Attributes:
        kind: the motion of a point, the force, or the generator's voltage.
        x_m: where, for a motion.
        order: derivative of the displacement: 0, 1 or 2.
    """

    kind: Literal["motion", "force", "voltage"]
    x_m: float = 0.0
    order: int = 0


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """A force on the beam.

    Attributes:
        x_m: where.
        force_n: on the internal samples of `Structure.times`.
        volts_per_n: of the generator behind it; 0 for a hammer.
    """

    x_m: float
    force_n: Floats
    volts_per_n: float = 0.0


class Structure:
    """Turns forces into what the converter sees, one stretch of BLOCK delivered samples after another."""

    def __init__(self, basis: ModalBasis, outputs: Sequence[Output], rate_hz: float, oversample: int) -> None:
        self.oversample = oversample
        self._step_s = 1 / (rate_hz * oversample)
        self._basis = basis
        self._outputs = tuple(outputs)
        self._x = np.array([o.x_m for o in outputs])
        self._orders = np.array([o.order for o in outputs])
        self._moving = np.array([o.kind == "motion" for o in outputs])
        self._lowpass = lowpass(oversample)
        self._scan = Scan(basis.poles, oversample * self._step_s, BLOCK)
        self._phi = basis.shapes(self._x) * self._moving[:, None]
        self._modal_taps, tail = modal_taps(basis.poles, self._step_s, self._lowpass)
        self._seen = self._seen_states(tail)
        self._drive_taps = state_taps(basis.poles, self._step_s, oversample)
        self._inputs: dict[tuple[float, float], tuple[Floats, Complex]] = {}

    @property
    def at_rest(self) -> Complex:
        """The state of a beam that has never moved."""
        return np.zeros(len(self._basis.omega), dtype=np.complex128)

    def times(self, block: int) -> tuple[int, int]:
        """First internal sample and number of those whose force the stretch `block` needs."""
        first = (block * BLOCK - _SPAN - 1) * self.oversample
        return first, (BLOCK + _COLUMNS - 1) * self.oversample

    def advance(self, state: Complex, drives: Sequence[Drive]) -> tuple[Floats, Complex]:
        """Filtered outputs of one stretch in SI units, (outputs, BLOCK), and the state for the next."""
        if not drives:
            if not state.any():
                return np.zeros((len(self._outputs), BLOCK)), state
            states, after = self._scan.free(state)
            return self._seen @ states.view(np.float64).T, _flushed(after)
        driving = np.zeros((BLOCK, len(state)), dtype=np.complex128)
        spectrum = np.zeros((len(self._outputs), _FFT // 2 + 1), dtype=np.complex128)
        for drive in drives:
            phi, kernel = self._input(drive.x_m, drive.volts_per_n)
            driving += self._modal_drive(drive.force_n, phi)
            spectrum += self._filtered(drive.force_n, kernel)
        states, after = self._scan.driven(state, driving)
        seen = irfft(spectrum, _FFT, axis=1)[:, _COLUMNS - 1 : _COLUMNS - 1 + BLOCK]
        seen += self._seen @ states.view(np.float64).T
        return seen, _flushed(after)

    def _modal_drive(self, force: Floats, phi: Floats) -> Complex:
        width = self._drive_taps.shape[0]
        windows = np.lib.stride_tricks.sliding_window_view(force, width)[self.oversample - REACH :: self.oversample]
        driving = np.ascontiguousarray(windows[:BLOCK]) @ self._drive_taps.view(np.float64)
        return driving.view(np.complex128) * phi

    def _filtered(self, force: Floats, kernel: Complex) -> Complex:
        phases = np.ascontiguousarray(force.reshape(-1, self.oversample).T)
        return np.einsum("cjf,jf->cf", kernel, rfft(phases, _FFT, axis=1))

    def _seen_states(self, tail: Complex) -> Floats:
        poles = self._basis.poles
        gains = self._phi * tail * poles ** self._orders[:, None] / poles.imag
        # Im(g z) = Im(g) Re(z) + Re(g) Im(z), with z stored as pairs.
        return np.stack([gains.imag, gains.real], axis=2).reshape(len(self._outputs), -1)

    def _input(self, x_m: float, volts_per_n: float) -> tuple[Floats, Complex]:
        key = (x_m, volts_per_n)
        if key not in self._inputs:
            if len(self._inputs) > 64:
                self._inputs.clear()
            phi = self._basis.shapes(np.array([x_m]))[0]
            self._inputs[key] = (phi, self._kernel(self._impulse_taps(phi, x_m, volts_per_n)))
        return self._inputs[key]

    def _impulse_taps(self, phi: Floats, x_m: float, volts_per_n: float) -> Floats:
        """Filtered output per force sample since the filter's far end, (outputs, taps)."""
        taps = np.zeros((len(self._outputs), len(self._lowpass) + TAPS - 2))
        rest = self._basis.remainder(self._x, x_m)
        plain = np.convolve(self._lowpass, difference_taps(0, self._step_s))
        for row, output in enumerate(self._outputs):
            if output.kind != "motion":
                taps[row] = plain * (1.0 if output.kind == "force" else volts_per_n)
                continue
            modal = self._phi[row] * phi
            taps[row] = modal @ self._modal_taps[output.order]
            taps[row] += rest[row] * np.convolve(self._lowpass, difference_taps(output.order, self._step_s))
            if output.order == 2:
                taps[row] += modal.sum() * plain
        return taps

    def _kernel(self, taps: Floats) -> Complex:
        padded = np.zeros((len(taps), _COLUMNS * self.oversample))
        padded[:, self.oversample - REACH : self.oversample - REACH + taps.shape[1]] = taps
        phases = padded.reshape(len(taps), _COLUMNS, self.oversample)[:, ::-1].transpose(0, 2, 1)
        return rfft(np.ascontiguousarray(phases), _FFT, axis=2)


def _flushed(state: Complex) -> Complex:
    # A state that has died away would soon cost denormal arithmetic.
    state[np.abs(state) < _TINY] = 0
    return state
