"""How much of each mode a hit has excited, per newton second: the mode's shape at the point that was struck.

About each expected frequency the block is fitted by one mode and a straight background. The pole is looked for, since
believed frequencies are off by a per cent or two and believed damping by a factor; what the sensors then read of the
mode, over the shape that is believed there, is the shape where the hammer landed.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.signals.conversion import Conversion
from modallab.signals.hit import find_hit, windowed_force
from modallab.signals.transform import previous_quick_length, spectrum

Samples = NDArray[Any]

EXCITED = 0.1
"""A line counts as excited where the force has this part of its largest line."""
USABLE = 0.4
"""Lines up to this part of the rate; above it the anti-alias filter falls."""


@dataclass(frozen=True, eq=False, slots=True)
class HitResponse:
    """One hit.

    Attributes:
        force_n: (n,) zero but for the hit.
        force: (lines,) its spectrum; line k is k / block duration.
        motion: by place in the rig, the (lines,) spectrum of each channel asked for, SI units, less what was there
            before the hit.
        rate_hz: of both.
        band_hz: up to which the hit excites.
    """

    force_n: Real
    force: Complex128
    motion: dict[int, Complex128]
    rate_hz: float
    band_hz: float

    def of(self, channels: Iterable[int]) -> Complex128:
        """(channels, lines) spectra."""
        return np.stack([self.motion[channel] for channel in channels])

    def frf(self, channels: Iterable[int], up_to_hz: float) -> Complex128:
        """(channels, lines) of the block's lines above 0 up to a frequency; the block's end is in it."""
        count = int(up_to_hz * self.force_n.size / self.rate_hz) + 1
        force = self.force[1:count]
        floor = 1e-3 * np.abs(force).max()
        force = np.where(np.abs(force) < floor, floor, force)
        return self.of(channels)[:, 1:count] / force


def response_of_hit(
    samples: Samples, conversion: Conversion, rate_hz: float, before: int, channels: Iterable[int], up_to_hz: float
) -> HitResponse | None:
    """The answer in a block.

    Args:
        samples: (rig's channels, n) as delivered.
        conversion: to SI units.
        rate_hz: sampling rate.
        before: index of the trigger.
        channels: whose answer is wanted.
        up_to_hz: at least so far.

    Returns:
        Lines up to that frequency or the hit's band, whichever is higher; None if no hit stands out of the noise.
    """
    # A block less its last per cent says as much; its own number of samples may take the transform four times as long.
    samples = samples[:, : previous_quick_length(samples.shape[1])]
    force_n = conversion.force_n(samples)
    try:
        force_n = windowed_force(force_n, find_hit(force_n))
    except DataError:
        return None
    force, line_hz = spectrum(force_n), rate_hz / force_n.size
    band_hz = _band_hz(np.abs(force), line_hz, rate_hz)
    count = min(force.size, int(1.1 * max(up_to_hz, band_hz) / line_hz) + 8)
    motion: dict[int, Complex128] = {}
    for channel in channels:
        row = samples[channel]
        moves = (row - row[: max(1, before - 1)].mean(dtype=np.float64)).astype(np.float32)
        # Single precision is half the time, and right to a part in a million of the largest line.
        motion[channel] = spectrum(moves)[:count].astype(np.complex128) * conversion.si_per_count[channel]
    return HitResponse(force_n, force[:count], motion, rate_hz, band_hz)


def _band_hz(spectrum: Real, line_hz: float, rate_hz: float) -> float:
    weak = np.flatnonzero(spectrum < EXCITED * spectrum.max())
    last = weak[0] if weak.size else spectrum.size
    return min(float(last) * line_hz, USABLE * rate_hz)


@dataclass(frozen=True, eq=False, slots=True)
class ExpectedModes:
    """A belief, from the rig's beam or a model of an earlier test. Good to some per cent is good enough.

    Attributes:
        frequency_hz: (modes,) ascending.
        damping_ratio: of every mode.
        points: (points,) numbers of the points.
        at_points: (points, modes) shapes at unit modal mass, kg^-1/2.
        channels: (sensors,) places in the rig of the channels that sense this motion.
        at_sensors: (sensors, modes) the same where they are.
        derivative: (sensors,) of the displacement: 0, 1 or 2.
    """

    frequency_hz: Real
    damping_ratio: float
    points: tuple[int, ...]
    at_points: Real
    channels: tuple[int, ...]
    at_sensors: Real
    derivative: NDArray[np.int64]


REACH = 0.07
"""Lines within this part of a mode's frequency are fitted, and at least `LEAST_LINES` on either side."""
LEAST_LINES = 4
SEARCH = 0.04
"""A pole is looked for within this part of its frequency."""
DAMPING = (0.15, 5.0)
"""And within these factors of the believed damping."""
FREQUENCIES, DAMPINGS, ZOOMS = 25, 7, 2
LEAST_SENSED = 0.15
"""A mode is of use if some sensor stands where it has this part of its largest shape."""


@dataclass(frozen=True, eq=False, slots=True)
class Participation:
    """What one hit has excited.

    Attributes:
        modes: (used,) places in the expected modes.
        shape: (used,) their shapes where the hammer landed, kg^-1/2.
    """

    modes: NDArray[np.int64]
    shape: Real


def participation(answer: HitResponse, expected: ExpectedModes) -> Participation:
    """Fit the expected modes, as far as a hit has excited them, to its block."""
    force, rate_hz = answer.force, answer.rate_hz
    motion = answer.of(expected.channels)
    df = rate_hz / answer.force_n.size
    used: list[int] = []
    shapes: list[float] = []
    for mode, hz in enumerate(expected.frequency_hz):
        sensed, largest = expected.at_sensors[:, mode], np.abs(expected.at_points[:, mode]).max()
        if hz > answer.band_hz or np.abs(sensed).max() < LEAST_SENSED * largest:
            continue
        reach = max(REACH * hz, LEAST_LINES * df)
        lines = np.arange(max(1, int((hz - reach) / df)), min(force.size, int((hz + reach) / df) + 2))
        fit = _Fit(answer.force_n, force[lines], motion[:, lines], lines, rate_hz, expected.derivative)
        amplitude = fit.amplitude(float(hz), expected.damping_ratio)
        used.append(mode)
        shapes.append(float(amplitude @ sensed / (sensed @ sensed)))
    return Participation(np.array(used, dtype=np.int64), np.array(shapes))


@dataclass(frozen=True, eq=False, slots=True)
class _Fit:
    pulse: Real
    force: Complex128
    answer: Complex128
    lines: NDArray[np.int64]
    rate_hz: float
    derivative: NDArray[np.int64]

    def amplitude(self, hz: float, damping: float) -> Real:
        """(sensors,) real residue of the mode at its best pole."""
        low, high = hz * (1 - SEARCH), hz * (1 + SEARCH)
        least, most = np.log(damping * DAMPING[0]), np.log(damping * DAMPING[1])
        best = np.zeros(self.answer.shape[0])
        for _ in range(1 + ZOOMS):
            frequencies = np.linspace(low, high, FREQUENCIES)
            dampings = np.exp(np.linspace(least, most, DAMPINGS))
            f, z = (a.ravel() for a in np.meshgrid(frequencies, dampings, indexing="ij"))
            error, amplitudes = self._solve(f, z)
            at = int(np.argmin(error))
            best = amplitudes[at]
            wide, tall = 1.5 * (high - low) / FREQUENCIES, 1.5 * (most - least) / DAMPINGS
            low, high, least, most = f[at] - wide, f[at] + wide, np.log(z[at]) - tall, np.log(z[at]) + tall
        return best

    def _solve(self, hz: Real, zeta: Real) -> tuple[Real, Real]:
        """(poles,) squared error and (poles, sensors) residues, over poles."""
        mode = self._mode(hz, zeta)
        away = (self.lines - self.lines.mean()) / self.lines.size
        error, found = np.zeros(hz.size), np.zeros((hz.size, self.answer.shape[0]))
        for order in np.unique(self.derivative):
            rows = self.derivative == order
            turn = self._s ** (int(order) - 2)
            basis = np.stack(
                [mode * turn, *(np.broadcast_to(self.force * away**p * turn, mode.shape) for p in (0, 1))], axis=2
            )
            real = np.concatenate([basis.real, basis.imag], axis=1)
            seen = np.concatenate([self.answer[rows].real, self.answer[rows].imag], axis=1).T
            scale = np.maximum(np.linalg.norm(real, axis=1), 1e-300)[:, None, :]
            real = real / scale
            normal = real.transpose(0, 2, 1) @ real + 1e-9 * np.eye(3)
            right = real.transpose(0, 2, 1) @ seen
            solution = np.linalg.solve(normal, right)
            error += np.sum(seen**2) - np.einsum("pbs,pbs->p", solution, right)
            found[:, rows] = solution[:, 0] / scale[:, :, 0]
        return error, found

    @property
    def _s(self) -> Complex128:
        return np.asarray(2j * np.pi * self.lines * self.rate_hz / self.pulse.size, dtype=np.complex128)

    def _mode(self, hz: Real, zeta: Real) -> Complex128:
        """(poles, lines) acceleration of a unit mode in the block, what rings on after its end cut off."""
        omega, n, dt = 2 * np.pi * hz, self.pulse.size, 1 / self.rate_hz
        damped = omega * np.sqrt(1 - zeta**2)
        total = np.zeros((hz.size, self.lines.size), dtype=np.complex128)
        struck = np.flatnonzero(self.pulse)
        times, pulse = struck * dt, self.pulse[struck]
        for sign in (1, -1):
            pole = -zeta * omega + 1j * sign * damped
            residue = sign / (2j * damped)
            # Through exp(pole (T - t)) and never exp(-pole t), which runs over for strong damping.
            left = np.exp(pole[:, None] * (n * dt - times)) @ pulse * dt
            forced = self._s**2 / (self._s - pole[:, None]) * self.force
            tail = (pole**2 * left)[:, None] / (1 - np.exp(pole[:, None] * dt - self._s * dt)) if n else 0
            total += residue[:, None] * (forced - tail)
        return total
