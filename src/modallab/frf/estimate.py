"""Steps B and C: spectra of blocks, and FRFs with coherence from them."""

from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy import ndimage

from modallab.core.arrays import Real
from modallab.core.axis_checks import check_frequencies, check_rate
from modallab.core.errors import DataError
from modallab.core.frf import DERIVATIVES, Frf, FrfQuantity
from modallab.core.rig import Rig
from modallab.core.units import DERIVATIVE
from modallab.frf.sums import Estimator, PowerSums, check_averages
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.signals import Signals


def output_quantity(rig: Rig) -> FrfQuantity:
    """Which FRF the outputs give directly: inertance for accelerometers.

    Raises:
        DataError: the outputs differ in quantity, or are none of motion.
    """
    kinds = {c.quantity for c in rig.responses}
    by_derivative: dict[int, FrfQuantity] = {d: q for q, d in DERIVATIVES.items()}
    quantity = next(iter(kinds)) if len(kinds) == 1 else "voltage"
    if quantity not in DERIVATIVE:
        raise DataError(
            f"the outputs measure {', '.join(sorted(kinds))}",
            remedy="identify channels of one kind of motion together: acceleration, velocity or displacement",
        )
    return by_derivative[DERIVATIVE[quantity]]


def convert_frf(frf: Frf, quantity: FrfQuantity) -> Frf:
    """The same FRF as receptance, mobility or inertance: times a power of s = damping_shift + j omega.

    Raises:
        DataError: lines that do not ascend, values that are not finite or not complex, or a division by s = 0.
    """
    check_frequencies(frf.frequency_hz, even=False)
    _check_shape(frf)
    if not (np.iscomplexobj(frf.values) and np.isfinite(frf.values).all()):
        raise DataError("the FRF holds NaN, or has no phase", remedy="give finite complex numbers")
    power = DERIVATIVES[quantity] - DERIVATIVES[frf.quantity]
    if power == 0:
        return frf
    s = frf.damping_shift + 2j * np.pi * frf.frequency_hz
    if power < 0 and s[0] == 0:
        raise DataError(
            f"{frf.quantity} at 0 Hz has no {quantity}", remedy="leave the line at 0 Hz out before converting"
        )
    return Frf(
        frequency_hz=frf.frequency_hz,
        values=frf.values * s**power,
        quantity=quantity,
        outputs=frf.outputs,
        output_points=frf.output_points,
        input_points=frf.input_points,
        coherence=frf.coherence,
        variance=None if frf.variance is None else frf.variance * np.abs(s) ** (2 * power),
        averages=frf.averages,
        damping_shift=frf.damping_shift,
    )


def _check_shape(frf: Frf) -> None:
    shape, lines = frf.values.shape, frf.frequency_hz.size
    if len(shape) != 3 or 0 in shape or shape[2] != lines or shape[0] != len(frf.outputs):
        raise DataError(
            f"the FRF has shape {shape}, with {len(frf.outputs)} outputs and {lines} lines",
            remedy="give (outputs, inputs, lines), at least one of each",
        )


