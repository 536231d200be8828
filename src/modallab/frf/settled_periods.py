"""Blocks of a periodic drive as they would be once the structure has settled.

A periodic drive begins from rest, so that its first periods hold the free decays of the modes besides. A lightly
damped low mode may need longer to settle than a whole test takes. Blocks that follow each other are whole periods: they
differ by those decays alone, whose poles are known roughly from a first look. How large each decay is follows by least
squares from how the blocks differ; then it is taken off.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from modallab.core.arrays import Complex128, Real
from modallab.frf.joined import contiguous_blocks
from modallab.signals.signals import Signals


def without_decays(signals: Sequence[Signals], poles: Complex128, band_hz: tuple[float, float]) -> list[Signals]:
    """The blocks without the free decays of these poles, as far as the blocks of each wave differ by them.

    Args:
        signals: of one periodic drive, equal in rate and length.
        poles: (modes,) rad/s, with positive imaginary part.
        band_hz: lines by which the decays' sizes are found.
    """
    found: list[Signals] = []
    for run in contiguous_blocks(signals):
        found += _settle_run(run, poles, band_hz) if len(run) > 1 else list(run)
    return found


def _settle_run(run: Sequence[Signals], poles: Complex128, band_hz: tuple[float, float]) -> list[Signals]:
    n, rate, inputs = run[0].n_samples, run[0].rate_hz, len(run[0].forces)
    rows = np.stack([np.vstack([s.forces, s.responses]) for s in run])
    decays = _decays_of_poles(poles, len(run), n, rate)
    first, last = (round(edge * n / rate) for edge in band_hz)
    chosen = np.arange(max(1, first), min(n // 2, last) + 1)
    spectra = np.fft.rfft(rows)[..., chosen]
    # (blocks, 2 modes, lines): of the real and the imaginary part of each state.
    basis = np.fft.rfft(decays)[..., chosen]
    size = _sizes_of_decays(spectra - spectra.mean(axis=0), basis - basis.mean(axis=0))
    left = rows - np.einsum("bmn,mo->bon", decays, size)
    return [replace(s, forces=r[:inputs], responses=r[inputs:]) for s, r in zip(run, left, strict=True)]


def _decays_of_poles(poles: Complex128, blocks: int, n: int, rate_hz: float) -> Real:
    """(blocks, 2 modes, samples) real decays: of a state's real part, then of its imaginary part."""
    time = np.arange(blocks * n) / rate_hz
    decay: Complex128 = np.exp(np.outer(poles, time)).reshape(poles.size, blocks, n).transpose(1, 0, 2)
    return np.concatenate([decay.real, -decay.imag], axis=1)


def _sizes_of_decays(differences: Complex128, basis: Complex128) -> Real:
    """(2 modes, rows) by least squares over all blocks and lines."""

    def flat(values: Complex128) -> Real:
        turned = values.transpose(0, 2, 1).reshape(-1, values.shape[1])
        return np.concatenate([turned.real, turned.imag])

    return np.asarray(np.linalg.lstsq(flat(basis), flat(differences), rcond=None)[0], np.float64)
