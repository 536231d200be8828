"""The motion that forces give a structure, exact for a force between whose samples something is assumed.

*Band-limited*: the force holds nothing above half its rate, as a record behind an anti-alias filter. Its spectrum times
the FRFs is the response in the steady state; what the modes would already move then decays from the first sample on.
*Linear*: the force runs straight from sample to sample, and each mode goes on from step to step without error (the ramp
invariant method: Ahlin, Magnevall, Josefsson, Proc. ISMA 2006, 1127). What lies outside the band then is left out.
"""

import itertools
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import fft, signal

from modallab.core.arrays import Complex, Real
from modallab.core.errors import DataError
from modallab.core.units import DERIVATIVE, Quantity
from modallab.modification.structure import Receptances

Between = Literal["band-limited", "linear"]

RETURN = 0.05
"""Share of a record's length in which a force returns to its first value after the record ends."""


PIECE = 8192
"""Lines that are computed at once."""
TOGETHER = 4
"""Modes whose motion is added up at once."""


@dataclass(frozen=True, eq=False, slots=True)
class ModesAtPlaces:
    """Modes at the places of a response.

    Attributes:
        poles: (modes,) rad/s.
        out: (modes, outputs) psi.
        into: (modes, inputs) psi.
        whole: all that gives FRFs, with what lies outside the band.
        left: (freedoms, outputs) columns.
        right: (freedoms, inputs) columns.
        band_hz: beyond which what lies outside the band means nothing.
    """

    poles: Complex
    out: Complex
    into: Complex
    whole: Receptances
    left: Real
    right: Real
    band_hz: tuple[float, float]


def motion_of_modes(
    modes: ModesAtPlaces, force: Real, dt: float, quantity: Quantity, between: Between, start: Complex | None = None
) -> Real:
    """(outputs, samples) motion in m, m/s or m/s^2.

    Args:
        modes: at the places.
        force: (inputs, samples) N.
        dt: s between samples.
        quantity: displacement, velocity or acceleration.
        between: what the force is between its samples.
        start: (modes,) modal states at the first sample; None for rest.

    Raises:
        DataError: no finite force, or a step that is not above 0.
    """
    if force.ndim != 2 or force.shape[1] < 2 or not np.isfinite(force).all() or not (np.isfinite(dt) and dt > 0):
        raise DataError(
            f"a force of shape {force.shape} with a step of {dt:g} s cannot be applied",
            remedy="give (samples,) or (inputs, samples) finite numbers in N, at least two, and dt above 0 s",
        )
    if quantity not in DERIVATIVE:
        raise DataError(f"no motion is called {quantity!r}", remedy=f"use one of {', '.join(DERIVATIVE)}")
    begin = np.zeros(len(modes.poles), np.complex128) if start is None else start
    move = _band_limited if between == "band-limited" else _response_to_linear_force
    return move(modes, force, dt, DERIVATIVE[quantity], begin)


def _band_limited(modes: ModesAtPlaces, force: Real, dt: float, order: int, start: Complex) -> Real:
    n = force.shape[1]
    whole = _return_to_start(force)
    total = whole.shape[1]
    spectrum = np.asarray(fft.rfft(whole, axis=1), np.complex128)
    hz = np.asarray(fft.rfftfreq(total, dt), np.float64)
    moved = np.empty((modes.left.shape[1], hz.size), np.complex128)
    for lines in _pieces_of_lines(hz, modes.band_hz):
        moved[:, lines] = _motion_spectrum(modes, hz[lines], spectrum[:, lines], order)
    steady = np.asarray(fft.irfft(moved, total, axis=1), np.float64)[:, :n]
    # The modes' state at the first sample of a force that repeats for ever; from rest, it is missing from then on.
    s = 2j * np.pi * fft.fftfreq(total, dt)
    both = fft.fft(whole, axis=1)
    repeating = [np.mean((psi @ both) / (s - p)) for p, psi in zip(modes.poles, modes.into, strict=True)]
    return steady + _free_motion(modes, start - np.array(repeating), n, dt, order)


def _pieces_of_lines(hz: Real, band_hz: tuple[float, float]) -> list[slice]:
    """Lines in pieces that fit the cache, none across an edge of the band."""
    edges = np.searchsorted(hz, [*band_hz], side="left") + np.array([0, 1])
    cuts = np.unique(np.clip([*range(0, hz.size, PIECE), *edges, hz.size], 0, hz.size))
    return [slice(int(a), int(b)) for a, b in itertools.pairwise(cuts)]


