"""How frequency and damping of each mode go with its amplitude, from records at several levels.

At one level a resonance of a nonlinear structure is that of the linear one nearest to it. By harmonic balance the
frequency of a cubic spring goes with the square of the amplitude (Worden and Tomlinson, Nonlinearity in Structural
Dynamics, 2001, ch. 2 and 3). Of a random motion that square is <a^4> / <a^2>, of the decay after a hit the slope of
the phase that it adds.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from modallab.core.arrays import Complex128, Real
from modallab.core.frf import DERIVATIVES, Frf
from modallab.core.model import Backbone, ModalModel
from modallab.frf.estimate import convert_frf
from modallab.identification.likelihood.basis import poles_of
from modallab.signals.signals import Signals

NEAR = 0.12
"""Relative: as far from where the mode stood at the level before it is looked for."""
SIGMAS = 3.0
LEAST_LINES = 8
"""Within the band of a mode: its pole, constant and rest take three complex numbers of each FRF."""
_FREQUENCIES = np.linspace(1 - 0.8 * NEAR, 1 + 0.8 * NEAR, 49)
_DAMPINGS = np.array([0.25, 0.5, 1.0, 2.0, 4.0, 8.0])


@dataclass(frozen=True, eq=False, slots=True)
class DriveLevel:
    """What was recorded at one level.

    Attributes:
        name: of the level.
        frf: of its records.
        records: at least one.
        repeats: FRFs of each record alone, which show by how much a mode shifts at one level; () if they do not.
    """

    name: str
    frf: Frf
    records: Sequence[Signals]
    repeats: Sequence[Frf] = ()


@dataclass(frozen=True, eq=False, slots=True)
class FollowedModes:
    """The modes of a model, followed from level to level.

    Attributes:
        backbone: of each mode.
        alone: (modes,) whether a resonance of its own stands where the mode does at the first level. An overtone of a
            nonlinear mode has none.
    """

    backbone: Backbone
    alone: NDArray[np.bool_]


def backbone_of(model: ModalModel, levels: Sequence[DriveLevel]) -> FollowedModes:
    """Frequency and damping of each mode at each level, with the amplitude there; NaN where lines are too few.

    Args:
        model: of the first level.
        levels: from the weakest to the strongest, at least two.
    """
    shape = (model.n_modes, len(levels))
    frequency, damping, sigma_hz, sigma_zeta, amplitude = (np.full(shape, np.nan) for _ in range(5))
    poles = poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio)
    sensors: list[str] = []
    for r, pole in enumerate(poles):
        away: list[list[Real]] = []
        sensor = int(np.argmax(np.abs(model.modal_constants[r]).max(axis=1)))
        sensors.append(model.outputs[sensor])
        for k, level in enumerate(levels):
            band = _band_around_pole(r, poles, pole)
            if not _has_enough_lines(level.frf, band):
                break
            pole, sigma = nearest_pole(level.frf, pole, band)
            frequency[r, k], damping[r, k] = abs(pole) / (2 * np.pi), -pole.real / abs(pole)
            sigma_hz[r, k], sigma_zeta[r, k] = sigma
            away.append([_relative_shift(nearest_pole(one, pole, band, near=True)[0], pole) for one in level.repeats])
            amplitude[r, k] = amplitude_of(level, pole, band, sensor)
        scatter = _scatter_of_levels(away)
        sigma_hz[r] = np.hypot(sigma_hz[r], frequency[r] * scatter[0])
        sigma_zeta[r] = np.hypot(sigma_zeta[r], damping[r] * scatter[1])
    found = Backbone(
        levels=tuple(level.name for level in levels),
        sensors=tuple(sensors),
        amplitude_m=amplitude,
        frequency_hz=frequency,
        frequency_sigma_hz=sigma_hz,
        damping_ratio=damping,
        damping_sigma=sigma_zeta,
    )
    first = np.array([_band_around_pole(r, poles, pole) for r, pole in enumerate(poles)]) / (2 * np.pi)
    return FollowedModes(found, ~((frequency[:, 0] < first[:, 0]) | (frequency[:, 0] > first[:, 1])))


def nearest_pole(
    frf: Frf, start: complex, band: tuple[float, float], *, near: bool = False
) -> tuple[complex, tuple[float, float]]:
    """The pole of the one mode that fits FRFs best within a band, with sigmas of its frequency in Hz and its damping.

    What one mode and rest terms leave is taken for noise, so that the sigmas hold what bends a resonance.

    Args:
        frf: of any quantity.
        start: where the mode stood at the level before.
        band: in rad/s.
        near: whether it is where it stood.
    """
    receptance = convert_frf(frf, "receptance")
    omega = 2 * np.pi * receptance.frequency_hz
    inside = (omega > band[0]) & (omega < band[1])
    s = (receptance.damping_shift + 1j * omega[inside]).astype(np.complex128)
    # Weighted as an acceleration, in which noise is even.
    rows = (receptance.values[:, :, inside] * s**2).reshape(-1, s.size).T
    measured = np.vstack([rows.real, rows.imag])

    def rest(at: Real) -> Real:
        return _residual_of_pole(s, measured, _fit_pole(start, at)).ravel()

    grid = [(0.0, 0.0)] if near else [(np.log(f), np.log(z)) for f in _FREQUENCIES for z in _DAMPINGS]
    best = min(grid, key=lambda at: float(np.sum(rest(np.array(at)) ** 2)))
    found = least_squares(rest, np.array(best), x_scale=[1e-3, 0.1])
    freedom = max(1, measured.size - 4 * measured.shape[1] - 2)
    slopes = np.asarray(found.jac, np.float64)
    covariance = np.linalg.pinv(slopes.T @ slopes) * 2 * float(found.cost) / freedom
    pole = _fit_pole(start, found.x)
    relative = np.sqrt(np.diag(covariance))
    return pole, (float(relative[0] * abs(pole) / (2 * np.pi)), float(relative[1] * -pole.real / abs(pole)))


def amplitude_of(level: DriveLevel, pole: complex, band: tuple[float, float], sensor: int) -> float:
    """The amplitude in m of a mode at one sensor: what its frequency at this level is that of."""
    squares, weights = 0.0, 0.0
    for record in level.records:
        values = record.responses[sensor] - record.responses[sensor].mean()
        spectrum = np.fft.fft(values)
        omega = 2 * np.pi * np.fft.fftfreq(values.size, 1 / record.rate_hz)
        analytic = np.fft.ifft(2 * spectrum * ((omega > band[0]) & (omega < band[1])))
        power = np.abs(analytic / abs(pole) ** DERIVATIVES[level.frf.quantity]) ** 2
        weight = float(np.sum(power))
        squares += weight * _square_of_amplitude(power, level.frf.damping_shift / record.rate_hz)
        weights += weight
    return float(np.sqrt(squares / weights)) if weights else 0.0


def _square_of_amplitude(power: Real, shift: float) -> float:
    """The square of the amplitude that the frequency of a linear fit belongs to.

    Args:
        power: (n,) square of the envelope.
        shift: decay of the FRF's window in a sample; 0 for random drive, in which the phase begins anew all the time.
    """
    if not shift:
        return float(np.sum(power**2) / np.sum(power))
    # A decay's frequency is the slope of its phase, which grows by the square: a regression, weighted as the fit is.
    time = np.arange(power.size)
    weight = power * np.exp(-2 * shift * time)
    weight /= np.sum(weight)
    away = time - np.sum(weight * time)
    return float(np.sum(weight * away * np.cumsum(power)) / np.sum(weight * away**2))


def is_nonlinear(found: Backbone) -> NDArray[np.bool_]:
    """(modes,) whether a mode's frequency or damping changes with the level by more than it is known."""
    one, other = [0] * len(found.levels[1:]), [*range(1, len(found.levels))]
    parts = ((found.frequency_hz, found.frequency_sigma_hz), (found.damping_ratio, found.damping_sigma))
    changes = [
        np.abs(v[:, other] - v[:, one]) > SIGMAS * np.hypot(sigma[:, other], sigma[:, one]) for v, sigma in parts
    ]
    return np.any(changes[0] | changes[1], axis=1)


