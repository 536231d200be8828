"""The blocks of an impact test at their lines, with what is unknown of each hit."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from modallab.core.frf import DERIVATIVES
from modallab.core.rig import Rig
from modallab.frf.estimate import lines_of_band, output_quantity, pre_trigger_level
from modallab.identification.likelihood.basis import LineBlock
from modallab.identification.likelihood.excitation import BlockLines, HitExcitation
from modallab.signals.hit import HitSamples, windowed_force
from modallab.signals.signals import Signals

MOST_FORCE_SAMPLES = 1500
"""More unknown force samples than these, over all blocks, take too long."""

TAILS = (30, 10)
"""Samples on each side: a filter's ringing lasts as many, however long the hit."""

Groups = Sequence[Sequence[Signals]]


@dataclass(frozen=True, eq=False, slots=True)
class HitBlocks:
    """The blocks at their lines, and what each may have to itself.

    Attributes:
        blocks: in the order of the groups.
        grid: of them all.
        impulse: (blocks,) N s of each hit.
        state_sigma: (blocks,) prior of every modal state, N s; None if the beam looked at rest before every hit.
        force_sigma: (blocks, width) prior of the force samples' errors, N; None if states at the hit stand for them.
    """

    blocks: list[LineBlock]
    grid: BlockLines
    impulse: NDArray[np.float64]
    state_sigma: NDArray[np.float64] | None
    force_sigma: NDArray[np.float64] | None

    @property
    def at_rest(self) -> bool:
        """Whether the blocks' beginnings have hardly any motion, and their states are therefore known to be small."""
        return self.state_sigma is None


def line_blocks(groups: Groups, rig: Rig, band: tuple[float, float]) -> tuple[HitBlocks, tuple[str, ...]]:
    """The blocks at their lines with what is unknown of each, and notes.

    The force channel's own noise within the hit is estimated sample by sample. If the beam was not at rest before a
    hit, every mode has an unknown state at the block's start. Where the hits are too long for an unknown a sample,
    the states enter at the hit instead and stand for its noise.
    """
    first = groups[0][0]
    n, rate = first.force.size, first.rate_hz
    chosen = lines_of_band(n, rate, band)
    grid = BlockLines(2 * np.pi * chosen * rate / n, n, 1 / rate, DERIVATIVES[output_quantity(rig)])
    flat = [s for group in groups for s in group]
    of_block = [index for index, group in enumerate(groups) for _ in group]
    ringing = [s.block.name for s in flat if moves_before(s)]
    found = [s.hit for s in flat]
    wide = _with_tails(found, n)
    by_sample = wide is not None
    found = found if wide is None else wide
    blocks: list[LineBlock] = []
    for signals, hit, group in zip(flat, found, of_block, strict=True):
        response = np.fft.rfft(signals.responses - pre_trigger_level(signals)[:, None])[:, chosen]
        start = 0 if ringing or by_sample else hit.peak
        force = windowed_force(signals.force, hit)
        blocks.append(LineBlock(HitExcitation(grid, force, start, hit.first), response, group))
    impulse = np.array([np.sum(np.abs(windowed_force(s.force, b))) for s, b in zip(flat, found, strict=True)]) / rate
    force_sigma = _force_sigma(flat, found, _force_width(found, n)) if by_sample else None
    state_sigma = impulse if ringing else None if by_sample else _hit_noise(found, impulse, rate)
    return HitBlocks(blocks, grid, impulse, state_sigma, force_sigma), _ringing_notes(ringing)


def _with_tails(hits: Sequence[HitSamples], n: int) -> list[HitSamples] | None:
    """The hits with tails, shorter ones if that is too much; None if that is too.

    A converter's steep filter rings on, as high as its edge, below the noise of one sample. Cut off, that is some
    tenths of a per cent of the force where the hit's own spectrum is weak.
    """
    for more in TAILS:
        wide = [replace(b, first=max(0, b.first - more), stop=min(n, b.stop + more)) for b in hits]
        if _force_width(wide, n) * len(wide) <= MOST_FORCE_SAMPLES:
            return wide
    return None


def _force_width(hits: Sequence[HitSamples], n: int) -> int:
    return min(max(b.stop - b.first for b in hits), n - max(b.first for b in hits))


def _force_sigma(signals: Sequence[Signals], hits: Sequence[HitSamples], width: int) -> NDArray[np.float64]:
    noise = [max(b.noise, 1e-9 * float(np.max(np.abs(s.force)))) for s, b in zip(signals, hits, strict=True)]
    return np.repeat(np.array(noise)[:, None], width, axis=1)


def _hit_noise(hits: Sequence[HitSamples], impulse: NDArray[np.float64], rate_hz: float) -> NDArray[np.float64]:
    """(blocks,) sigma in N s of what the force channel's noise adds to each hit."""
    noise = np.array([b.noise * np.sqrt((b.stop - b.first) / 2) for b in hits]) / rate_hz
    return np.maximum(noise, 1e-9 * impulse)


def _ringing_notes(ringing: Sequence[str]) -> tuple[str, ...]:
    if not ringing:
        return ()
    shown = ", ".join(ringing[:4]) + (" and others" if len(ringing) > 4 else "")
    return (
        f"The beam was still moving before the hit in {shown}; the motion at each block's start was estimated too.",
    )


def moves_before(signals: Signals) -> bool:
    """Whether the outputs move before the hit: their neighbouring samples are correlated, as those of noise are not."""
    stop = signals.hit.first
    if stop < 32:
        return False
    before = signals.responses[:, :stop] - signals.responses[:, :stop].mean(axis=1, keepdims=True)
    # White noise has no memory; a mode that rings correlates neighbouring samples.
    power = np.sum(before**2, axis=1)
    memory = np.sum(before[:, 1:] * before[:, :-1], axis=1)
    return bool(np.median(memory / np.maximum(power, np.finfo(float).tiny)) > 0.5)
