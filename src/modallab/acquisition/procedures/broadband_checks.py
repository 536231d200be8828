"""What rig and bench do not allow of a broadband test: each of its waves is looked at before anything moves."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from modallab.acquisition.procedures.broadband_wave import (
    blocks_of_wave,
    blocks_per_wave,
    is_periodic,
    make_waves,
    peak_v,
    slew_v_per_s,
    wave_layout,
)
from modallab.bench.capabilities import DrivesSeveralShakers, PlaysWaves
from modallab.bench.protocol import Waveform
from modallab.core.arrays import Complex128, Real
from modallab.core.errors import SafetyError, UnsupportedError
from modallab.core.plan import BroadbandPlan
from modallab.core.rig import Limits, Rig
from modallab.signals.conversion import Conversion
from modallab.storage.samples import Samples


def driven_points(plan: BroadbandPlan, rig: Rig) -> tuple[int, ...]:
    """Where the shakers stand that a plan drives, in the order of `Rig.forces`."""
    return rig.shaker_points if plan.shakers == "all" else rig.shaker_points[:1]


def longest_wave_s(plan: BroadbandPlan, rig: Rig) -> float:
    """How long the longest wave of a plan lasts, from 0 V to 0 V."""
    fitting = blocks_per_wave(plan, inf if rig.limits is None else rig.limits.max_burst_s)
    return wave_layout(plan, _blocks_of_each_wave(plan, fitting, len(driven_points(plan, rig)))[0], plan.block_s).end_s


def wave_problems(plan: BroadbandPlan, limits: Limits, shakers: int) -> list[str]:
    """What does not go together in a plan for so many shakers, and what the rig's limits do not allow of its waves."""
    fitting = blocks_per_wave(plan, limits.max_burst_s)
    least = 2 if shakers > 1 and is_periodic(plan) else 1
    problems = _too_few(plan, shakers)
    if not problems and fitting < least:
        lasts_s = wave_layout(plan, least, plan.block_s).end_s
        problems = [
            f"a wave of {_blocks_in_words(least)} lasts {lasts_s:.4g} s; allowed by the rig: {limits.max_burst_s:g} s"
        ]
    if problems:
        return problems
    sizes = _blocks_of_each_wave(plan, fitting, shakers)
    layouts = [wave_layout(plan, size, plan.block_s) for size in sizes]
    for level in plan.levels_v:
        played = [make_waves(plan, level, number, layout, shakers) for number, layout in enumerate(layouts)]
        # One shaker's are named by their level alone, as there is no other.
        for shaker, waves in enumerate(zip(*played, strict=True)):
            which = f", shaker {shaker + 1}" if shakers > 1 else ""
            problems += over_limits(f"levels_v: {level}{which}", waves, limits)
    return problems


def _blocks_of_each_wave(plan: BroadbandPlan, most: int, shakers: int) -> list[int]:
    """Blocks of each wave of a level."""
    sizes: list[int] = []
    while most and sum(sizes) < plan.blocks:
        sizes.append(blocks_of_wave(plan, len(sizes), plan.blocks - sum(sizes), most, shakers))
    return sizes or [0]


def _blocks_in_words(count: int) -> str:
    return "one block" if count == 1 else f"{count} blocks"


def over_limits(what: str, waves: Sequence[Waveform], limits: Limits) -> list[str]:
    """What the rig's limits do not allow of some waves, with the number."""
    peak, slew = max(map(peak_v, waves)), max(map(slew_v_per_s, waves))
    found = [
        (f"{what} has a peak of {peak:.4g} V; allowed by the rig: {limits.drive_v:g} V", peak > limits.drive_v),
        (f"{what} slews {slew:.4g} V/s; allowed by the rig: {limits.slew_v_per_s:g} V/s", slew > limits.slew_v_per_s),
    ]
    return [text for text, over in found if over]


def _too_few(plan: BroadbandPlan, shakers: int) -> list[str]:
    """What keeps the forces of several shakers from being distinguished."""
    if shakers < 2:
        return []
    problems: list[str] = []
    if plan.detection_lines:
        problems.append(
            "detection_lines: a line that is left out shows nothing with several shakers; allowed: with one shaker"
        )
    # A periodic wave shows by its second block that it is one, and what is noise.
    least = 2 * shakers if is_periodic(plan) else shakers + 1
    if plan.blocks < least:
        each = f", two in each of {shakers} waves" if is_periodic(plan) else ""
        problems.append(
            f"blocks: {plan.blocks} cannot separate {shakers} shakers and the noise; allowed: {least} or more{each}"
        )
    if is_periodic(plan) and plan.blocks_per_wave == 1:
        problems.append("blocks_per_wave: 1 of a periodic drive shows no noise; allowed: 2 or more for several shakers")
    return problems