def _motion_spectrum(modes: ModesAtPlaces, hz: Real, spectrum: Complex, order: int) -> Complex:
    """(outputs, lines) spectrum of the motion, all lines within the band or none."""
    s = np.asarray(2j * np.pi * hz)
    if modes.band_hz[0] <= hz[0] <= modes.band_hz[1]:
        return modes.whole.motion(s, spectrum, modes.left, modes.right) * s**order
    moved = modes.out.T @ ((modes.into @ spectrum) / (s - modes.poles[:, None]))
    moved += modes.out.conj().T @ ((modes.into.conj() @ spectrum) / (s - modes.poles.conj()[:, None]))
    return moved * s**order


def _return_to_start(force: Real) -> Real:
    """The force with a smooth way from its end back to its beginning, as the spectrum takes it to repeat."""
    n = force.shape[1]
    more = fft.next_fast_len(n + max(64, int(RETURN * n)), real=True) - n
    way = (1 + np.cos(np.pi * np.arange(1, more + 1) / (more + 1))) / 2
    return np.concatenate([force, force[:, -1:] * way + force[:, :1] * (1 - way)], axis=1)


def _free_motion(modes: ModesAtPlaces, state: Complex, n: int, dt: float, order: int) -> Real:
    """(outputs, n) motion of modes left to themselves."""
    decays = (x * pole**order * _decay(pole * dt, n) for pole, x in zip(modes.poles, state, strict=True))
    return _sum_over_modes(modes.out, decays, n)


def _decay(step: complex, n: int) -> Complex:
    """(n,) exp(k step), as products of few: an exponential for each sample would take longer than all else."""
    part = int(np.ceil(np.sqrt(n)))
    few = np.arange(part)
    return np.asarray(np.multiply.outer(np.exp(step * part * few), np.exp(step * few)).ravel()[:n])


def _response_to_linear_force(modes: ModesAtPlaces, force: Real, dt: float, order: int, start: Complex) -> Real:
    return _sum_over_modes(modes.out, _rates_of_motion(modes, force, dt, order, start), force.shape[1])


def _rates_of_motion(modes: ModesAtPlaces, force: Real, dt: float, order: int, start: Complex) -> Iterator[Complex]:
    for pole, into, x in zip(modes.poles, modes.into, start, strict=True):
        driven = into @ force
        state = ramp_states(pole, driven, dt, x) * pole**order
        # An acceleration follows the force at once; in displacement and velocity the modes' shares of it cancel.
        yield state + driven * pole if order == DERIVATIVE["acceleration"] else state


def _sum_over_modes(out: Complex, states: Iterable[Complex], n: int) -> Real:
    """(outputs, n) twice the real part of the sum over modes of out (modes, outputs) times states (n,)."""
    found, each = np.zeros((out.shape[1], n)), iter(states)
    for psi in np.array_split(out, max(1, -(-len(out) // TOGETHER))):
        several = np.array([next(each) for _ in psi])
        found += 2 * (psi.real.T @ several.real - psi.imag.T @ several.imag)
    return found


def ramp_states(pole: complex, driven: Complex, dt: float, start: complex = 0.0) -> Complex:
    """The state (samples,) of x' = pole x + driven, where `driven` is linear between samples."""
    before, after = ramp_weights(pole, dt)
    grows = np.exp(pole * dt)
    # x[k] = grows x[k-1] + before driven[k-1] + after driven[k]; at the first sample it is the start.
    found, _ = signal.lfilter([after, before], [1.0, -grows], driven, zi=[start - after * driven[0]])
    return np.asarray(found, np.complex128)


def ramp_weights(pole: complex, dt: float) -> tuple[complex, complex]:
    """Weights of the forcing at the beginning and at the end of a step."""
    z = pole * dt
    grows = np.exp(z)
    after = (grows - 1 - z) / (z * pole)
    return complex((grows - 1) / pole - after), complex(after)


def modal_states(modes_at: Mapping[Quantity, Complex], poles: Complex, given: Mapping[Quantity, Real]) -> Complex:
    """(modes,) modal states of the smallest size that give displacements and velocities at some places.

    Args:
        modes_at: quantity -> (modes, places) psi.
        poles: (modes,)
        given: quantity -> (places,) m or m/s.
    """
    rows, wanted = [], []
    for quantity, psi in modes_at.items():
        order = DERIVATIVE[quantity]
        shape = (psi * poles[:, None] ** order).T
        rows.append(np.concatenate([2 * shape.real, -2 * shape.imag], axis=1))
        wanted.append(given[quantity])
    x = np.linalg.lstsq(np.concatenate(rows), np.concatenate(wanted), rcond=None)[0]
    return np.asarray(x[: len(poles)] + 1j * x[len(poles) :])
