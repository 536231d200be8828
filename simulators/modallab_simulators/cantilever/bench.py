"""The simulated bench behind the bench protocol."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from math import ceil
from typing import Literal

import numpy as np

from modallab.bench.protocol import AcquisitionRequest, BenchInfo, Burst, DeliveredSampling, SampleChunk, Waveform
from modallab.core.errors import BenchTimeoutError, ConfigurationError, UnsupportedError
from modallab.core.rig import Rig
from modallab_simulators.cantilever.address import EVERYDAY, BenchSettings, SessionConditions
from modallab_simulators.cantilever.beam import RandomStream, random_generator
from modallab_simulators.cantilever.chain import outputs_of
from modallab_simulators.cantilever.excitation import (
    BurstOutput,
    ForceTimeline,
    WaveOutput,
    require_burst,
    require_wave,
)
from modallab_simulators.cantilever.hammer import HammerHit, OperatorLine, PlannedHit, ScriptedHit, draw_hit
from modallab_simulators.cantilever.loads import BLOCK, MovingStructure
from modallab_simulators.cantilever.stream import BenchAtOneRate, SampleStream
from modallab_simulators.cantilever.truth import BenchTruth, draw_truth

RATES_HZ = (100.0, 10_000.0)
LATENCY_S = 0.002
CUT_S = 0.001
KNOCK_S = 1.0
KNOCK_JITTER_S = (0.0, 0.05)
KNOCK_SPREAD = (0.75, 1.45)

State = Literal["open", "configured", "running", "stopped", "closed"]


class CantileverBench:
    """A cantilever with hammer, shaker and sensors. Its time goes on only while it is read.

    Args:
        url: its address.
        rig: what stands there.
        settings: what the address says.
        circumstances: how the bench is met.
    """

    def __init__(
        self, url: str, rig: Rig, settings: BenchSettings, circumstances: SessionConditions = EVERYDAY
    ) -> None:
        self._rig, self._settings = rig, settings
        self._truth = draw_truth(settings, rig, circumstances)
        self._rows = len(outputs_of(rig, self._truth.effects.altered.chain))
        self._shakers_x = tuple(rig.x_of(point) for point in rig.shaker_points)
        self._info = BenchInfo(
            url,
            (("simulated cantilever", f"seed {settings.seed}"),),
            can_drive=bool(self._shakers_x),
            real_time=settings.pace,
            facts=self._truth.facts(),
        )
        self._state: State = "open"
        self._starts = self._swings = circumstances.first_start
        self._circumstances = circumstances
        self._operator = OperatorLine(settings.operator) if settings.operator else None
        self._held_to_s = 0.0
        self._hit_s = 0.0
        self._age_s = 0.0

    @property
    def info(self) -> BenchInfo:
        """What this bench is, with the truth in its facts."""
        return self._info

    @property
    def truth(self) -> BenchTruth:
        """What the seed has drawn, and what was put into it."""
        return self._truth

    @property
    def hit_sample(self) -> int:
        """Sample at which the force of the hit last prompted begins."""
        return ceil(self._hit_s * self._site.rate_hz) + self._site.structure.force_delay

    def rest_until(self, bench_s: float) -> None:
        """Let bench time pass between stop and start: nothing happens but what a drift does."""
        self._require("configured", "stopped", to="rest")
        self._age_s = max(self._age_s, bench_s)

    def skip(self, position: int) -> None:
        """Go on to a sample count without keeping what lies before."""
        self._require("running", to="skip")
        self._stream.skip(position)

    def configure(self, request: AcquisitionRequest) -> DeliveredSampling:
        """Set rate and preamplifiers; any rate from 100 Hz to 10 kHz is delivered as it was asked for."""
        self._require("open", "configured", "stopped", to="configure")
        if not RATES_HZ[0] <= request.rate_hz <= RATES_HZ[1]:
            raise ConfigurationError(
                f"rate {request.rate_hz:g} Hz", where=self._info.url, remedy="ask for 100 Hz to 10 kHz"
            )
        self._rate = float(request.rate_hz)
        self._site = BenchAtOneRate(self._truth, self._rig, request.test, self._rate)
        self._state = "configured"
        chain = self._site.chain
        units = ("V",) * self._rows
        return DeliveredSampling(self._rate, self._rate, self._rate, chain.dtype, chain.volts_per_count.copy(), units)

    def start(self) -> None:
        """Start with the beam at rest and the sample count at 0."""
        self._require("configured", "stopped", to="start")
        self._starts += 1
        site, began_s = self._site, self._age_s
        site.drift_to(began_s, exactly=True)
        self._excitation = ForceTimeline(
            self._shakers_x,
            self._settings.n_per_v,
            site.floor_of_start(self._starts),
            self._truth.effects.altered.excitation.harmonics,
        )
        self._stream = SampleStream(
            lambda block: self._structure_at(site, began_s, block * BLOCK / site.rate_hz),
            site.chain_of_start(self._starts),
            self._excitation,
            site.rate_hz,
            random_generator(self._settings.seed, RandomStream.NOISE, self._starts),
            random_generator(self._settings.seed, RandomStream.FLAWS, self._starts),
        )
        self._began_s, self._held_to_s = time.monotonic(), 0.0
        self._state = "running"

    def read(self, count: int, timeout_s: float) -> SampleChunk:
        """The next `count` samples; at once, or at the pace of the clock on the wall."""
        self._require("running", to="read")
        if count < 1:
            raise ConfigurationError(f"a read of {count} samples", where=self._info.url, remedy="read 1 or more")
        if self._settings.pace:
            self._wait(count, timeout_s)
        if self._operator is not None:
            self._act(self._operator)
        first = self._stream.position
        samples = self._stream.next_samples(count)
        return SampleChunk(first, samples, self._site.chain.overload(samples))

    def play(self, burst: Burst, later_s: float = 0.0) -> int:
        """Start a burst a few samples from now, or by some of a sample later than on one."""
        self._require_ready()
        require_burst(burst, self._rate)
        straight = self._circumstances.straight_ramp
        return self._emit(lambda start_s: BurstOutput(burst, start_s + later_s, self._clock, straight=straight))

    def play_wave(self, wave: Waveform) -> int:
        """Start a wave on the first shaker a few samples from now."""
        return self.play_waves([wave])

    def play_waves(self, waves: Sequence[Waveform]) -> int:
        """Start a wave on each shaker, the first one's first, a few samples from now."""
        self._require_ready()
        if len(waves) > len(self._shakers_x):
            raise UnsupportedError(
                f"{len(waves)} waves for {len(self._shakers_x)} shakers",
                where=self._info.url,
                remedy="list every shaker in the rig file, under shakers",
            )
        for wave in waves:
            require_wave(wave, self._info.url)
        return self._emit(*(partial(WaveOutput, wave, clock=self._clock) for wave in waves))

    def _require_ready(self) -> None:
        self._require("running", to="play")
        if not self._shakers_x:
            raise UnsupportedError("the rig has no shaker", where=self._info.url, remedy="give the rig a shaker_point")
        if self._excitation.is_playing(self._now_s):
            raise ConfigurationError("a burst is still on", where=self._info.url, remedy="wait for it, or call zero()")

    def _emit(self, *made: Callable[[float], BurstOutput | WaveOutput]) -> int:
        start = self._stream.position + ceil(LATENCY_S * self._rate)
        self._excitation.play_outputs(*(one(start / self._site.rate_hz) for one in made))
        self._stream.excitation_changed()
        return start + self._site.structure.force_delay

    def prompt_hit(self, point: int) -> None:
        """The virtual operator will strike `point` after a reaction time; a newer prompt replaces an older one."""
        self._require("running", to="prompt a hit")
        if self._operator is not None:
            return
        x_m = self._rig.x_of(point)
        self._swings += 1
        swing = self._drawn_swing()
        overload_force_n = self._site.overload_force_n(swing.width_s, self._on_beam(x_m + swing.place_m))
        changes = self._truth.effects.altered.excitation
        own_m, own_gain = random_generator(self._settings.seed, RandomStream.SCATTER, self._swings).standard_normal(2)
        x_m = self._on_beam(x_m + swing.place_m + changes.hit_shift_m + own_m * changes.scatter_m)
        hits = self._with_knock(swing.hit(self._now_s, x_m, overload_force_n))
        if changes.gain_scatter:
            # What does not fall square gives the beam more or less than the transducer feels.
            hits.append(hits[0].knock_before(own_gain * changes.gain_scatter))
        self._hit_s = hits[0].start_s
        self._excitation.give_up(self._now_s)
        self._excitation.strike(hits)
        self._stream.excitation_changed()

    def zero(self) -> None:
        """Bring the output to 0 V: after CUT_S it falls from the value it has then."""
        if self._state == "running":
            self._excitation.end_outputs(self._now_s + CUT_S)
            self._stream.excitation_changed()

    def stop(self) -> None:
        """Stop streaming, with the output at 0 V."""
        if self._state == "running":
            self.zero()
            self._state = "stopped"
            self._age_s += self._now_s

    def close(self) -> None:
        """Release the bench."""
        self.stop()
        self._state = "closed"
        if self._operator is not None:
            self._operator.close()

    def _structure_at(self, site: BenchAtOneRate, began_s: float, at_s: float) -> MovingStructure:
        return site.with_hand_on_beam if at_s < self._held_to_s else site.drift_to(began_s + at_s)

    def _act(self, operator: OperatorLine) -> None:
        """Do what the operator has asked for; without a new act nothing changes."""
        for act in operator.next_actions():
            if isinstance(act, ScriptedHit):
                self._swings += 1
                rng = random_generator(self._settings.seed, RandomStream.HITS, self._swings)
                beside_m = act.beside_m + self._settings.place_m * rng.standard_normal()
                self._excitation.strike(act.hits(self._now_s, self._on_beam(self._rig.x_of(act.point) + beside_m)))
                self._stream.excitation_changed()
            else:
                self._held_to_s = self._now_s + act.seconds

    @property
    def _now_s(self) -> float:
        return self._stream.position / self._site.rate_hz

    def _on_beam(self, x_m: float) -> float:
        return float(np.clip(x_m, 0.0, self._truth.true.beam.length_m))

    @property
    def _clock(self) -> float:
        return (1 + self._truth.clock) / self._circumstances.stretch - 1

    def _drawn_swing(self) -> PlannedHit:
        """The next swing; how long the operator waits is counted in samples of the converter."""
        settings = self._settings
        rng = random_generator(settings.seed, RandomStream.HITS, self._swings)
        swing = draw_hit(rng, settings.bad_hits, settings.place_m, settings.peak_n, settings.reaction_s)
        return swing.slowed(self._rate / self._site.rate_hz, self._circumstances.stretch)

    def _with_knock(self, hit: HammerHit) -> list[HammerHit]:
        """The hit, and before it what it finds still ringing: a knock the transducer does not feel."""
        fraction = self._truth.effects.altered.excitation.ringing
        if not fraction:
            return [hit]
        rng = random_generator(self._settings.seed, RandomStream.KNOCKS, self._swings)
        share, before_s = fraction * rng.uniform(*KNOCK_SPREAD), KNOCK_S + rng.uniform(*KNOCK_JITTER_S)
        hit = hit.delayed(max(0.0, self._now_s + before_s - hit.start_s))
        return [hit, hit.knock_before(share).delayed(-before_s)]

    def _require(self, *legal: State, to: str) -> None:
        if self._state not in legal:
            raise ConfigurationError(
                f"the bench is {self._state}: cannot {to}",
                where=self._info.url,
                remedy="the order is configure, start, then read and play; stop before another configure",
            )

    def _wait(self, count: int, timeout_s: float) -> None:
        elapsed_s = (self._stream.position + count) / self._site.rate_hz / self._settings.speed
        due_s = self._began_s + elapsed_s - time.monotonic()
        if due_s > timeout_s:
            time.sleep(max(timeout_s, 0.0))
            raise BenchTimeoutError(
                f"{count} samples take {due_s:.3f} s, the time allowed is {timeout_s:g} s",
                where=self._info.url,
                remedy="read fewer samples, or wait longer; nothing is lost",
            )
        time.sleep(max(due_s, 0.0))
