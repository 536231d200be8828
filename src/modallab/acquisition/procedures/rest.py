"""Waiting for rest before a hit: no longer than the plan's own limit asks for, and never past a hit that came early."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from math import log

import numpy as np

from modallab.acquisition.monitor.context import RunContext
from modallab.acquisition.monitor.settled import (
    NoiseFloor,
    SettledCheck,
    Single,
    Window,
    check_settled,
    largest_ratio,
    lines_above_noise,
    mean_sensor_motion,
    sensor_motion,
)
from modallab.acquisition.procedures.trigger import Trigger
from modallab.bench.protocol import SampleChunk
from modallab.core.arrays import Real
from modallab.core.events import HitTooEarly
from modallab.core.plan import ImpactPlan
from modallab.signals.transform import spectrum

LOOKS_A_BLOCK = 4
"""Looks at rest for every block that is waited."""

LOOKS_SHARE = 0.25
"""Of the time, where it is real, that looks may take: many channels at a high rate are looked at less often, or what
the device delivers would be taken too late."""

SHARE, FIRST_SHARE, FEW = 0.8, 0.5, 4
"""Of the weakest hit so far: the next one may be weaker than those before, the more so the fewer these were."""

KEPT = 8
"""Hits at a point, the latest, that say what the next one there will do; and hits whose every sensor is remembered."""

APART_S = 0.5
"""Contacts closer than this are one hit that came early."""


@dataclass(slots=True)
class EarlyHits:
    """Sees every chunk while nothing is requested, and reports whoever strikes.

    Attributes:
        context: the bench.
        plan: the trigger.
        point: next point.
        last: sample of the last early hit; None if there was none since the bench was started.
        seen: how many there were.
    """

    context: RunContext
    plan: ImpactPlan
    point: int
    last: int | None = None
    seen: int = 0
    _trigger: Trigger = field(init=False)

    def __post_init__(self) -> None:
        self._trigger = Trigger(self.plan.trigger_n, self.plan.hysteresis_n)

    def __call__(self, chunk: SampleChunk) -> None:
        """Look at a chunk."""
        force = self.context.conversion.force_n(chunk.samples)
        found = self._trigger.scan(force)
        if found is None:
            return
        at = chunk.first_sample + found
        if self.last is None or at - self.last > self.context.stream.samples_of(APART_S):
            self.seen += 1
            peak = float(force[found:].max())
            self.context.emit(HitTooEarly(run=self.context.recorder.run, point=self.point, peak_n=peak))
        self.last = at

    def stream_restarted(self) -> None:
        """The bench counts from 0 again."""
        self.last = None


@dataclass(frozen=True, eq=False, slots=True)
class HitMotion:
    """How much the hits that count have moved the structure, line by line.

    Attributes:
        per_newton: own motion over the force, line by line, by name of the record.
        sensors: the motion of each sensor, (channels, lines), by the same name.
        forces: (lines,) of the force, by the same name.
        point_of: by the same name.
        sensed_at: (channels,) point of each motion channel, 0 where it has none.
    """

    sensed_at: tuple[int, ...]
    per_newton: dict[str, Real] = field(default_factory=dict[str, Real])
    sensors: dict[str, Single] = field(default_factory=dict[str, Single])
    point_of: dict[str, int] = field(default_factory=dict[str, int])
    forces: dict[str, Real] = field(default_factory=dict[str, Real])

    def add_hit(self, name: str, point: int, force_n: Real, block: Window, n: int, floor: NoiseFloor) -> None:
        """A hit was good; its (m,) force and (channels, m) block in counts, `n` samples of a window."""
        sensors = sensor_motion(block, n, floor)
        self.forces[name] = np.abs(spectrum(force_n - np.median(force_n), n))[: sensors.shape[1]]
        self.per_newton[name] = mean_sensor_motion(sensors) / np.maximum(self.forces[name], 1e-300)
        self.sensors[name] = sensors
        self.point_of[name] = point
        for old in list(self.sensors)[:-KEPT]:
            del self.sensors[old]
        for old in [known for known, at in self.point_of.items() if at == point][:-KEPT]:
            self.remove_hit(old)

    def remove_hit(self, name: str) -> None:
        """It counts no longer."""
        for known in (self.per_newton, self.sensors, self.point_of, self.forces):
            known.pop(name, None)

    def expected_motion(self, point: int) -> Real | None:
        """(lines,) own motion that a weak hit at a point will make; None while nothing says so.

        A point that was not struck yet moves the structure as much more or less than one that was as its sensor moves
        more or less than the sensor there: by reciprocity, and near a mode.
        """
        if not self.forces:
            return None
        share = SHARE if len(self.forces) > FEW else FIRST_SHARE
        weakest = share * np.min(list(self.forces.values()), axis=0)
        here = [name for name, at in self.point_of.items() if at == point]
        if here:
            return weakest * np.min([self.per_newton[name] for name in here], axis=0)
        if point not in self.sensed_at:
            return None
        row = self.sensed_at.index(point)
        found = [self._moved(name, row) for name in self.sensors if self.point_of[name] in self.sensed_at]
        return weakest * np.min(found, axis=0) if found else None

    def _moved(self, name: str, row: int) -> Real:
        sensors = self.sensors[name]
        here, there = sensors[[row, self.sensed_at.index(self.point_of[name])]].astype(np.float64)
        return self.per_newton[name] * here / np.maximum(there, 1e-300)


@dataclass(frozen=True, slots=True)
class RestState:
    """How the structure stands before a hit.

    Attributes:
        check: against the noise floor.
        ratio: what moves as part of what the hit will make; None if that is not known.
        hz: where it is largest.
        good: whether the plan lets the hit come.
    """

    check: SettledCheck
    ratio: float | None
    hz: float
    good: bool

    def facts(self, line_hz: float) -> dict[str, float | str]:
        """For the catalogue."""
        return self.check.facts(line_hz) | ({} if self.ratio is None else {"expected_residual_ratio": self.ratio})


@dataclass(slots=True)
class RestWait:
    """Waits for rest before each hit.

    Attributes:
        context: the bench.
        plan: limit and patience.
        floor: noise at rest.
        early: sees who strikes meanwhile.
        motion: what hits make.
    """

    context: RunContext
    plan: ImpactPlan
    floor: NoiseFloor
    early: EarlyHits
    motion: HitMotion
    _cost: int = field(default=0, init=False)

    def wait(
        self, point: int, ended: Callable[[], bool], report: Callable[[RestState, float | None], None]
    ) -> RestState:
        """Read until the plan lets the hit come; past its patience go on with what there is.

        Args:
            point: next point.
            ended: asked at every look; True ends the wait.
            report: called about once a block with how it stands, and how many seconds it will take, if that is known.
        """
        stream = self.context.stream
        self.early.point = point
        last = stream.next + stream.samples_of(self.plan.hit_timeout_s)
        step = max(1, self.context.block // LOOKS_A_BLOCK)
        before, reported = None, stream.next - LOOKS_A_BLOCK * step
        while not (rest := self._look(point)).good and stream.next < last and not ended():
            if stream.next - reported >= LOOKS_A_BLOCK * step:
                report(rest, self._remaining_s(before, rest, stream.next - reported))
                before, reported = rest, stream.next
            stream.advance_to(stream.next + max(step, self._cost), self.early)
        return rest

    def _look(self, point: int) -> RestState:
        context, stream = self.context, self.context.stream
        began = time.thread_time()
        look = context.look_at_last_window(self.floor, self.early)
        check = check_settled(look, self.floor)
        expected = self.motion.expected_motion(point)
        ratio, line = None, check.line
        if expected is not None:
            ratio, line = largest_ratio(*lines_above_noise(look, self.floor), expected)
        if context.bench.info.real_time:
            self._cost = stream.samples_of((time.thread_time() - began) / LOOKS_SHARE)
        # A hit at a window's end hardly shows in it: the window must lie after the hit.
        struck = self.early.last is not None and stream.next - self.early.last < context.rest_window
        allowed = self.plan.acceptance.max_residual_ratio
        good = not struck and (check.is_settled or (ratio is not None and ratio <= allowed))
        return RestState(check, ratio, line * context.line_hz, good)

    def _remaining_s(self, before: RestState | None, now: RestState, apart: int) -> float | None:
        """From how fast the ratio falls in so many samples."""
        if before is None or not before.ratio or not now.ratio or now.ratio >= before.ratio or now.hz != before.hz:
            return None
        times = log(now.ratio / self.plan.acceptance.max_residual_ratio) / log(before.ratio / now.ratio)
        return max(0.0, times * apart / self.context.stream.rate_hz)
