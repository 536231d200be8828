"""The simulated bench behind the bench protocol."""

import time
from math import ceil, isfinite
from typing import Literal

import numpy as np

from modallab.backend.protocol import BenchInfo, Burst, Chunk, Delivery, Request
from modallab.errors import BenchTimeoutError, ConfigurationError, UnsupportedError
from modallab.schema.rig import Rig
from modallab_simulators.cantilever.address import Settings
from modallab_simulators.cantilever.antialias import DELAY
from modallab_simulators.cantilever.chain import Chain
from modallab_simulators.cantilever.channels import outputs_of
from modallab_simulators.cantilever.draw import Stream, generator
from modallab_simulators.cantilever.excitation import Excitation
from modallab_simulators.cantilever.hammer import Contact
from modallab_simulators.cantilever.shaker import Emission
from modallab_simulators.cantilever.stream import SampleStream
from modallab_simulators.cantilever.structure import Drive, Structure
from modallab_simulators.cantilever.swing import Swing, draw_swing
from modallab_simulators.cantilever.truth import draw_truth, oversampling

RATES_HZ = (100.0, 10_000.0)
OUTPUT_RANGE_V = 10.0
LATENCY_S = 0.002
CUT_S = 0.001
_HEADROOM = 0.8

State = Literal["open", "configured", "running", "stopped", "closed"]


