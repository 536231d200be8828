"""Records of a broadband drive, joined and settled: what the force of a record answers, and no more.

Blocks that follow each other without a gap are one record. It begins with what rang before it and ends with what still
rings. One free decay of each mode stands for both: without it the record is what the force would make if it repeated
for ever, whatever the force was. On each line the response then is the FRF times the force, with no leakage.
Source: Pintelon and Schoukens, "System Identification: A Frequency Domain Approach", 2nd ed. (2012), section 2.6.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Complex, Real
from modallab.core.block import Block
from modallab.core.errors import ModallabError
from modallab.core.rig import Rig
from modallab.core.units import BROADBAND
from modallab.frf.broadband import driven_band
from modallab.frf.joined import contiguous_blocks
from modallab.frf.periodic_drive import frf_of_main_level, resample_blocks_to_drive_clock
from modallab.identification.frf_model import identify_frf
from modallab.identification.likelihood.basis import poles_of
from modallab.identification.options import IdentificationOptions
from modallab.signals.signals import Signals, to_signals

LOOKS = 5
"""Steps that bring poles of FRFs to those of the records, each of which squares the error."""
NEXT = np.array([1.04, 1.1, 1.25, 1.6]) * (-0.005 + 1j)
"""Poles that stand for modes above the band together, over the band's end."""
OUT_OF_BAND = (0, 1, 2)
"""Powers of s of what modes outside the band answer, as the terms of the responses need them."""


@dataclass(frozen=True, eq=False, slots=True)
class SettledRecords:
    """Records whose broadband ones are joined and without free decays.

    Attributes:
        blocks: all records.
        poles: that the drives show.
        doubt: record -> (lines,) variance that the decays' sizes leave on each DFT line, over that of noise; inf beyond
            the band.
    """

    blocks: tuple[Block, ...]
    poles: Complex
    doubt: dict[str, Real]


def join_drive_records(blocks: Sequence[Block], rig: Rig) -> SettledRecords:
    """The records of broadband drives joined and without free decays, other records as they are.

    Args:
        blocks: of a campaign, in V.
        rig: its bench.
    """
    kept = [b for b in blocks if b.test not in BROADBAND]
    found: list[Complex] = [np.zeros(0, np.complex128)]
    doubt: dict[str, Real] = {}
    for _, drive in groupby(
        sorted((b for b in blocks if b.test in BROADBAND), key=_drive_of_block), key=_drive_of_block
    ):
        signals = [to_signals(b, rig) for b in drive]
        band = driven_band(signals)
        parts = (_join_run(part) for run in contiguous_blocks(signals) for part in _fitted_and_held_out(run))
        records = [_Record.of(block, rig, band) for block in parts]
        poles = _refine_poles(records, _poles_of_drive(signals, rig, band))
        found.append(poles)
        for record in records:
            block, doubt[record.block.name] = record.settled(poles)
            kept.append(block)
    return SettledRecords(tuple(sorted(kept, key=lambda b: b.order)), max(found, key=len), doubt)


def _drive_of_block(block: Block) -> tuple[str, int, str, int]:
    """Records with the same are of one test, driven at one point at one level."""
    return block.test, block.drive_point or 0, block.level or "", block.n_samples


def _poles_of_drive(signals: Sequence[Signals], rig: Rig, band_hz: tuple[float, float]) -> Complex:
    """The modes that the FRFs of a drive show, sorted; none where they show none."""
    try:
        model, _ = identify_frf(
            frf_of_main_level(resample_blocks_to_drive_clock(signals, band_hz), rig, band_hz),
            rig,
            IdentificationOptions(),
        )
    except ModallabError:
        return np.zeros(0, np.complex128)
    return np.asarray(poles_of(2 * np.pi * model.frequency_hz, model.damping_ratio))


def _fitted_and_held_out(run: Sequence[Signals]) -> list[Sequence[Signals]]:
    """A run of blocks, the last third of them apart, so that it can be held out."""
    cut = len(run) - len(run) // 3
    return [part for part in (run[:cut], run[cut:]) if part]


def _join_run(run: Sequence[Signals]) -> Block:
    blocks = [s.block for s in run]
    return replace(
        blocks[0],
        samples=np.concatenate([np.asarray(b.samples, np.float64) for b in blocks], axis=1),
        order=round(float(np.mean([b.order for b in blocks]))),
    )


