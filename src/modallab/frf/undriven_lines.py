"""Even and odd distortions, from what a structure answers at lines that a periodic drive leaves out.

A linear structure answers at the lines that are driven and nowhere else. A law that is the same both ways, such as a
spring that stiffens, makes odd combinations of them, one that is not makes even ones. Where the drive holds odd lines
alone, the even lines show the even distortions; odd lines that are left out now and then show the odd ones, which are
as large at the lines that are driven.
Source: Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd ed. (2012), section 4.3.2, the
fast method.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.frf.broadband import LEFT_OUT, SMOOTHED, driven_lines
from modallab.frf.distortions import group_blocks_by_wave
from modallab.frf.estimate import lines_of_band
from modallab.signals.block_sets import check_test
from modallab.signals.signals import Signals

Flags = NDArray[np.bool_]

LEAST = 4
"""Lines of each kind that there must be."""


@dataclass(frozen=True, eq=False, slots=True)
class UndrivenDistortions:
    """Even and odd distortion of each output, at lines that the drive leaves out: rms over that of the response.

    Attributes:
        odd: at the lines that are driven, known from the waves that leave them out.
        even: at all even lines.
        odd_sigma: standard deviation of `odd`, since waves and lines are few.
        even_sigma: the same of `even`.
        noise_level: of one period, at the lines that are driven.
        waves: how many there are.
        periods: of each wave, at least.
    """

    odd: Real
    even: Real
    odd_sigma: Real
    even_sigma: Real
    noise_level: Real
    waves: int
    periods: int

    @property
    def level(self) -> Real:
        """(outputs,) of both together."""
        return np.hypot(self.odd, self.even)


@dataclass(frozen=True, eq=False, slots=True)
class _Waves:
    """What each wave shows at the lines from the lowest that is driven to the highest.

    Attributes:
        order: (lines,) multiple of the lowest frequency that the drive could have; 0 where it is none.
        driven: (waves, lines) whether the wave holds the line.
        power: (waves, outputs, lines) of the answer; where the line is left out, without what the force holds there
            all the same, and without noise, so that by chance it may be below 0.
        noise: (waves, outputs, lines) power of noise in one period.
        periods: of each wave, at least.
    """

    order: NDArray[np.int64]
    driven: Flags
    power: Real
    noise: Real
    periods: int


def has_undriven_lines(signals: Sequence[Signals], band_hz: tuple[float, float]) -> bool:
    """Whether a periodic drive holds odd lines alone.

    Args:
        signals: blocks, equal in rate and length.
        band_hz: lines to look at.
    """
    first = signals[0]
    driven = driven_lines(lines_of_band(first.force.size, first.rate_hz, band_hz), signals)
    return bool(np.all(driven // np.gcd.reduce(driven) % 2 == 1))


def distortions_at_undriven_lines(signals: Sequence[Signals], band_hz: tuple[float, float]) -> UndrivenDistortions:
    """Distortions from blocks of one level, each a settled period of a drive that leaves lines out.

    Args:
        signals: blocks, equal in rate and length: two periods or more of each of several waves, which hold odd lines
            alone and not all of these.
        band_hz: lines to look at.

    Raises:
        DataError: fewer than two waves of two periods, even lines that are driven, or no odd lines that one wave
            drives and another leaves out.
    """
    check_test(signals)
    first = signals[0]
    seen = _spectra_of_waves(signals, driven_lines(lines_of_band(first.force.size, first.rate_hz, band_hz), signals))
    ever, always = seen.driven.any(axis=0), seen.driven.all(axis=0)
    odd = (seen.order % 2 == 1) & ever & ~always
    even = (seen.order > 0) & (seen.order % 2 == 0) & ~ever
    if odd.sum() < LEAST or even.sum() < LEAST:
        raise DataError(
            f"{odd.sum()} odd lines are driven by one wave and left out by another, {even.sum()} even ones are left"
            f" out; needed: {LEAST} of each",
            remedy="drive with detection_lines, four waves or more",
        )
    share = seen.driven.mean(axis=0)
    response = _mean_of_waves(np.abs(seen.power), seen.driven) * share
    in_odd, in_all = response[:, odd].sum(axis=1), response[:, ever].sum(axis=1)
    odd_level, odd_sigma = _distortion_level(seen.power[..., odd], ~seen.driven[:, odd], share[odd], in_odd)
    even_level, even_sigma = _distortion_level(
        seen.power[..., even], ~seen.driven[:, even], np.ones(even.sum()), in_all
    )
    noise = np.sum(share[ever] * seen.noise.mean(axis=0)[:, ever], axis=1)
    return UndrivenDistortions(
        odd=odd_level,
        even=even_level,
        odd_sigma=odd_sigma,
        even_sigma=even_sigma,
        noise_level=np.sqrt(noise / in_all),
        waves=len(seen.driven),
        periods=seen.periods,
    )


def _spectra_of_waves(signals: Sequence[Signals], driven: NDArray[np.int64]) -> _Waves:
    chosen = np.arange(driven[0], driven[-1] + 1)
    force = np.stack([np.fft.rfft(s.force)[chosen] for s in signals])
    response = np.stack([np.fft.rfft(s.responses)[:, chosen] for s in signals])
    waves = [w for w in group_blocks_by_wave(force) if len(w) > 1]
    if len(waves) < 2:
        raise DataError(
            f"there are {len(waves)} different waves of two periods or more",
            remedy="drive at least four waves, with at least two blocks each",
        )
    held = np.stack([_usable_waves(np.abs(force[w].mean(axis=0)) ** 2) for w in waves])
    # What the force holds where it should hold nothing, by a shaker that distorts itself, the structure answers too.
    answered = response - _frf_between_lines(force, response, driven - driven[0], chosen.size) * force[:, None]
    power, noise = [], []
    for w, holds in zip(waves, held, strict=True):
        own = np.where(holds, response[w], answered[w])
        spread = np.var(own, axis=0, ddof=1)
        noise.append(spread)
        power.append(np.abs(own.mean(axis=0)) ** 2 - spread / len(w))
    base = np.gcd.reduce(driven)
    order = np.where(chosen % base == 0, chosen // base, 0)
    return _Waves(order, held, np.stack(power), np.stack(noise), min(map(len, waves)))


def _usable_waves(power: Real) -> Flags:
    return np.asarray(power > LEFT_OUT * ndimage.maximum_filter1d(power, SMOOTHED))


def _frf_between_lines(force: Complex128, response: Complex128, driven: NDArray[np.int64], count: int) -> Complex128:
    """(outputs, lines) H1 of all blocks at the lines that are driven, and straight lines between them."""
    h = np.sum(response * force[:, None].conj(), axis=0)[:, driven] / np.sum(np.abs(force) ** 2, axis=0)[driven]
    at = np.arange(count)
    return np.stack([np.interp(at, driven, one.real) + 1j * np.interp(at, driven, one.imag) for one in h])


def _mean_of_waves(values: Real, of: Flags) -> Real:
    """(outputs, lines) mean of (waves, outputs, lines) over the waves that count at a line."""
    return np.sum(values * of[:, None], axis=0) / np.maximum(of.sum(axis=0), 1)


def _distortion_level(power: Real, undriven: Flags, share: Real, response: Real) -> tuple[Real, Real]:
    """Rms over that of the response, and its standard deviation: at random phases a line's power scatters by itself."""
    square = np.maximum(np.sum(share * _mean_of_waves(power, undriven), axis=1), 0) / response
    scatter = share**2 * _mean_of_waves(power**2, undriven) / 2 / np.maximum(undriven.sum(axis=0), 1)
    level = np.sqrt(square)
    return level, np.sqrt(square + np.sqrt(np.sum(scatter, axis=1)) / response) - level