class CantileverBench:
    """A cantilever with hammer, shaker and sensors. Its time goes on only while it is read."""

    def __init__(self, url: str, rig: Rig, settings: Settings) -> None:
        self._rig, self._settings = rig, settings
        self._outputs = outputs_of(rig)
        self._truth = draw_truth(settings, rig)
        self._shaker_x = None if rig.shaker_point is None else rig.x_of(rig.shaker_point)
        self._info = BenchInfo(
            url,
            (("simulated cantilever", f"seed {settings.seed}"),),
            can_drive=self._shaker_x is not None,
            real_time=settings.pace,
            facts=self._truth.facts(rig),
        )
        self._state: State = "open"
        self._starts = self._swings = 0

    @property
    def info(self) -> BenchInfo:
        """What this bench is, with the truth in its facts."""
        return self._info

    def configure(self, request: Request) -> Delivery:
        """Set rate and preamplifiers; any rate from 100 Hz to 10 kHz is delivered as it was asked for."""
        self._require("open", "configured", "stopped", to="configure")
        if not RATES_HZ[0] <= request.rate_hz <= RATES_HZ[1]:
            raise ConfigurationError(
                f"rate {request.rate_hz:g} Hz", where=self._info.url, remedy="ask for 100 Hz to 10 kHz"
            )
        self._rate = float(request.rate_hz)
        self._chain = Chain.of(self._rig, request.test)
        self._structure = Structure(self._truth.basis(self._rate), self._outputs, self._rate, oversampling(self._rate))
        self._state = "configured"
        units = ("V",) * len(self._outputs)
        return Delivery(
            self._rate, self._rate, self._rate, self._chain.dtype, self._chain.volts_per_count.copy(), units
        )

    def start(self) -> None:
        """Start with the beam at rest and the sample count at 0."""
        self._require("configured", "stopped", to="start")
        self._starts += 1
        self._excitation = Excitation(self._shaker_x, self._settings.n_per_v)
        noise = generator(self._settings.seed, Stream.NOISE, self._starts)
        self._stream = SampleStream(self._structure, self._chain, self._excitation, self._rate, noise)
        self._began_s = time.monotonic()
        self._state = "running"

    def read(self, count: int, timeout_s: float) -> Chunk:
        """The next `count` samples; at once, or at the pace of the clock on the wall."""
        self._require("running", to="read")
        if count < 1:
            raise ConfigurationError(f"a read of {count} samples", where=self._info.url, remedy="read 1 or more")
        if self._settings.pace:
            self._wait(count, timeout_s)
        first = self._stream.position
        samples = self._stream.take(count)
        return Chunk(first, samples, self._chain.overload(samples))

    def play(self, burst: Burst) -> int:
        """Start a burst a few samples from now."""
        self._require("running", to="play")
        if self._shaker_x is None:
            raise UnsupportedError("the rig has no shaker", where=self._info.url, remedy="give the rig a shaker_point")
        _check(burst, self._rate)
        if self._excitation.running(self._now_s):
            raise ConfigurationError("a burst is still on", where=self._info.url, remedy="wait for its end, or zero()")
        start = self._stream.position + ceil(LATENCY_S * self._rate)
        self._excitation.emit(Emission(burst, start / self._rate, self._truth.clock))
        self._stream.changed()
        return start + DELAY

    def prompt_hit(self, point: int) -> None:
        """The virtual operator will strike `point` after a reaction time; a newer prompt replaces an older one."""
        self._require("running", to="prompt a hit")
        x_m = self._rig.x_of(point)
        self._swings += 1
        rng = generator(self._settings.seed, Stream.HITS, self._swings)
        swing = draw_swing(rng, self._settings.bad_hits, self._settings.place_m)
        x_m = float(np.clip(x_m + swing.place_m, 0.0, self._truth.true.beam.length_m))
        blow = swing.blow(self._now_s, x_m, self._bearable_n(swing, x_m))
        self._excitation.strike(blow, self._now_s)
        self._stream.changed()

    def zero(self) -> None:
        """Bring the output to 0 V; the amplifier follows within 4 ms."""
        if self._state == "running":
            self._excitation.cut(self._now_s + CUT_S)
            self._stream.changed()

    def stop(self) -> None:
        """Stop streaming, with the output at 0 V."""
        if self._state == "running":
            self.zero()
            self._state = "stopped"

    def close(self) -> None:
        """Release the bench."""
        self.stop()
        self._state = "closed"

    @property
    def _now_s(self) -> float:
        return self._stream.position / self._rate

    def _require(self, *legal: State, to: str) -> None:
        if self._state not in legal:
            raise ConfigurationError(
                f"the bench is {self._state}: cannot {to}",
                where=self._info.url,
                remedy="the order is configure, start, then read and play; stop before another configure",
            )

    def _wait(self, count: int, timeout_s: float) -> None:
        due_s = self._began_s + (self._stream.position + count) / self._rate - time.monotonic()
        if due_s > timeout_s:
            time.sleep(max(timeout_s, 0.0))
            raise BenchTimeoutError(
                f"{count} samples take {due_s:.3f} s, the time allowed is {timeout_s:g} s",
                where=self._info.url,
                remedy="read fewer samples, or wait longer; nothing is lost",
            )
        time.sleep(max(due_s, 0.0))

    def _bearable_n(self, swing: Swing, x_m: float) -> float:
        """Peak at which the most driven channel is at 0.8 of its rail: a good operator keeps below."""
        first, count = self._structure.times(0)
        step_s = 1 / (self._rate * self._structure.oversample)
        unit = Contact(0.001, swing.width_s, 1.0).force(np.arange(first, first + count, dtype=np.float64) * step_s)
        seen, _ = self._structure.advance(self._structure.at_rest, [Drive(x_m, unit)])
        peaks = np.max(np.abs(seen), axis=1) * np.abs(self._chain.volts_per_si)
        rails = self._chain.volts_per_count * self._chain.high
        return _HEADROOM / float(np.max(peaks / rails))


def _check(burst: Burst, rate_hz: float) -> None:
    problems = {
        "frequency_hz": 0 < burst.frequency_hz < rate_hz / 2,
        "amplitude_v": 0 < burst.amplitude_v <= OUTPUT_RANGE_V,
        "ramp_s": isfinite(burst.ramp_s) and burst.ramp_s >= 0,
        "hold_s": isfinite(burst.hold_s) and burst.hold_s >= 0,
    }
    wrong = [f"{name} = {getattr(burst, name)}" for name, good in problems.items() if not good]
    if wrong or burst.duration_s == 0:
        raise ConfigurationError(
            f"a burst of {', '.join(wrong) or 'no duration'}",
            remedy=f"frequency above 0 to half the rate, amplitude above 0 to {OUTPUT_RANGE_V:g} V, times from 0",
        )