def _refine_poles(records: Sequence["_Record"], poles: Complex) -> Complex:
    """The poles after some steps by what the derivatives of all answers by each pole take up."""
    for _ in range(LOOKS if len(poles) else 0):
        residues, slopes = map(np.concatenate, zip(*(r.slopes(poles) for r in records), strict=True))
        step = np.sum(residues.conj() * slopes, axis=0) / np.sum(np.abs(residues) ** 2, axis=0)
        poles = poles + step * np.minimum(1, -poles.real / np.maximum(np.abs(step), 1e-300) / 2)
    return poles


@dataclass(frozen=True, eq=False, slots=True)
class _Record:
    """A joined record.

    Attributes:
        block: the record.
        rows: of the responses.
        lines: (k,) DFT lines of the drive's band.
        force: (k,) its spectrum there.
        responses: (outputs, k).
    """

    block: Block
    rows: list[int]
    lines: NDArray[np.int64]
    force: Complex
    responses: Complex

    @classmethod
    def of(cls, block: Block, rig: Rig, band_hz: tuple[float, float]) -> Self:
        """Of a block in V, on the lines of a band."""
        line_s = block.n_samples / block.rate_hz
        lines = np.arange(max(1, round(band_hz[0] * line_s)), round(band_hz[1] * line_s) + 1)
        volts = block.samples - block.samples.mean(axis=1, keepdims=True)
        spectra = np.fft.rfft(volts, axis=1)[:, lines]
        rows = [c.index for c in rig.responses]
        return cls(block, rows, lines, spectra[rig.force_channel.index], spectra[rows])

    def settled(self, poles: Complex) -> tuple[Block, Real]:
        """The record less the decays of these poles, and the doubt (lines,) that it leaves, see `SettledRecords`."""
        poles = np.append(poles, self._above)
        decays = self._decays(poles)
        sizes, covariance = self._sizes([*self._answers(poles), *self._out_of_band()], decays)
        samples, n = np.array(self.block.samples, np.float64), len(decays)
        samples[self.rows] -= sizes[-n:].T @ decays
        spectra = np.fft.rfft(decays, axis=1)
        # Beyond the band nothing was fitted.
        doubt = np.full(spectra.shape[1], np.inf)
        spectra = spectra[:, self.lines]
        doubt[self.lines] = np.einsum("il,ij,jl->l", spectra.conj(), covariance[-n:, -n:], spectra).real / 2
        return replace(self.block, samples=samples), doubt

    def slopes(self, poles: Complex) -> tuple[Complex, Complex]:
        """(outputs, modes) residues at these poles, and what their derivatives by the pole take up."""
        every = np.append(poles, self._above)
        answers = [*self._answers(poles), *self._answers(poles, 2), *self._answers(self._above), *self._out_of_band()]
        n, sizes = len(poles), self._sizes(answers, self._decays(every))[0]
        residues, slopes = (sizes[k : k + n] + 1j * sizes[k + n : k + 2 * n] for k in (0, 2 * n))
        return residues.T, slopes.T

    def _sizes(self, answers: Sequence[Complex], decays: Real) -> tuple[Real, Real]:
        """(columns, outputs) by least squares: of the answers (k,) to the force, then of decays (decays, samples).

        With their covariance, (columns, columns), where each part of a line has the variance 1.
        """
        spectra = np.fft.rfft(decays, axis=1)[:, self.lines]
        flat = np.concatenate([np.array(answers) * self.force, spectra]).T
        columns = np.concatenate([flat.real, flat.imag])
        scale = np.linalg.norm(columns, axis=0)
        q, r = np.linalg.qr(columns / scale)
        inverse = np.linalg.pinv(r, rcond=1e-12) / scale[:, None]
        seen = np.concatenate([self.responses.real, self.responses.imag], axis=1).T
        return inverse @ (q.T @ seen), inverse @ inverse.T

    def _decays(self, poles: Complex) -> Real:
        wave = np.exp(np.outer(poles, np.arange(self.block.n_samples) / self.block.rate_hz))
        return np.concatenate([wave.real, wave.imag])

    @property
    def _s(self) -> Complex:
        return 2j * np.pi * self.lines * self.block.rate_hz / self.block.n_samples

    @property
    def _above(self) -> Complex:
        return np.asarray(NEXT * np.abs(self._s[-1]))

    def _answers(self, poles: Complex, power: int = 1) -> list[Complex]:
        """Real and imaginary parts of residues over (s - pole) ** power."""
        up, down = (1 / (self._s - p[:, None]) ** power for p in (poles, poles.conj()))
        return [*(up + down), *(1j * (up - down))]

    def _out_of_band(self) -> list[Complex]:
        return [(self._s / abs(self._s[-1])) ** power for power in OUT_OF_BAND]
