"""A walk through every channel of a rig before anything is measured with it."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from modallab.acquisition.procedures.sensors import sensor_remarks, supplied_channels, wait_until_settled
from modallab.acquisition.procedures.trigger import Trigger
from modallab.bench.capabilities import ReadsSensitivities
from modallab.bench.protocol import AcquisitionRequest, Bench, Burst, DeliveredSampling
from modallab.core.errors import BenchError
from modallab.core.rig import Channel, Rig
from modallab.core.units import Test
from modallab.signals.conversion import Conversion, volts_per_count
from modallab.signals.tone_fit import fit_frequency

Verdict = Literal["good", "look", "bad"]

CHUNK_S = 0.1
TIMEOUT_S = 10.0


@dataclass(frozen=True, slots=True)
class CheckResult:
    """One verdict.

    Attributes:
        channel: of the rig, or what else was looked at.
        what: supply, noise, offset, overload, polarity, sensitivity, clock, phase and the like.
        value: in words and numbers.
        verdict: `look` where a person must decide.
    """

    channel: str
    what: str
    value: str
    verdict: Verdict


def read_seconds(bench: Bench, rate_hz: float, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The next `seconds`: (channels, n) as delivered, and (channels,) which were beyond the range."""
    return read_samples(bench, rate_hz, round(seconds * rate_hz))


