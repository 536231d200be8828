"""The hits that are still requested, and whether one counts: every reason it does not, each with its number."""

from collections import deque
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.monitor.context import RunContext
from modallab.acquisition.monitor.run_states import AcceptBlock, DropBlock
from modallab.acquisition.monitor.settled import (
    NoiseFloor,
    WindowLevels,
    amplitude_of_motion,
    largest_ratio,
    lines_above_noise,
    mean_sensor_motion,
)
from modallab.acquisition.procedures.target import HitTarget
from modallab.core.arrays import Real
from modallab.core.plan import HitAcceptance, ImpactPlan


@dataclass(slots=True)
class HitQueue:
    """What an impact test still has to do.

    Attributes:
        total: hits that the plan wants.
        todo: hits that are still requested; the first is the present one.
        kept: good hits by the name of their record.
        rejected: hits that did not count, or count no more, by the name of their record.
    """

    total: int
    todo: deque[HitTarget]
    kept: dict[str, HitTarget] = field(default_factory=dict[str, HitTarget])
    rejected: dict[str, HitTarget] = field(default_factory=dict[str, HitTarget])

    @classmethod
    def of(cls, plan: ImpactPlan) -> Self:
        """Everything is still to do."""
        todo = deque(HitTarget(point, hit) for point in plan.points for hit in range(1, plan.hits + 1))
        return cls(len(todo), todo)

    @property
    def current_hit(self) -> HitTarget:
        """The hit that is requested now."""
        return self.todo[0]

    def next_name(self) -> str:
        """Name of the present hit's record, should it be rejected."""
        rejected = f"{self.current_hit.name}_rejected_"
        return f"{rejected}{1 + sum(n.startswith(rejected) for n in self.rejected)}"

    def keep_hit(self) -> None:
        """The present hit counts."""
        target = self.todo.popleft()
        self.kept[target.name] = target

    def reject_hit(self, name: str) -> None:
        """The present hit was recorded under this name and does not count."""
        self.rejected[name] = self.current_hit

    def drop_hit(self, context: RunContext, request: DropBlock) -> bool:
        """A hit counts no longer and is asked for again, at once; whether it did count."""
        if not context.drop_block(request.block, request.reason):
            return False
        target = self.kept.pop(request.block, None)
        if target is not None:
            again = replace(target, repetition=target.repetition + 1)
            self.todo.appendleft(again)
            # Until it is struck again, what was dropped can be taken back.
            self.rejected[request.block] = again
        return True

    def accept_hit(self, context: RunContext, request: AcceptBlock) -> HitTarget | None:
        """A hit that was rejected or dropped counts and is not asked for again; the hit it was, None if there is none.

        A hit that has been kept since under the same target stays the one that counts.
        """
        target = self.rejected.get(request.block)
        if target is None or target not in self.todo:
            return None
        if not context.accept_block(request.block, request.reason, request.operator):
            return None
        self.todo.remove(target)
        self.kept[request.block] = target
        return target


MERGE_S = 0.002
"""Pulses closer than this count as one: their first spectral gap, at 250 Hz, is above the paper's band.

A second contact is looked for in the mean over as long, in which the ripple of an anti-alias filter after a short pulse
cancels and a contact does not."""

CONTACT_LEVEL = 0.05
"""The hammer touches the beam while the force is above this part of its peak."""


@dataclass(frozen=True, slots=True)
class MeasuredHit:
    """The hit in a block, in numbers.

    Attributes:
        peak_n: largest force.
        contact_s: duration of the first contact.
        second_ratio: largest force after the first contact, as part of the first's, both as means over `MERGE_S`.
        drop_db: how far the force spectrum falls below its maximum within the band.
    """

    peak_n: float
    contact_s: float
    second_ratio: float
    drop_db: float