def require_waves(plan: BroadbandPlan, bench: object, rig: Rig) -> None:
    """Reject a bench that cannot play the waves of a plan, before anything moves.

    Raises:
        UnsupportedError: it cannot.
    """
    generator = rig.excitation is not None and rig.excitation.kind == "generator"
    if generator or not isinstance(bench, PlaysWaves):
        raise UnsupportedError(
            f"{'a sine generator' if generator else 'this bench'} plays no {plan.signal} drive",
            where="broadband plan",
            remedy="drive by an analog output of the device, or run a sine test",
        )
    shakers = len(driven_points(plan, rig))
    if shakers > 1 and not isinstance(bench, DrivesSeveralShakers):
        raise UnsupportedError(
            f"this bench drives one shaker, and the plan drives {shakers} at once",
            where="broadband plan",
            remedy="leave out shakers: all, or use a device with an output for each",
        )


SEEN = 3.0
"""A force is one if it is so many times what its channel shows at rest."""
_TOGETHER = 9
"""Lines over which a force and its drive are one factor: whatever a converter delays turns them by little."""

_MUCH_MORE = 2.0
"""Times its own drive's coherence. Drives without relation have 1 / _TOGETHER, bursts, whose lines go together, 0.4."""


@dataclass(frozen=True, slots=True)
class DrivenForces:
    """The force channels of some shakers.

    Attributes:
        conversion: of the samples.
        count: shakers that drive, the first ones of the rig.
    """

    conversion: Conversion
    count: int

    def rms(self, samples: Samples) -> Real:
        """(driven,) in N, of (channels, n) as delivered."""
        return np.std(self._of(samples), axis=1)

    def require_forces(self, samples: Samples, rest_n: Real, drive_v: float) -> None:
        """Reject a block in which a force is not above what its channel shows at rest.

        Args:
            samples: (channels, n) as delivered.
            rest_n: (driven,) rms at rest.
            drive_v: rms of the drive.

        Raises:
            SafetyError: names the channel.
        """
        for name, force_n, before_n in zip(self._names, self.rms(samples), rest_n, strict=True):
            if force_n <= SEEN * before_n:
                raise SafetyError(
                    f"the force of {name} is {force_n:.3g} N rms while {drive_v:g} V rms drive, and {before_n:.3g} N at"
                    " rest; the output was brought to 0 V",
                    remedy="check the force sensor, the amplifier and the stinger, or drive harder",
                )

    def require_own_drive(self, samples: Samples, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> None:
        """Reject a block in which forces follow each other's drives.

        A weak shaker may feel the others more than its own drive; but where each follows one of its own, and not its
        own, plugs are exchanged.

        Args:
            samples: (channels, n) as delivered.
            waves: what each shaker plays.
            first_s: of the samples, since the waves began.
            rate_hz: sampling rate.

        Raises:
            SafetyError: names the channel and whose drive it follows.
        """
        if self.count < 2:
            return
        found = match_forces_to_drives(self._of(samples), waves, first_s, rate_hz)
        wrong = [(name, other) for n, (name, other) in enumerate(zip(self._names, found, strict=True)) if other != n]
        if wrong and sorted(found) == list(range(self.count)):
            listed = ", ".join(f"{name} follows the drive of {self._names[other]}'s shaker" for name, other in wrong)
            raise SafetyError(
                f"{listed}; the output was brought to 0 V",
                remedy="exchange the plugs of the force sensors or of the amplifiers, or correct the rig file",
            )

    @property
    def _names(self) -> list[str]:
        return [self.conversion.names[channel] for channel in self.conversion.forces[: self.count]]

    def _of(self, samples: Samples) -> Real:
        return self.conversion.forces_n(samples)[: self.count]


def match_forces_to_drives(forces: Real, waves: Sequence[Waveform], first_s: float, rate_hz: float) -> list[int]:
    """Which of the drives each force follows: its own, unless it follows another much more.

    Chirps are alike in one wave, whichever shaker plays them: of these each force follows its own.

    Args:
        forces: (shakers, n) in N, in the order of the waves.
        waves: what each shaker plays.
        first_s: of the samples, since the waves began.
        rate_hz: sampling rate.
    """
    window = np.hanning(forces.shape[1])
    times = first_s + np.arange(forces.shape[1]) / rate_hz
    drives = np.stack([wave.at(times) for wave in waves])
    f, d = (np.fft.rfft((rows - rows.mean(axis=1, keepdims=True)) * window) for rows in (forces, drives))
    driven = np.flatnonzero(np.sum(np.abs(d) ** 2, axis=0) > 0.01 * np.max(np.sum(np.abs(d) ** 2, axis=0)))
    alike = _coherence(f[:, driven], d[:, driven])
    most = alike.argmax(axis=1)
    own = np.diagonal(alike)
    clear = alike.max(axis=1) > _MUCH_MORE * own
    return [int(other) if sure else n for n, (other, sure) in enumerate(zip(most, clear, strict=True))]


def _coherence(forces: Complex128, drives: Complex128) -> Real:
    """(forces, drives) mean over the lines of what each drive explains of each force in _TOGETHER lines."""
    count = forces.shape[1] // _TOGETHER
    f, d = (rows[:, : count * _TOGETHER].reshape(len(rows), count, _TOGETHER) for rows in (forces, drives))
    cross = np.abs(np.einsum("fct,dct->fdc", f, d.conj())) ** 2
    powers = np.sum(np.abs(f) ** 2, axis=2)[:, None] * np.sum(np.abs(d) ** 2, axis=2)[None]
    return np.mean(cross / np.maximum(powers, np.finfo(float).tiny), axis=2)
