"""Settled records of a broadband drive as FRFs averaged over bands, with the noise of each.

The H1 estimate (Bendat and Piersol, Random Data, 2010) over the lines of a band and all records. Of the force's power
that of its own noise is taken off.
"""

from collections.abc import Sequence
from typing import TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.errors import DataError
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.gap.conditioning.rows import DataPiece, ImpactData, Weights, rows_of
from modallab.signals.signals import to_signals
from modallab.twin.response import AveragedFrfs

Lines = NDArray[np.int64]
V = TypeVar("V", Real, Complex)

BANDWIDTH = 0.003
"""Of the bands over which FRFs of a drive are averaged, over their frequency: half a light mode's half-power width."""
CLEAR, DRIVEN = 30.0, 0.1
"""A line is driven where the force's power is as many times its noise, and that share of the drive's median."""


def group_drives(blocks: Sequence[Block]) -> list[list[Block]]:
    """Records of broadband drives, those together that are of one drive and length."""
    found: dict[tuple[object, ...], list[Block]] = {}
    for b in blocks:
        if b.test in BROADBAND:
            found.setdefault((b.test, b.drive_point, b.level, b.n_samples), []).append(b)
    return list(found.values())


def reduce_drive(blocks: Sequence[Block], rig: Rig, weights: Weights) -> ImpactData:
    """Settled records of one drive as averages over bands: whatever the force was, its power alone counts.

    Raises:
        DataError: the force drives no line clear of its noise.
    """
    first = blocks[0]
    n, dt, test = first.n_samples, 1 / first.rate_hz, first.test
    signals = [to_signals(b, rig) for b in blocks]
    force, responses = (
        _spectra_of_records([s.forces for s in signals])[:, 0],
        _spectra_of_records([s.responses for s in signals]),
    )
    doubt = np.array([weights.doubt[b.name] for b in blocks])
    own = weights.force_noise(rig, test) ** 2 * n * len(blocks)
    fine, starts = _driven_bands(np.where(np.isfinite(doubt), np.abs(force) ** 2, 0).sum(axis=0), own)
    if not len(fine):
        raise DataError(f"the force of {first.name} does not exceed its noise", remedy="drive at a higher level")
    power: Real = np.abs(force[:, fine]) ** 2
    counts, whole = np.diff(starts, append=len(fine)), _sum_in_bands(power, starts)
    # What the force's own noise adds to its power drives nothing.
    clean = whole - counts * own
    y = _sum_in_bands(force[:, None, fine].conj() * responses[:, :, fine], starts) / clean
    lines = _sum_in_bands(power * fine.astype(np.float64), starts) / whole
    doubted = 1 + _sum_in_bands(power * doubt[:, fine], starts) / whole
    sigma = weights.sigma(rig, test, lines, n, dt) * np.sqrt(n / 2 / clean * doubted)
    sigma = np.hypot(sigma, weights.hum_amplitude(rig, test, lines, n, dt) * n / 2 / np.sqrt(2 * clean))
    sigma[[any((b.name, c.index) in weights.masked for b in blocks) for c in rig.responses]] = np.inf
    source = AveragedFrfs(lines, n, dt, fine.astype(float), power.sum(axis=0) / np.repeat(whole, counts), starts)
    force_noise = weights.force_noise(rig, test) * np.sqrt(n / 2 / clean)
    return ImpactData(_piece_of_drive(blocks, rig), source, rows_of(y, sigma, force_noise))


def _sum_in_bands(values: V, starts: Lines) -> V:
    """(..., bands) sums over the records (records, ..., lines) and over the lines of each band."""
    return cast(V, np.add.reduceat(values.sum(axis=0), starts, axis=-1))


def _spectra_of_records(records: Sequence[Real]) -> Complex:
    """(records, rows, lines) of records (rows, n)."""
    rows = np.array(records)
    return np.fft.rfft(rows - rows.mean(axis=2, keepdims=True), axis=2)


def _piece_of_drive(blocks: Sequence[Block], rig: Rig) -> DataPiece:
    first = blocks[0]
    return DataPiece(
        f"{first.test}_p{first.drive_point:02d}" + (f"_{first.level}" if first.level else ""),
        float(np.mean([b.order for b in blocks])),
        rig.x_of(first.drive_point or 0),
        first.level,
        tuple(b.name for b in blocks),
        test=first.test,
    )


def _driven_bands(power: Real, noise: float) -> tuple[Lines, Lines]:
    """The lines that a force of power (lines,) drives clear of its noise, and where among them each band begins."""
    clear = power[power > CLEAR * noise]
    fine = np.flatnonzero(power > max(CLEAR * noise, DRIVEN * float(np.median(clear)) if clear.size else np.inf))
    band = np.floor(np.log(fine / fine[:1]) / BANDWIDTH)
    return fine, np.flatnonzero(np.diff(band, prepend=-1))