def hit_of(force_n: Real, rate_hz: float, before: int, band_hz: float) -> MeasuredHit:
    """Measure the hit in a block's (n,) force, whose trigger is at index `before`.

    Bad and good hits alike; the mean of the force before the trigger counts as zero.
    """
    force = force_n - force_n[: max(1, before - 1)].mean()
    peak = float(force.max())
    merge = max(1, round(MERGE_S * rate_hz))
    start, end = _contact_samples(force, before, CONTACT_LEVEL * peak, merge)
    mean = np.convolve(force, np.full(merge, 1 / merge), mode="same")
    # The mean still holds the contact for half its length after its end.
    rest = mean[end + merge // 2 + 1 :]
    return MeasuredHit(
        peak_n=peak,
        contact_s=(end - start) / rate_hz,
        second_ratio=max(0.0, float(rest.max() / mean[start:end].max())) if rest.size else 0.0,
        drop_db=_drop_db(force[max(0, start - 2) : end + 2], rate_hz, band_hz),
    )


def rejection_reasons(hit: MeasuredHit, limits: HitAcceptance) -> list[str]:
    """Why this hit does not count; empty if it does."""
    found: list[str] = []
    if hit.peak_n < limits.min_force_n:
        found.append(f"too weak: {hit.peak_n:.3g} N, at least {limits.min_force_n:g} N")
    if hit.peak_n > limits.max_force_n:
        found.append(f"too strong: {hit.peak_n:.3g} N, at most {limits.max_force_n:g} N")
    if hit.contact_s > limits.max_contact_s:
        found.append(f"contact too long: {1e3 * hit.contact_s:.3g} ms, at most {1e3 * limits.max_contact_s:g} ms")
    if hit.second_ratio > limits.double_hit_ratio:
        found.append(
            f"double hit: a second pulse of {100 * hit.second_ratio:.3g} %, at most {100 * limits.double_hit_ratio:g} %"
        )
    if hit.drop_db > limits.band_drop_db:
        found.append(
            f"force spectrum too narrow: down {hit.drop_db:.3g} dB within {limits.min_band_hz:g} Hz,"
            f" at most {limits.band_drop_db:g} dB"
        )
    return found


def _contact_samples(force: Real, trigger: int, threshold: float, merge: int) -> tuple[int, int]:
    touching = np.flatnonzero(force > threshold)
    # The trigger may stand below the threshold of a strong hit, so the contact is the first stretch at or after it.
    first = int(np.searchsorted(touching, trigger))
    touching = touching[min(first, touching.size - 1) :]
    gaps = np.flatnonzero(np.diff(touching) > merge)
    last = touching[gaps[0]] if gaps.size else touching[-1]
    return int(min(touching[0], trigger)), int(last) + 1


def _drop_db(pulse: Real, rate_hz: float, band_hz: float) -> float:
    # Zero-padded so finely that no gap of the spectrum falls between two lines.
    lines = np.fft.rfftfreq(_FINE, 1 / rate_hz) <= band_hz
    spectrum = np.abs(np.fft.rfft(pulse, _FINE))[lines]
    return float(20 * np.log10(spectrum.max() / max(spectrum.min(), 1e-12 * spectrum.max())))


_FINE = 4096


@dataclass(frozen=True, slots=True)
class RingingBeforeHit:
    """The motion before a hit.

    Attributes:
        residual_ratio: its amplitude as part of the hit's own, where that is largest; 0 if it does not show.
        residual_hz: where that is.
    """

    residual_ratio: float
    residual_hz: float

    def rejection_reasons(self, allowed: float) -> list[str]:
        """Why the hit does not count, if more than the part `allowed` of it rang before."""
        if self.residual_ratio <= allowed:
            return []
        return [
            f"not at rest before: {100 * self.residual_ratio:.3g} % of this hit at {self.residual_hz:.4g} Hz,"
            f" at most {100 * allowed:g} %"
        ]


@dataclass(frozen=True, eq=False, slots=True)
class MotionBeforeHit:
    """The motion before a hit, looked at as soon as it is over and not only when the whole block has come.

    Attributes:
        moves: (peaks,) amplitudes, in noise rms, of what rang.
        lines: (peaks,) where.
    """

    moves: Real
    lines: NDArray[np.int64]

    @classmethod
    def of(cls, context: RunContext, first: int, floor: NoiseFloor) -> Self:
        """In the window that ends at sample `first`."""
        look = WindowLevels.of(context.motion_samples(first - context.rest_window, context.rest_window), floor.rms)
        return cls(*lines_above_noise(look, floor))

    def relative_to_block(self, context: RunContext, first: int, floor: NoiseFloor) -> RingingBeforeHit:
        """As part of what moves in the block from sample `first`."""
        if self.lines.size == 0:
            return RingingBeforeHit(0.0, 0.0)
        beside = np.concatenate([self.lines - 1, self.lines, self.lines + 1])
        own = mean_sensor_motion(
            amplitude_of_motion(context.motion_samples(first, context.block), context.rest_window, beside, floor)
        )
        ratio, line = largest_ratio(self.moves, self.lines, own.reshape(3, -1))
        return RingingBeforeHit(ratio, line * context.line_hz)