def backbone_notes(found: Backbone) -> tuple[str, ...]:
    """A sentence on each mode that goes with the amplitude, with its numbers at each level."""
    notes: list[str] = []
    for r in np.flatnonzero(is_nonlinear(found)):
        parts = [
            f"{f:.6g} Hz and {100 * z:.3g} % at {1e3 * a:.3g} mm"
            for f, z, a in zip(found.frequency_hz[r], found.damping_ratio[r], found.amplitude_m[r], strict=True)
        ]
        rises = found.frequency_hz[r, -1] > found.frequency_hz[r, 0]
        change = f"{'hardens' if rises else 'softens'} with its amplitude"
        notes.append(f"Nonlinear: mode {r + 1} {change}, {'; '.join(parts)} ({found.sensors[r]}).")
    return tuple(notes)


def _relative_shift(pole: complex, of: complex) -> Real:
    """How far frequency and damping ratio of a pole are from those of another, as shares of these."""
    zeta, other = -pole.real / abs(pole), -of.real / abs(of)
    return np.array([abs(pole) / abs(of) - 1, zeta / other - 1])


def _scatter_of_levels(away: Sequence[Sequence[Real]]) -> Real:
    """(2, levels) by how much the means of levels may be off as records of one level differ, as shares."""
    freedom = sum(len(each) - 1 for each in away if each)
    if freedom < 1 or len(away) < 1:
        return np.zeros((2, 1))
    squares = sum(np.sum((np.array(each) - np.mean(each, axis=0)) ** 2, axis=0) for each in away if each)
    counts = np.array([max(len(each), 1) for each in away])
    return np.sqrt(squares / freedom)[:, None] / np.sqrt(counts)


def _has_enough_lines(frf: Frf, band: tuple[float, float]) -> bool:
    omega = 2 * np.pi * frf.frequency_hz
    return int(np.count_nonzero((omega > band[0]) & (omega < band[1]))) >= LEAST_LINES


def _band_around_pole(mode: int, poles: Complex128, pole: complex) -> tuple[float, float]:
    """Around a pole, up to half way to its neighbours, in rad/s."""
    low, high = (1 - NEAR) * abs(pole), (1 + NEAR) * abs(pole)
    others = np.abs(np.delete(poles, mode))
    below, above = others[others < abs(poles[mode])], others[others > abs(poles[mode])]
    middle = [(abs(pole) + other) / 2 for other in (below.max(initial=0.0), above.min(initial=np.inf))]
    return max(low, middle[0]), min(high, middle[1])


def _fit_pole(start: complex, at: Real) -> complex:
    zeta = min(-start.real / abs(start) * float(np.exp(at[1])), 0.5)
    return complex(poles_of(np.array([abs(start) * np.exp(at[0])]), np.array([zeta]))[0])


def _residual_of_pole(s: Complex128, measured: Real, pole: complex) -> Real:
    """What the modal constant and two rest terms of each FRF leave; the constants follow from the pole."""
    one, other = s**2 / (s - pole), s**2 / (s - pole.conjugate())
    columns = np.stack([one + other, 1j * (one - other), s**2, np.ones_like(s)], axis=1)
    basis = np.vstack([columns.real, columns.imag])
    q, _ = np.linalg.qr(basis / np.linalg.norm(basis, axis=0))
    return measured - q @ (q.T @ measured)
