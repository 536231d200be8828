"""How much of a response is nonlinear: what several random-phase multisines do not agree on, beyond the noise.

A nonlinear structure answers each wave as its best linear approximation does, and with distortions that change with the
phases as noise would. They repeat with the wave, which noise does not. So the scatter over the periods of one wave is
the noise's, and what the scatter over the waves exceeds it by is the distortions'.
Source: Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd ed. (2012), section 4.3.1, the
robust method.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex128, Real
from modallab.core.errors import DataError
from modallab.frf.broadband import PERIODIC, driven_lines
from modallab.frf.estimate import lines_of_band
from modallab.signals.block_sets import check_test
from modallab.signals.signals import Signals

ALIKE = 0.99
"""Two blocks are periods of one wave if their forces' spectra are so coherent."""


@dataclass(frozen=True, eq=False, slots=True)
class Distortions:
    """The best linear approximation, and what scatters about it.

    Attributes:
        frequency_hz: (lines,) that are driven.
        frf: (outputs, lines) the mean over all waves.
        noise: (outputs, lines) standard deviation of the FRF of one period by noise.
        excess: (outputs, lines) variance of the FRF of one wave by distortions; by chance it may be below 0.
        response: (outputs, lines) rms of the responses' spectra over the waves.
        force: (lines,) rms of the force's.
        waves: how many there are.
        periods: of each wave, at least.
    """

    frequency_hz: Real
    frf: Complex128
    noise: Real
    excess: Real
    response: Real
    force: Real
    waves: int
    periods: int

    @property
    def level(self) -> Real:
        """(outputs,) rms of the distortions over that of the response, over all lines."""
        power = np.sum(self.excess * self.force**2, axis=1)
        return np.asarray(np.sqrt(np.maximum(power, 0) / np.sum(self.response**2, axis=1)), np.float64)

    @property
    def noise_level(self) -> Real:
        """(outputs,) the same of the noise of one period."""
        return np.asarray(
            np.sqrt(np.sum((self.noise * self.force) ** 2, axis=1) / np.sum(self.response**2, axis=1)), np.float64
        )


def estimate_distortions(signals: Sequence[Signals], band_hz: tuple[float, float]) -> Distortions:
    """Distortions from blocks of one level, each a settled period of one of several random-phase multisines.

    Args:
        signals: blocks, equal in rate and length, of a pseudo-random drive.
        band_hz: lines to look at.

    Raises:
        DataError: not a periodic drive, fewer than two waves, or fewer than two periods of one.
    """
    check_test(signals)
    first = signals[0]
    if first.block.test not in PERIODIC:
        raise DataError(
            f"the blocks of a {first.block.test} drive have no period", remedy="drive with pseudo-random waves"
        )
    n, rate = first.force.size, first.rate_hz
    chosen = _of_every_wave(driven_lines(lines_of_band(n, rate, band_hz), signals), signals)
    force = np.stack([np.fft.rfft(s.force)[chosen] for s in signals])
    response = np.stack([np.fft.rfft(s.responses)[:, chosen] for s in signals])
    waves = group_blocks_by_wave(force)
    _require_several(waves)
    frf = response / force[:, None]
    of_wave = np.stack([frf[w].mean(axis=0) for w in waves])
    # Of one period; each wave tells it from as many periods less one.
    spread = sum(np.sum(np.abs(frf[w] - frf[w].mean(axis=0)) ** 2, axis=0) for w in waves)
    noise = np.asarray(spread / (len(signals) - len(waves)), np.float64)
    left = noise * np.mean([1 / len(w) for w in waves])
    total = np.var(of_wave, axis=0, ddof=1)
    return Distortions(
        frequency_hz=chosen * rate / n,
        frf=of_wave.mean(axis=0),
        noise=np.sqrt(noise),
        # Not cut off at 0 line by line, which would show distortions where there is only noise.
        excess=np.asarray(total - left, np.float64),
        response=np.sqrt(np.mean(np.abs(response) ** 2, axis=0)),
        force=np.sqrt(np.mean(np.abs(force) ** 2, axis=0)),
        waves=len(waves),
        periods=min(map(len, waves)),
    )


def _require_several(waves: Sequence[NDArray[np.int64]]) -> None:
    if len(waves) < 2 or min(map(len, waves)) < 2:
        raise DataError(
            f"there are {len(waves)} different waves, of {min(map(len, waves))} periods at least",
            remedy="drive several pseudo-random waves with different seeds, at least two blocks of each",
        )


def _of_every_wave(chosen: NDArray[np.int64], signals: Sequence[Signals]) -> NDArray[np.int64]:
    """Those of the lines that each block holds: where one holds none there is no FRF of it."""
    for one in signals:
        chosen = driven_lines(chosen, [one])
    return chosen


def group_blocks_by_wave(force: Complex128) -> list[NDArray[np.int64]]:
    """Places of the blocks of each wave, by the phases of the force, (blocks, lines)."""
    unit = force / np.linalg.norm(force, axis=1, keepdims=True)
    left, found = list(range(len(force))), list[NDArray[np.int64]]()
    while left:
        alike = np.abs(unit[left] @ unit[left[0]].conj()) > ALIKE
        found.append(np.array([k for k, same in zip(left, alike, strict=True) if same], dtype=np.int64))
        left = [k for k, same in zip(left, alike, strict=True) if not same]
    return found
