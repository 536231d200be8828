"""The stream of counts: what stays the same from start to start, and stretches computed one after another."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from modallab.core.arrays import Real
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab_simulators.cantilever.assembled import elements_of
from modallab_simulators.cantilever.basis import Basis
from modallab_simulators.cantilever.beam import RandomStream, random_generator
from modallab_simulators.cantilever.chain import Chain, MainsHum, RandomErrors, outputs_of
from modallab_simulators.cantilever.drifting_structure import DriftingStructure
from modallab_simulators.cantilever.excitation import FloorMotion, ForceTimeline
from modallab_simulators.cantilever.hammer import PEAK_N, WIDTH_S, ContactPulse
from modallab_simulators.cantilever.injected_effects import InjectedEffects
from modallab_simulators.cantilever.loads import BLOCK, BeamLoad, MovingStructure
from modallab_simulators.cantilever.structure import LinearStructure
from modallab_simulators.cantilever.truth import BenchTruth, oversampling

DRIFT_STEP = 1 / 200
HELD_ZETA = 0.15
"""Damping ratio of every mode while a hand lies on the beam."""
_HEADROOM = 0.8


class BenchAtOneRate:
    """The bench as it stands for one test at one delivered rate."""

    def __init__(self, truth: BenchTruth, rig: Rig, test: Test, rate_hz: float) -> None:
        self._truth, self._rig = truth, rig
        self._test: Test = test
        self.rate_hz = rate_hz * (1 + truth.effects.altered.chain.clock)
        self.oversample = oversampling(rate_hz)
        self._progress = 0.0
        self._drifting = DriftingStructure(lambda progress: self._basis(truth, progress))
        self.structure = self._built(truth, self._progress)
        self.chain = self._clipped(Chain.of(rig, test, truth.effects.altered.chain))

    @property
    def step_s(self) -> float:
        """Between internal samples."""
        return 1 / (self.rate_hz * self.oversample)

    def drift_to(self, bench_s: float, *, exactly: bool = False) -> MovingStructure:
        """The structure after some bench time: again at a start, and else where a drift has gone on a good deal."""
        if not self._truth.drift:
            return self.structure
        progress = min(1.0, bench_s / self._truth.effects.altered.structure.drift_s)
        if progress != self._progress and (exactly or abs(progress - self._progress) >= DRIFT_STEP):
            self._progress, self.structure = progress, self._built(self._truth, progress)
        return self.structure

    @cached_property
    def with_hand_on_beam(self) -> MovingStructure:
        """The structure with a hand on the beam."""
        return self._built(replace(self._truth, zeta=(HELD_ZETA,)), self._progress)

    def chain_of_start(self, start: int) -> Chain:
        """The chain with the mains at the phase of this start."""
        mains = self._truth.effects.altered.chain.hum
        if mains is None:
            return self.chain
        phase = float(random_generator(self._truth.seed, RandomStream.HUM, start).uniform(0, 2 * np.pi))
        return replace(self.chain, hum=MainsHum(*mains, phase))

    def floor_of_start(self, start: int) -> FloorMotion | None:
        """The floor's motion in this start."""
        return self._floor and self._floor.starting(random_generator(self._truth.seed, RandomStream.FLOOR, start))

    @cached_property
    def _floor(self) -> FloorMotion | None:
        rms = self._truth.effects.altered.excitation.floor_rms
        return FloorMotion(rms, self.step_s, random_generator(self._truth.seed, RandomStream.FLOOR)) if rms else None

    def overload_force_n(self, width_s: float, x_m: float) -> float:
        """Peak of a hit at which the most driven channel of a sound bench is at 0.8 of its full scale."""
        peaks = self._peaks(self._sound, self._sound_chain, width_s, x_m)
        full_scales = self._sound_chain.volts_per_count * self._sound_chain.high
        return _HEADROOM / float(np.max(peaks / full_scales))

    def _peaks(self, structure: MovingStructure, chain: Chain, width_s: float, x_m: float) -> Real:
        """Of a hit of 1 N, in V, (rows,)."""
        first, count = structure.times(0)
        unit = ContactPulse(0.001, width_s, 1.0).force(np.arange(first, first + count, dtype=np.float64) * self.step_s)
        seen, _ = structure.advance(structure.at_rest, [BeamLoad(x_m, unit)])
        return np.max(np.abs(seen), axis=1) * np.abs(chain.volts_per_si)

    @cached_property
    def _sound(self) -> MovingStructure:
        if not self._truth.effects.effects:
            return self.structure
        return self._built(replace(self._truth, effects=InjectedEffects()), 0.0)

    @cached_property
    def _sound_chain(self) -> Chain:
        return Chain.of(self._rig, self._test, InjectedEffects().altered.chain)

    def _built(self, truth: BenchTruth, progress: float) -> MovingStructure:
        changes = truth.effects.altered.structure
        elements = elements_of(truth.beam_at(progress), changes)
        # Nonlinear elements ask for more than a basis between others knows.
        along = truth is self._truth and not elements and not changes.drag
        basis = self._drifting.basis(progress) if along else self._basis(truth, progress)
        linear = LinearStructure(
            basis, outputs_of(self._rig, truth.effects.altered.chain), self.rate_hz, self.oversample
        )
        if not elements and not changes.drag:
            return linear
        # The compiled loop: a bench without local nonlinearities does not pay for the import.
        from modallab_simulators.cantilever.feedback.structure import FeedbackStructure

        return FeedbackStructure(linear, elements, changes.drag, self.step_s)

    def _basis(self, truth: BenchTruth, progress: float) -> Basis:
        return truth.basis(self.rate_hz, self._test, progress, self.oversample)

    def _clipped(self, chain: Chain) -> Chain:
        for clip in self._truth.effects.altered.chain.clips:
            chain = chain.clipped(clip.row, clip.fraction * (clip.peak_v or self._hardest_v(chain, clip.row)))
        return chain

    def _hardest_v(self, chain: Chain, row: int) -> float:
        """What a row would reach in the hardest good hit, at whatever point of the rig."""
        width = sum(WIDTH_S) / 2
        reached: list[float] = []
        for point in self._rig.points:
            peak = min(PEAK_N[1], self.overload_force_n(width, point.x_m))
            reached.append(peak * self._peaks(self.structure, chain, width, point.x_m)[row].item())
        return max(reached)