def read_samples(bench: Bench, rate_hz: float, count: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The next (channels, count) samples, and (channels,) which were beyond the range."""
    pieces: list[NDArray[np.float64]] = []
    step = max(1, round(CHUNK_S * rate_hz))
    over: NDArray[np.bool_] | None = None
    for first in range(0, count, step):
        chunk = bench.read(min(step, count - first), TIMEOUT_S)
        pieces.append(chunk.samples.astype(np.float64))
        over = chunk.overload if over is None else over | chunk.overload
    assert over is not None
    return np.concatenate(pieces, axis=1), over


RATE_HZ = 2000.0
NOISE_FACTOR = 5.0
OFFSET_PART = 0.05
CLOCK_PPM = 100.0
CLOCK_HZ, CLOCK_BURST_S, CLOCK_RAMP_S = 40.0, 5.0, 0.5
TAP_N = 5.0
TAP_PATIENCE_S = 60.0
CONTACT_S = 0.01


def check_idle(bench: Bench, rig: Rig, seconds: float = 3.0) -> list[CheckResult]:
    """Noise, offset and overload of every channel, while nothing moves; and what the sensors say of themselves."""
    findings = check_sensors(bench, rig)
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    bench.start()
    try:
        findings += wait_for_sensors(bench, rig, delivery)[0]
        samples, over = _read(bench, delivery, seconds)
    finally:
        bench.stop()
    volts = samples * volts_per_count(rig, "impact", delivery.units, delivery.scale)[:, None]
    for channel, row, flag in zip(rig.channels, volts, over, strict=True):
        findings += _check_channel(channel, rig, row, bool(flag))
    return findings


def check_polarity(bench: Bench, rig: Rig, ask: Callable[[int], None]) -> list[CheckResult]:
    """A tap at every sensor's own point: force and acceleration must go the same way while the hammer touches.

    Args:
        bench: open, not started.
        rig: as believed.
        ask: notifies whoever taps which point comes next.
    """
    delivery = bench.configure(AcquisitionRequest("impact", RATE_HZ))
    conversion = Conversion.of(rig, "impact", delivery.units, delivery.scale, delivery.dtype)
    bench.start()
    wait_for_sensors(bench, rig, delivery)
    sensors = [c for c in rig.responses if c.point is not None and c.quantity == "acceleration"]
    try:
        return [_check_by_tap(bench, delivery, conversion, channel, ask) for channel in sensors]
    finally:
        bench.stop()


def check_clock(bench: Bench, rig: Rig, volts: float) -> list[CheckResult]:
    """A small burst, whose frequency on the converter's clock is compared with what the generator was set to."""
    if not bench.info.can_drive:
        return [CheckResult("generator", "clock", "this bench has no output", "look")]
    delivery = bench.configure(AcquisitionRequest("sine", RATE_HZ))
    bench.start()
    try:
        read = wait_for_sensors(bench, rig, delivery)[1]
        begin = bench.play(Burst(CLOCK_HZ, volts, CLOCK_RAMP_S, CLOCK_BURST_S - 2 * CLOCK_RAMP_S)) - read
        count = begin + round(1.0 * delivery.rate_hz)
        lead, _ = read_samples(bench, delivery.rate_hz, count)
        held, _ = read_seconds(bench, delivery.rate_hz, 3.0)
        read_seconds(bench, delivery.rate_hz, 1.0)
    finally:
        bench.zero()
        bench.stop()
    force = rig.force_channel.index
    before = lead[force, : max(16, begin // 2)].std()
    row = (held[force] * delivery.scale[force])[None, :]
    if held[force].std() < 3 * before:
        return [CheckResult("generator", "clock", f"{volts:g} V give no measurable force", "bad")]
    found = fit_frequency(row, delivery.rate_hz, CLOCK_HZ).frequency_hz
    ppm = 1e6 * (found / CLOCK_HZ - 1)
    verdict: Verdict = "good" if abs(ppm) <= CLOCK_PPM else "bad"
    return [CheckResult("generator", "clock", f"{ppm:+.1f} ppm off the converter's clock", verdict)]


def wait_for_sensors(bench: Bench, rig: Rig, delivery: DeliveredSampling) -> tuple[list[CheckResult], int]:
    """Read on until fed sensors have settled; returns what was found, and how many samples were read."""
    fed, read = supplied_channels(bench, rig), 0

    def pull(count: int) -> NDArray[np.float64]:
        nonlocal read
        read += count
        return read_samples(bench, delivery.rate_hz, count)[0]

    wait = wait_until_settled(pull, fed, delivery.rate_hz)
    settled, moving = f"settled after {wait.seconds:g} s", f"the bias still moves after {wait.seconds:g} s"
    findings = [
        CheckResult(name, "supply", moving, "bad")
        if name in wait.unsettled
        else CheckResult(name, "supply", settled, "good")
        for name in fed.values()
    ]
    return findings, read


def _read(bench: Bench, delivery: DeliveredSampling, seconds: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    # What a filter still holds from before the start is let go by first.
    read_seconds(bench, delivery.rate_hz, 0.2)
    return read_seconds(bench, delivery.rate_hz, seconds)


def _check_channel(channel: Channel, rig: Rig, volts: NDArray[np.float64], over: bool) -> list[CheckResult]:
    noise, offset = float(volts.std()), float(volts.mean())
    believed = rig.converter.noise_rms_v if rig.converter else 0.0
    range_v = channel.range_v or (rig.converter.range_v if rig.converter else np.inf)
    noise_verdict: Verdict = "good"
    if noise == 0:
        noise_verdict = "bad"
    elif believed and noise > NOISE_FACTOR * believed:
        noise_verdict = "look"
    level = f"{1e3 * noise:.4g} mV rms" + (" (a dead channel)" if noise == 0 else f", {1e3 * believed:.4g} believed")
    offset_verdict: Verdict = "good" if abs(offset) <= OFFSET_PART * range_v else "look"
    return [
        CheckResult(channel.name, "noise", level, noise_verdict),
        CheckResult(channel.name, "offset", f"{1e3 * offset:+.4g} mV of {range_v:g} V", offset_verdict),
        CheckResult(
            channel.name, "overload", "beyond the range at rest" if over else "none", "bad" if over else "good"
        ),
    ]


def check_sensors(bench: Bench, rig: Rig) -> list[CheckResult]:
    """What certificates and the sensors themselves say, against the rig file; for each that says something."""
    today = datetime.now(UTC).date()
    remarks = [remark for test in _tests(rig) for remark in sensor_remarks(rig, test, today, bench)]
    sensed = bench.read_sensitivities() if isinstance(bench, ReadsSensitivities) else {}
    findings = [
        CheckResult(remark.channel, "sensor", remark.what, "bad" if remark.contradiction else "look")
        for remark in dict.fromkeys(remarks)
    ]
    named = {remark.channel for remark in remarks}
    good = [c for c in rig.channels if c.name not in named and (c.certificate is not None or c.name in sensed)]
    return [*findings, *(CheckResult(c.name, "sensor", _known_of(c, sensed), "good") for c in good)]


def _tests(rig: Rig) -> list[Test]:
    given = [set(c.sensitivity_v_per_unit) for c in rig.channels if isinstance(c.sensitivity_v_per_unit, dict)]
    # Where the preamplifier stands differently in each test, a certificate is that of one of them.
    return ["impact"] if not given or all("impact" in tests for tests in given) else ["sine"]


def _known_of(channel: Channel, sensed: dict[str, float]) -> str:
    named = [f"TEDS says {sensed[channel.name]:.5g} V per SI unit"] if channel.name in sensed else []
    if channel.certificate is not None:
        named.append(f"certificate {channel.certificate.number}, {channel.certificate.uncertainty_percent:g} % (k = 2)")
    return "; ".join(named)


def _check_by_tap(
    bench: Bench, delivery: DeliveredSampling, conversion: Conversion, channel: Channel, ask: Callable[[int], None]
) -> CheckResult:
    assert channel.point is not None
    ask(channel.point)
    bench.prompt_hit(channel.point)
    trigger = Trigger(TAP_N, TAP_N / 2)
    step = round(CHUNK_S * delivery.rate_hz)
    before = read_samples(bench, delivery.rate_hz, step)[0]
    for _ in range(round(TAP_PATIENCE_S / CHUNK_S)):
        after = read_samples(bench, delivery.rate_hz, step)[0]
        place = trigger.scan(conversion.force_n(after))
        if place is not None:
            both = np.concatenate([before, after, read_samples(bench, delivery.rate_hz, step)[0]], axis=1)
            return _polarity(channel, conversion.to_si(both), step + place, conversion.force, delivery.rate_hz)
        before = after
    raise BenchError(
        f"no tap above {TAP_N:g} N at point {channel.point} within {TAP_PATIENCE_S:g} s",
        remedy="tap harder, or check the hammer's cable",
    )


def _polarity(channel: Channel, values: NDArray[np.float64], place: int, force: int, rate_hz: float) -> CheckResult:
    # At the point that is struck the beam answers at first as a mass does: with the force, as long as it acts.
    touch = slice(max(0, place - round(CONTACT_S * rate_hz / 2)), place + round(CONTACT_S * rate_hz))
    push = values[force, touch]
    answer = values[channel.index, touch] - values[channel.index, : max(1, touch.start)].mean()
    together = float(push @ answer / np.sqrt((push @ push) * (answer @ answer)))
    # The conversion has turned what the rig file says is mounted against the drive: all must go with the force.
    verdict: Verdict = "good" if together > 0.2 else ("bad" if together < -0.2 else "look")
    return CheckResult(channel.name, "polarity", f"with the force by {together:+.2f} at point {channel.point}", verdict)
