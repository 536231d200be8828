"""A whole campaign in a moment, with its truth: what blind trials of a diagnosis are made of.

The plan is one session of a practised operator: six hits each at points 6, 10 and 3, then 24 frequencies at a low and a
high level from the shaker. Every block begins with the beam at rest: the block of a hit 0.05 s before it, that of a
sine 8 s after the shaker has begun to rise.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil, inf, pi

import numpy as np
from numpy.typing import NDArray

from modallab.bench.protocol import AcquisitionRequest, Burst, DeliveredSampling
from modallab.core.block import Block, Campaign
from modallab.core.effects import Effect
from modallab.core.errors import ConfigurationError
from modallab.core.plan import BLOCK_S, PAPER_LINES
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab_simulators.cantilever.address import BenchSettings, SessionConditions
from modallab_simulators.cantilever.beam import draw_damping
from modallab_simulators.cantilever.bench import CantileverBench
from modallab_simulators.cantilever.effects import part_of
from modallab_simulators.cantilever.injected_effects import effect_in_truth, inject_effects
from modallab_simulators.cantilever.truth import BenchTruth

HITS = {6: (24.0, 90.0), 10: (10.0, 35.0), 3: (24.0, 90.0)}
"""Where the operator strikes six times each, and how hard, in N: softer where the beam gives way."""

LEVELS_N = {"low": 1.2, "high": 8.0}
RATES_HZ: dict[Test, float] = {"impact": 2000.0, "sine": 1000.0}
PRE_TRIGGER_S = 0.05
SETTLE_S = 8.0
RAMP_S = 1.0
REACTION_S = (1.2, 1.7)
"""From the prompt to the hit: time enough for something else to knock before."""

RECORD_S = 60.0
"""From the beginning of one record to that of the next."""

LAST_ORDER = len(HITS) * 6 + len(LEVELS_N) * len(PAPER_LINES) - 1
"""Place in time of a campaign's last record."""

_CIRCUMSTANCES = SessionConditions(one_clock=True, straight_ramp=True, modes=15, drift_s=LAST_ORDER * RECORD_S)
"""One card drives and converts; fifteen modes reach well past the band, as those of the twin do."""

_REPEATS = 6
_STARTS = 1000
"""More than one session has."""
_N_PER_V = 2.0
_MASS_SHARE = 1 / 6


def make_trial(
    rig: Rig, seed: int, effects: Sequence[Effect] = (), tolerances: str = "none", session: int = 0
) -> tuple[Campaign, dict[str, object]]:
    """Measure a campaign on the simulated bench of a rig, rigidly clamped, with some effects.

    Args:
        rig: what the operator believes, with points 3, 6 and 10 and a shaker point; of the clamp that it is rigid.
        seed: draws the true beam, its damping, the hits and all noise. Two trials of one seed differ by their effects
            only: forces and noise are the same.
        effects: of the catalogue, or of this bench's own.
        tolerances: how well the bench is put together, as in its address.
        session: another one is another campaign on the same bench, with hits and noise of its own.

    Returns:
        the campaign, and its truth: seed, effects (effect, family, parameters, place) and the true beam.

    Raises:
        ConfigurationError: the rig lacks what the plan needs, or has no place for an effect.
    """
    rig = rigidly_clamped(rig)
    operator = SessionOperator(rig, seed, effects, tolerances=tolerances, session=session)
    campaign = Campaign(rig, tuple(operator.blocks()), source=f"simulated trial, seed {seed}")
    return campaign, _truth(operator.truth, effects)


def sound_trial(rig: Rig, seed: int, effects: Sequence[Effect]) -> Campaign:
    """The trial without effects that has the recorded forces of the one with: what a perfect twin would predict.

    A force channel with a wrong gain is the one thing it does not follow.
    """
    forces = [e for e in effects if part_of(e.effect).seen_by_force]
    rig = rigidly_clamped(rig)
    operator = SessionOperator(rig, seed, forces, 1 + inject_effects(effects, rig).altered.chain.clock)
    return Campaign(rig, tuple(operator.blocks()), source=f"simulated trial, seed {seed}, nothing wrong")


def rigidly_clamped(rig: Rig) -> Rig:
    """The rig as believed in a trial: with a clamp that neither turns nor shifts."""
    beam = rig.beam
    return rig if beam is None else rig.model_copy(update={"beam": beam.model_copy(update={"clamp": "rigid at x = 0"})})


def _timed(effect: Effect) -> Effect:
    lasts = part_of(effect.effect).lasts
    if lasts is None:
        return effect
    return effect.model_copy(update={"parameters": {**effect.parameters, lasts: LAST_ORDER * RECORD_S}})


