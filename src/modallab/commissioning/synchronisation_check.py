"""Whether several devices sample as one: what they say themselves, and the phase between two channels of one signal.

A delay between two devices turns the phase of every FRF between their channels by 360 degrees times delay and
frequency: 0.1 degrees at 10 kHz are 28 ns. It shows only in a signal that both devices read, such as a drive's monitor
on a tee.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.bench.capabilities import SynchronisedBench
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst
from modallab.commissioning.rig_check import CheckResult, Verdict, read_seconds
from modallab.core.errors import PlanError
from modallab.core.rig import Rig

LIMIT_DEGREES = 0.1
AT_HZ = 10_000.0
"""The phase is stated at this frequency, whichever the signal had."""

RATE_HZ = 51_200.0
SLOW_HZ = 2000.0
LISTEN_S = 2.0
SEGMENTS = 8
COUNT_S = 0.25
"""Sample counts are asked one after the other, and devices hand on samples in packets."""

TONE_HZ, TONE_PART = 1000.0, 0.02
"""A sine that repeats so slowly that a start some samples late is not taken for one in time."""

LEAST_COHERENCE = 0.9
PEAK = 0.99
RAMP_S = 0.1


@dataclass(frozen=True, slots=True)
class ChannelDelay:
    """By how much one channel lags another."""

    seconds: float
    sigma_s: float

    def degrees(self, value_s: float) -> float:
        """As phase at AT_HZ."""
        return 360 * AT_HZ * value_s


def check_synchronisation(bench: Bench) -> list[CheckResult]:
    """What the devices say: how they are synchronised, whether their clocks are locked, how far they have counted."""
    if not isinstance(bench, SynchronisedBench):
        return []
    bench.configure(AcquisitionRequest("impact", SLOW_HZ))
    if not bench.synchronisation().method:
        return []
    bench.start()
    try:
        read_seconds(bench, SLOW_HZ, LISTEN_S)
        state = bench.synchronisation()
    finally:
        bench.stop()
    spread = (max(state.acquired.values()) - min(state.acquired.values())) / SLOW_HZ
    locked = f"not locked: {', '.join(state.unlocked)}" if state.unlocked else "all are locked, or do not report"
    counts = ", ".join(f"{device} {count}" for device, count in state.acquired.items())
    return [
        CheckResult("devices", "synchronisation", state.method, "good"),
        CheckResult("devices", "reference clock", locked, "bad" if state.unlocked else "good"),
        CheckResult("devices", "sample counts", counts, "good" if spread <= COUNT_S else "bad"),
    ]


def check_common_signal(bench: Bench, rig: Rig, names: tuple[str, str], volts: float | None = None) -> CheckResult:
    """The phase between two channels that read one signal, stated at 10 kHz.

    Args:
        bench: open, not started.
        rig: as believed.
        names: of the two channels.
        volts: of a burst the bench plays; None: whatever signal is there.

    Raises:
        PlanError: no such channel.
    """
    rows = [_row_of_channel(rig, name) for name in names]
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    try:
        if volts is not None:
            bench.play(Burst(min(TONE_HZ, TONE_PART * delivery.rate_hz), volts, RAMP_S, LISTEN_S + 1.0))
            read_seconds(bench, delivery.rate_hz, 0.5)
        both = read_seconds(bench, delivery.rate_hz, LISTEN_S)[0][rows]
    finally:
        bench.zero()
        bench.stop()
    between = f"{names[1]} after {names[0]}"
    delay = delay_between(both[0], both[1], delivery.rate_hz)
    if delay is None:
        return CheckResult(between, "phase", "no signal common to both", "look")
    phase, sigma = delay.degrees(delay.seconds), delay.degrees(delay.sigma_s)
    value = f"{phase:+.3f} +- {sigma:.2g} degrees at {AT_HZ:g} Hz ({1e9 * delay.seconds:+.3g} ns)"
    sure: Verdict = "bad" if abs(phase) - 2 * sigma > LIMIT_DEGREES else "look"
    return CheckResult(between, "phase", value, "good" if abs(phase) + 2 * sigma <= LIMIT_DEGREES else sure)


def delay_between(one: NDArray[np.float64], other: NDArray[np.float64], rate_hz: float) -> ChannelDelay | None:
    """By how much the (n,) samples `other` lag `one`, by their cross-spectrum; None where they share no signal.

    Lines count by their coherence; the variance of the phase of a line is (1 - c) / (2 c m) for coherence c over m
    segments (Bendat and Piersol, Random Data, section 9.2). Whole samples are found first, in the correlation. The
    lines beside a sine carry its phase too, so that its delay is known to a thousandth of itself at best.
    """
    whole = _whole_samples(one, other)
    one, other = (one[: len(one) - whole], other[whole:]) if whole >= 0 else (one[-whole:], other[: len(other) + whole])
    length = min(len(one), len(other)) // SEGMENTS
    window = np.hanning(length)
    spectra = [
        np.fft.rfft((x[: SEGMENTS * length].reshape(SEGMENTS, length) - x.mean()) * window, axis=1)
        for x in (one, other)
    ]
    powers = [np.mean(np.abs(s) ** 2, axis=0) for s in spectra]
    cross = np.mean(spectra[0] * spectra[1].conj(), axis=0)
    coherence = np.minimum(np.abs(cross) ** 2 / np.maximum(powers[0] * powers[1], 1e-300), 1 - 1e-12)
    used = (coherence >= LEAST_COHERENCE) & (powers[0] > 1e-6 * powers[0][1:].max())
    used[:2] = False
    if not used.any():
        return None
    omega = 2 * np.pi * np.fft.rfftfreq(length, 1 / rate_hz)[used]
    weight = 2 * SEGMENTS * coherence[used] / (1 - coherence[used])
    # Neighbouring lines of a Hann window share 1.5 lines of noise.
    information = float(weight @ omega**2) / 1.5
    slope = float((weight * omega) @ np.angle(cross[used])) / float(weight @ omega**2)
    return ChannelDelay(slope + whole / rate_hz, information**-0.5)


def _whole_samples(one: NDArray[np.float64], other: NDArray[np.float64]) -> int:
    size = 2 * len(one)
    cross = np.fft.irfft(np.fft.rfft(other - other.mean(), size) * np.fft.rfft(one - one.mean(), size).conj(), size)
    lags = np.arange(size)
    lags[lags >= len(one)] -= size
    # A sine has a peak every period; the nearest is meant.
    peaks = lags[cross >= PEAK * cross.max()]
    return int(peaks[np.argmin(np.abs(peaks))])


def _row_of_channel(rig: Rig, name: str) -> int:
    for channel in rig.channels:
        if channel.name == name:
            return channel.index
    raise PlanError(f"the rig has no channel {name!r}", remedy=f"name two of {', '.join(c.name for c in rig.channels)}")