def lines_of_band(n: int, rate_hz: float, band_hz: tuple[float, float]) -> NDArray[np.int64]:
    """Indices of the DFT lines of an n-sample block inside a band, never the line at 0 Hz.

    Raises:
        DataError: fewer than 4 lines lie inside.
    """
    check_rate(rate_hz)
    if not (n > 0 and np.isfinite(band_hz).all() and band_hz[0] < band_hz[1]):
        raise DataError(
            f"the band {band_hz[0]:g} to {band_hz[1]:g} Hz of a block of {n} samples has no lines",
            remedy="give the lower edge first, both in Hz, and a block with samples",
        )
    resolution = rate_hz / n
    first = max(1, int(np.ceil(band_hz[0] / resolution - 1e-9)))
    last = min((n - 1) // 2, int(np.floor(band_hz[1] / resolution + 1e-9)))
    if last - first < 3:
        raise DataError(
            f"the band {band_hz[0]:g} to {band_hz[1]:g} Hz holds {max(0, last - first + 1)} of the block's lines, "
            f"which stand {resolution:.4g} Hz apart up to {rate_hz / 2:g} Hz",
            remedy="widen the band or record longer blocks",
        )
    return np.arange(first, last + 1)


def combine_spectra(
    force: NDArray[np.complex128], response: NDArray[np.complex128], estimator: Estimator = "H1"
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """One input's FRF and ordinary coherence from the spectra of its blocks, as `PowerSums` gives them.

    Args:
        force: (blocks, lines) spectra of the force.
        response: (blocks, outputs, lines) spectra of the responses.
        estimator: H1, H2 or Hv.

    Returns:
        FRF (outputs, lines) and coherence (outputs, lines) in 0 to 1; with one block coherence is 1 by construction.

    Raises:
        DataError: shapes that do not fit, NaN, or a line without force.
    """
    return PowerSums.of(force, response).frf(estimator)


def impact_frf(
    groups: Sequence[Sequence[Signals]],
    rig: Rig,
    band_hz: tuple[float, float],
    *,
    estimator: Estimator = "H1",
    damping_shift: float = 0.0,
) -> Frf:
    """FRFs of an impact test, one input per group of hits at one point.

    With a damping shift sigma both force and response are multiplied by exp(-sigma t). The result is then the
    structure's FRF at s = sigma + j omega, in which even a ring-down longer than the block has died out;
    a pole found in it is the structure's pole less sigma. (Exact for a block that begins at rest.)

    Args:
        groups: per input the hits, equal in rate and length.
        rig: names, points and quantities of the channels.
        band_hz: lines to give.
        estimator: H1, H2 or Hv.
        damping_shift: sigma in 1/s.

    Raises:
        DataError: no blocks, blocks that differ or that no bench records, other outputs than the rig's, a block without
            a hit, a band without lines, or a point with one hit for H2 or Hv.
    """
    check_test([s for group in groups for s in group])
    check_averages(estimator, [len(group) for group in groups], "hits")
    first = groups[0][0]
    check_outputs(first, rig)
    n, rate = first.force.size, first.rate_hz
    chosen = lines_of_band(n, rate, band_hz)
    found = [
        reduce(PowerSums.with_more, (hit_sums(s, chosen, damping_shift) for s in group)).frf(estimator)
        for group in groups
    ]
    return Frf(
        frequency_hz=chosen * rate / n,
        values=np.stack([value for value, _ in found], axis=1),
        quantity=output_quantity(rig),
        outputs=first.outputs,
        output_points=tuple(c.point for c in rig.responses),
        input_points=tuple(group[0].block.drive_point for group in groups),
        coherence=np.stack([coherence for _, coherence in found], axis=1),
        averages=tuple(len(group) for group in groups),
        damping_shift=damping_shift,
    )


def hit_sums(signals: Signals, chosen: NDArray[np.int64], damping_shift: float = 0.0) -> PowerSums:
    """What one hit adds to the FRF of its point.

    Args:
        signals: the hit's block.
        chosen: indices of the lines.
        damping_shift: sigma in 1/s, as in `impact_frf`.

    Raises:
        DataError: a block without a hit.
    """
    response = signals.responses - pre_trigger_level(signals)[:, None]
    force = signals.hit_force
    if damping_shift:
        window = np.exp(-damping_shift * np.arange(force.size) / signals.rate_hz)
        force, response = force * window, response * window
    # A slice of lines is a view; picking them by index would copy the largest array there is.
    band = slice(int(chosen[0]), int(chosen[-1]) + 1)
    # scipy's transform is faster than numpy's where the length has large prime factors.
    return PowerSums.of(scipy.fft.rfft(force)[None, band], scipy.fft.rfft(response)[None, :, band])


def pre_trigger_level(signals: Signals) -> NDArray[np.float64]:
    """Level of each output (outputs,) before the hit; where there is too little of it, the block's mean."""
    first = signals.hit.first
    if first < 16:
        return signals.responses.mean(axis=1)
    return signals.responses[:, :first].mean(axis=1)


def group_by_point(signals: Sequence[Signals]) -> list[list[Signals]]:
    """Blocks by drive point, in the order in which the points came."""
    groups: dict[int | None, list[Signals]] = {}
    for item in signals:
        groups.setdefault(item.block.drive_point, []).append(item)
    return list(groups.values())


LEAST = 1e-6
"""Below this 1 - coherence is rounding."""
THIRD = 20.0
"""Sum of squares of the third difference's coefficients 1, 3, 3, 1: its variance over that of a line."""
NEIGHBOURS = 31
"""Lines over which the median is taken: more than a resonance is wide, whose lines differ for another reason."""
LOG2 = float(np.log(2.0))
"""Median over mean of the square of a complex normal number."""


def variance_of(frf: Frf) -> Real:
    """(outputs, inputs, lines) variance of the complex FRFs."""
    stated = frf.variance if frf.variance is not None else variance_by_coherence(frf)
    if stated is not None and np.all(np.isfinite(stated)):
        return np.asarray(stated, np.float64)
    if frf.frequency_hz.size < NEIGHBOURS:
        return np.zeros(frf.values.shape)
    third = np.diff(frf.values, 3, axis=-1)
    power = np.abs(np.concatenate([third[..., :1], third, third[..., -2:]], axis=-1)) ** 2 / THIRD
    size = (1,) * (power.ndim - 1) + (NEIGHBOURS,)
    return ndimage.median_filter(power, size=size, mode="nearest") / LOG2


def variance_by_coherence(frf: Frf) -> NDArray[Any] | None:
    """(outputs, inputs, lines) as coherence and averages say it; None without them."""
    coherence = frf.coherence
    if coherence is None or np.all(coherence > 1 - LEAST):
        # Of one average it is 1 by construction.
        return None
    averages = np.array(frf.averages or (1,) * frf.values.shape[1], dtype=np.float64)[None, :, None]
    known = np.clip(coherence, LEAST, 1 - LEAST)
    return np.abs(frf.values) ** 2 * (1 - known) / (averages * known)
