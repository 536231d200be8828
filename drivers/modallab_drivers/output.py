"""What drives the shaker, as a bench sees it: an analog output or a generator."""

from collections.abc import Sequence
from math import isfinite, pi
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import Burst, Waveform
from modallab.core.errors import ConfigurationError, UnsupportedError
from modallab.core.rig import Limits, Rig


class Output(Protocol):
    """An excitation output. All times are counts of the bench's own samples."""

    @property
    def range_v(self) -> float:
        """The largest amplitude it can give."""
        ...

    @property
    def busy(self) -> bool:
        """Whether a burst is on."""
        ...

    def play(self, burst: Burst, now: int, rate_hz: float) -> None:
        """Start a burst now, at sample `now` of a bench at `rate_hz`."""
        ...

    def next_event(self) -> int | None:
        """The sample at which it must be looked after next, if there is one."""
        ...

    def tick(self, now: int) -> None:
        """Look after the burst that is on.

        Raises:
            OutputLostError: the device could not keep it going.
        """
        ...

    def zero(self) -> None:
        """Bring it to 0 V now."""
        ...

    def close(self) -> None:
        """Bring it to 0 V and let go of it."""
        ...


def require(state: str, *legal: str, to: str, where: str) -> None:
    """Reject a call out of order.

    Raises:
        ConfigurationError: the bench is in none of the legal states.
    """
    if state not in legal:
        raise ConfigurationError(
            f"the bench is {state}: cannot {to}",
            where=where,
            remedy="the order is configure, start, then read and play; stop before another configure",
        )


def require_count(count: int, where: str) -> None:
    """Reject a read of nothing.

    Raises:
        ConfigurationError: `count` is below 1.
    """
    if count < 1:
        raise ConfigurationError(f"a read of {count} samples", where=where, remedy="read 1 or more")


def require_burst(burst: Burst, rate_hz: float, range_v: float, limits: Limits | None, where: str) -> None:
    """Reject a burst the output or the rig's limits do not allow.

    Raises:
        ConfigurationError: names every field that is wrong, and the field of the rig file where it is a limit.
    """
    problems: list[str] = []
    if not 0 < burst.frequency_hz < rate_hz / 2:
        problems.append(f"frequency_hz = {burst.frequency_hz}; allowed: above 0 to half the rate")
    if not 0 < burst.amplitude_v <= range_v:
        problems.append(f"amplitude_v = {burst.amplitude_v}; allowed: above 0 to the output's {range_v:g} V")
    times = (burst.ramp_s, burst.hold_s)
    if not all(isfinite(t) and t >= 0 for t in times) or burst.duration_s == 0:
        problems.append(f"ramp_s = {burst.ramp_s}, hold_s = {burst.hold_s}; allowed: from 0, not both 0")
    elif limits is not None:
        problems += _over_limits(burst, limits)
    if problems:
        raise ConfigurationError("; ".join(problems), where=where, remedy="change the plan or the rig file's limits")


def _over_limits(burst: Burst, limits: Limits) -> list[str]:
    slew = 2 * pi * burst.frequency_hz * burst.amplitude_v
    found = [
        ("limits.drive_v", burst.amplitude_v, limits.drive_v, "V"),
        ("limits.slew_v_per_s", slew, limits.slew_v_per_s, "V/s"),
        ("limits.max_burst_s", burst.duration_s, limits.max_burst_s, "s"),
    ]
    return [f"{n}: {v:.4g} {u}; allowed: {most:g} {u}" for n, v, most, u in found if v > most * (1 + 1e-9)]


def burst_volts(burst: Burst, times_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """The burst in V at times since its start: a sine under a cosine taper, exactly 0 from its end on."""
    wave = burst.amplitude_v * np.sin(2 * np.pi * burst.frequency_hz * times_s)
    if burst.ramp_s > 0:
        edge = np.clip(np.minimum(times_s, burst.duration_s - times_s) / burst.ramp_s, 0, 1)
        wave *= (1 - np.cos(np.pi * edge)) / 2
    wave[times_s >= burst.duration_s] = 0.0
    return wave


def burst_samples(burst: Burst, rate_hz: float) -> NDArray[np.float64]:
    """The burst as (n,) volts at an output's rate, its first and last sample exactly 0."""
    count = int(np.ceil(burst.duration_s * rate_hz)) + 1
    wave = burst_volts(burst, np.arange(count) / rate_hz)
    wave[-1] = 0.0
    return wave


def require_wave(wave: Waveform, range_v: float, limits: Limits | None, where: str) -> None:
    """Reject a wave the output or the rig's limits do not allow, or that does not begin and end at 0 V.

    Raises:
        ConfigurationError: names every field that is wrong, and the field of the rig file where it is a limit.
    """
    samples = wave.samples
    if samples.ndim != 1 or len(samples) < 2 or not np.isfinite(samples).all() or samples[0] != 0 or samples[-1] != 0:
        raise ConfigurationError(
            f"a wave of {samples.shape} samples that are not all finite, or not 0 V at both ends",
            where=where,
            remedy="let it begin and end at 0 V",
        )
    peak = float(np.abs(samples).max())
    found = [("the output's range", peak, range_v, "V")]
    if limits is not None:
        slew = float(np.abs(np.diff(samples)).max() * wave.rate_hz)
        found += [
            ("limits.drive_v", peak, limits.drive_v, "V"),
            ("limits.slew_v_per_s", slew, limits.slew_v_per_s, "V/s"),
            ("limits.max_burst_s", wave.duration_s, limits.max_burst_s, "s"),
        ]
    over = [f"{n}: {v:.4g} {u}; allowed: {most:g} {u}" for n, v, most, u in found if v > most * (1 + 1e-9)]
    if over:
        raise ConfigurationError("; ".join(over), where=where, remedy="change the plan or the rig file's limits")


def require_alike(waves: Sequence[Waveform], where: str) -> None:
    """Reject waves that cannot go out of outputs of one clock together.

    Raises:
        ConfigurationError: none, or of several rates or lengths.
    """
    kinds = sorted({(wave.rate_hz, len(wave.samples)) for wave in waves})
    if len(kinds) != 1:
        listed = ", ".join(f"{count} samples at {rate_hz:g} Hz" for rate_hz, count in kinds) or "none"
        raise ConfigurationError(
            f"waves of {listed}", where=where, remedy="give waves of one rate and one length, one for each shaker"
        )


def wave_samples(wave: Waveform, rate_hz: float) -> NDArray[np.float64]:
    """The wave as (n,) volts at an output's rate, its first and last sample exactly 0."""
    count = int(np.ceil(wave.duration_s * rate_hz)) + 1
    samples = wave.at(np.arange(count) / rate_hz)
    samples[0] = samples[-1] = 0.0
    return samples


class NoOutput:
    """What a bench answers that has no output."""

    _state: str
    _rig: Rig
    _url: str
    _no_output: tuple[str, str] = "the device has no output", "use a bench with an output"

    def play(self, burst: Burst) -> int:
        """Always rejected."""
        self._require("running", to="play")
        what, remedy = self._no_output
        found = f"{what}; a burst of {burst.frequency_hz:g} Hz was asked for"
        raise UnsupportedError(found, where=self._url, remedy=remedy)

    def prompt_hit(self, point: int) -> None:
        """Whoever strikes is notified by the page, or has struck; the point must be one of the rig."""
        self._rig.x_of(point)

    def zero(self) -> None:
        """Nothing to do."""

    def _require(self, *legal: str, to: str) -> None:
        require(self._state, *legal, to=to, where=self._url)
