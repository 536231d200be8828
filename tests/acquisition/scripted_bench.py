"""A bench whose signals are known to the sample: noise, hits at given places after each prompt, bursts, and faults."""

from dataclasses import dataclass, field

import numpy as np

from modallab.bench.protocol import AcquisitionRequest, BenchInfo, Burst, DeliveredSampling, SampleChunk
from modallab.core.errors import DeviceGoneError, SamplesLostError
from modallab.core.rig import Channel, Converter, Limits, Point, Rig

SCALE = 0.01
RING_HZ = 60.0


def scripted_rig(limits: Limits | None = None) -> Rig:
    """Force and two accelerations of 1 V per unit, so that a count is 0.01 N or 0.01 m/s^2."""
    force = Channel(index=0, name="force", quantity="force", unit="N")
    responses = [Channel(index=k, name=f"a{k:02d}", quantity="acceleration", unit="m/s^2", point=k) for k in (1, 2)]
    return Rig(
        name="scripted",
        model="unknown",
        points=(Point(id=1, x_m=0.1), Point(id=2, x_m=0.2)),
        channels=(force, *responses),
        converter=Converter(bits=16, range_v=SCALE * 2**15),
        shaker_point=2,
        limits=limits,
    )


@dataclass(frozen=True)
class Strike:
    """A hit `delay` samples after the prompt: sin^2, `width` samples, and the response it leaves."""

    delay: int = 300
    peak_n: float = 100.0
    width: int = 8
    second_n: float = 0.0
    response: float = 30.0
    zeta: float = 0.05

    def force(self, n: np.ndarray) -> np.ndarray:
        def pulse(at: np.ndarray) -> np.ndarray:
            return np.where((at > 0) & (at < self.width), np.sin(np.pi * at / self.width) ** 2, 0.0)

        return self.peak_n * pulse(n) + self.second_n * pulse(n - 40)

    def motion(self, n: np.ndarray, rate_hz: float) -> np.ndarray:
        t = np.maximum(n, 0) / rate_hz
        omega = 2 * np.pi * RING_HZ
        return self.response * np.exp(-self.zeta * omega * t) * np.sin(omega * t)


@dataclass
class ScriptedBench:
    """Delivers what it was set to. `done` holds the calls that touch the output, in order.

    Attributes:
        strikes: one per prompt; the last is repeated.
        hum: amplitude in counts of a steady 50 Hz tone on the responses.
        gain: counts of force and acceleration per V of drive.
        lose_at: device counts at which samples are lost, each once.
        gone_at: device count from which on the device is gone.
    """

    strikes: list[Strike] = field(default_factory=lambda: [Strike()])
    hum: float = 0.0
    gain: float = 100.0
    lose_at: list[int] = field(default_factory=list)
    gone_at: int | None = None
    done: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.noise = np.random.default_rng(5).normal(0, 2.0, (3, 1 << 16))
        self.hits: list[tuple[int, Strike]] = []
        self.bursts: list[tuple[int, Burst]] = []
        self.prompts: list[int] = []
        self.position = 0
        self.rate_hz = 0.0

    @property
    def info(self) -> BenchInfo:
        return BenchInfo("scripted://", (("script", "1"),), True, False, {})

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        self.rate_hz = request.rate_hz
        rate = request.rate_hz
        return DeliveredSampling(rate, rate, rate, np.dtype(np.int16), np.full(3, SCALE), ("V", "V", "V"))

    def start(self) -> None:
        self.position = 0
        self.hits.clear()
        self.bursts.clear()

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        if self.gone_at is not None and self.position + count > self.gone_at:
            raise DeviceGoneError("the device is gone", where="scripted://", remedy="plug it in")
        if self.lose_at and self.position + count > self.lose_at[0]:
            raise SamplesLostError(f"overrun at {self.lose_at.pop(0)}", where="scripted://", remedy="a faster machine")
        first = self.position
        self.position += count
        samples = np.clip(np.rint(self._counts(first, count)), -32768, 32767).astype(np.int16)
        return SampleChunk(first, samples, (samples == 32767).any(axis=1) | (samples == -32768).any(axis=1))

    def _counts(self, first: int, count: int) -> np.ndarray:
        n = np.arange(first, first + count)
        counts = self.noise[:, n % self.noise.shape[1]]
        counts[1:] += self.hum * np.sin(2 * np.pi * 50 * n / self.rate_hz)
        for start, strike in self.hits:
            counts[0] += strike.force(n - start) / SCALE
            counts[1:] += strike.motion(n - start, self.rate_hz) / SCALE
        for start, burst in self.bursts:
            counts += self.gain * burst_volts(burst, (n - start) / self.rate_hz)
        return counts

    def play(self, burst: Burst) -> int:
        self.done.append("play")
        self.bursts.append((self.position + 3, burst))
        return self.position + 3

    def prompt_hit(self, point: int) -> None:
        strike = self.strikes[min(len(self.prompts), len(self.strikes) - 1)]
        self.prompts.append(self.position)
        self.hits.append((self.position + strike.delay, strike))

    def zero(self) -> None:
        self.done.append("zero")
        self.bursts.clear()

    def stop(self) -> None:
        self.done.append("stop")

    def close(self) -> None:
        self.done.append("close")


def burst_volts(burst: Burst, t: np.ndarray) -> np.ndarray:
    edge = np.clip(np.minimum(t, burst.duration_s - t) / burst.ramp_s, 0, 1)
    return burst.amplitude_v * np.sin(2 * np.pi * burst.frequency_hz * t) * (1 - np.cos(np.pi * edge)) / 2