class SessionOperator:
    """Takes the records of one session at the bench, one after another.

    Args:
        rig: what is believed.
        seed: of the trial.
        effects: in the bench.
        stretch: how much longer than meant all takes that excites, see `SessionConditions`.
        order: place in time of the first record.
        tolerances: how well the bench is put together, as in its address.
        session: the how manieth on this bench.
    """

    def __init__(
        self,
        rig: Rig,
        seed: int,
        effects: Sequence[Effect] = (),
        stretch: float = 1.0,
        order: int = 0,
        tolerances: str = "none",
        session: int = 0,
    ) -> None:
        self._first_start = session * _STARTS
        self._rig, self._session = rig, replace(_CIRCUMSTANCES, stretch=stretch)
        self._effects = inject_effects(effects, rig).effects
        played = tuple(_timed(e) for e in effects if part_of(e.effect).on_campaign is None)
        self._settings = BenchSettings(
            seed,
            bad_hits=0.0,
            k_root=inf,
            n_per_v=_N_PER_V,
            reaction_s=REACTION_S,
            effects=played,
            tolerances=tolerances,
        )
        self._order = order
        self.truth = CantileverBench("sim://cantilever", rig, self._settings, self._session).truth

    def blocks(self) -> list[Block]:
        """All records, in the order of time."""
        blocks = [*self.hits(), *self.sines()]
        for effect in self._effects:
            on_campaign = part_of(effect.effect).on_campaign
            blocks = blocks if on_campaign is None else on_campaign(blocks, effect)
        return blocks

    def hits(self) -> Iterator[Block]:
        """Six hits at each point."""
        for number, (point, peak_n) in enumerate(HITS.items()):
            bench, delivery = self._bench("impact", replace(self._settings, peak_n=peak_n), number)
            for hit in range(1, _REPEATS + 1):
                bench.start()
                bench.prompt_hit(point)
                first = bench.hit_sample - round(PRE_TRIGGER_S * delivery.rate_hz)
                samples = self._record(bench, delivery, first)
                yield self._block(f"impact_p{point:02d}_{hit}", "impact", delivery, samples, point, first)

    def sines(self, lines: Sequence[int] = PAPER_LINES) -> Iterator[Block]:
        """Each frequency, in lines of the block, at each level, weaker where the beam answers more."""
        if self._rig.shaker_point is None:
            raise ConfigurationError("the rig has no shaker", remedy="give the rig a shaker_point")
        bench, delivery = self._bench("sine", self._settings, len(HITS))
        # The beam has had its eight seconds whatever the converter's clock makes of them.
        rate_hz = delivery.rate_hz * (1 + self.truth.effects.altered.chain.clock)
        settle = ceil(SETTLE_S * rate_hz - 1e-9)
        later_s = settle / rate_hz - SETTLE_S
        for level, force_n in LEVELS_N.items():
            for line in lines:
                f = line / BLOCK_S
                bench.start()
                volts = force_n / self._give(f) / _N_PER_V
                first = settle + bench.play(Burst(f, volts, RAMP_S, SETTLE_S + BLOCK_S), later_s)
                samples = self._record(bench, delivery, first)
                block = self._block(f"sine_{level}_{f:07.3f}", "sine", delivery, samples, self._rig.shaker_point, first)
                yield replace(block, level=level, frequency_hz=round(f, 3))

    def _bench(self, test: Test, settings: BenchSettings, number: int) -> tuple[CantileverBench, DeliveredSampling]:
        session = replace(self._session, first_start=self._first_start + number * _REPEATS)
        bench = CantileverBench("sim://cantilever", self._rig, settings, session)
        delivery = bench.configure(AcquisitionRequest(test, RATES_HZ[test]))
        bench.rest_until(self._order * RECORD_S)
        return bench, delivery

    def _record(self, bench: CantileverBench, delivery: DeliveredSampling, first: int) -> NDArray[np.generic]:
        count = round(BLOCK_S * delivery.rate_hz)
        bench.skip(first)
        samples = bench.read(count, 1.0).samples
        bench.stop()
        self._order += 1
        bench.rest_until(self._order * RECORD_S)
        return samples

    def _block(
        self, name: str, test: Test, delivery: DeliveredSampling, samples: NDArray[np.generic], point: int, first: int
    ) -> Block:
        return Block(
            name,
            test,
            self._order - 1,
            delivery.rate_hz,
            samples,  # pyrefly: ignore[bad-argument-type]  # whole counts, as the chain of this bench delivers them
            delivery.scale,
            delivery.units,
            tuple(c.name for c in self._rig.channels),
            point,
            first_sample=first,
            requested_rate_hz=delivery.requested_rate_hz,
            actual_rate_hz=delivery.actual_rate_hz,
        )

    def _give(self, f_hz: float) -> float:
        """By how much the force falls: a shaker's armature of a sixth of the beam takes its share of it."""
        assert self._rig.shaker_point is not None
        beam, omega = self.truth.true.beam, 2 * pi * f_hz
        count = beam.count_below(20 * omega) + 5
        phi = beam.shapes(np.array([self._rig.x_of(self._rig.shaker_point)]), count)[0]
        own = beam.omega(count)
        zeta = draw_damping(self.truth.seed, count, self.truth.zeta)
        inertance = np.sum(-(omega**2) * phi**2 / (own**2 - omega**2 + 2j * zeta * own * omega))
        return 1 + abs(complex(inertance)) * beam.total_mass_kg * _MASS_SHARE


def _truth(truth: BenchTruth, effects: Sequence[Effect]) -> dict[str, object]:
    return {
        "seed": truth.seed,
        "effects": [effect_in_truth(e) for e in inject_effects(effects, truth.rig).effects],
        "true_E": truth.true.youngs_modulus_pa,
        "true_thickness": truth.true.thickness_m,
        "true_rho": truth.true.density_kg_m3,
        "true_zeta": draw_damping(truth.seed, 3, truth.zeta).tolist(),
    }