StructureAt = Callable[[int], MovingStructure]
"""The structure as it is in a stretch."""


class SampleStream:
    """Samples since the start.

    Stretches lie on a fixed grid and their noise is drawn once, so what is read does not depend on how it is read.
    When the excitation changes within a stretch, the stretch is computed again from the state at its beginning.
    """

    def __init__(
        self,
        structure_at: StructureAt,
        chain: Chain,
        excitation: ForceTimeline,
        rate_hz: float,
        rng: np.random.Generator,
        flaws: np.random.Generator,
    ) -> None:
        self.position = 0
        self._structure_at, self._structure = structure_at, structure_at(0)
        self._chain, self._excitation, self._rng, self._flaws = chain, excitation, rng, flaws
        self._rate_hz = rate_hz
        self._step_s = 1 / (rate_hz * self._structure.oversample)
        self._block = -1
        self._before = self._after = self._structure.at_rest
        self._luck = RandomErrors(np.zeros((0, 0), dtype=np.float32))
        self._counts: NDArray[np.generic] | None = None
        self._passed = np.zeros((0, 0), dtype=np.int16)

    def next_samples(self, count: int) -> NDArray[np.generic]:
        """The next `count` samples, (channels, count)."""
        pieces: list[NDArray[np.generic]] = []
        end = self.position + count
        while self.position < end:
            block, offset = divmod(self.position, BLOCK)
            stop = min(BLOCK, offset + end - self.position)
            pieces.append(self._counts_of(block)[:, offset:stop])
            self.position += stop - offset
        return np.concatenate(pieces, axis=1)

    def skip(self, position: int) -> None:
        """Go on to a sample count; the beam moves on, but nothing is converted on the way."""
        block = position // BLOCK
        for passed in range(max(self._block, 0), block):
            if passed != self._block:
                self._step_to(passed)
            if self._counts is None:
                self._after = self._structure.skip(self._before, self._drives())
                # What follows starts from this stretch's end; it need not be computed again.
                self._counts = self._passed
        self.position = max(self.position, position)

    def excitation_changed(self) -> None:
        """The excitation from here on is another than it was."""
        self._counts = None

    def _counts_of(self, block: int) -> NDArray[np.generic]:
        if block != self._block:
            if self._counts is None and self._block >= 0:
                self._compute()
            self._step_to(block)
        return self._compute() if self._counts is None else self._counts

    def _step_to(self, block: int) -> None:
        structure = self._structure_at(block)
        if structure is not self._structure:
            self._after, self._structure = structure.state_from(self._structure, self._after), structure
        self._block, self._before = block, self._after
        self._luck = self._chain.draw(self._rng, self._flaws, BLOCK)
        self._counts = None

    def _compute(self) -> NDArray[np.generic]:
        seen, self._after = self._structure.advance(self._before, self._drives())
        times = (self._block * BLOCK + np.arange(BLOCK)) / self._rate_hz
        self._counts = self._chain.convert(seen, self._luck, times)
        return self._counts

    def _drives(self) -> list[BeamLoad]:
        first, count = self._structure.times(self._block)
        self._excitation.forget(first * self._step_s)
        return self._excitation.loads_acting(first, count, self._step_s)
