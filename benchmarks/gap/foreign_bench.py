"""A foreign simulator: the simulated bench's own beam, integrated in time and driven by forces that were recorded.

It has another beam within the tolerances and other damping than the bench it is held against, its parts stand where
the rig file says, and it has no noise. It shares no line of numerics with the twin.
"""

from dataclasses import dataclass
from functools import partial
from math import ceil, inf

import numpy as np
from numpy.typing import NDArray

from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.plan import BLOCK_S
from modallab.core.rig import Rig
from modallab.core.units import Test
from modallab.gap.conditioning.records import records_in_volts, usable_records
from modallab.gap.simulations.simulated_records import simulated_records
from modallab_simulators.cantilever.address import BenchSettings, SessionConditions
from modallab_simulators.cantilever.chain import Chain
from modallab_simulators.cantilever.effect_part import ChainChanges
from modallab_simulators.cantilever.loads import BLOCK, BeamLoad
from modallab_simulators.cantilever.stream import BenchAtOneRate
from modallab_simulators.cantilever.trial import RATES_HZ
from modallab_simulators.cantilever.truth import BenchTruth, draw_truth

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Simulator:
    """A simulator of a rig, with effects in it.

    Attributes:
        rig: as believed.
        effects: what is hidden in it.
        seed: draws its beam and its damping.
    """

    rig: Rig
    effects: tuple[Effect, ...]
    seed: int

    def records(self, campaign: Campaign) -> dict[str, Array]:
        """Record -> (channels, n) for the forces of a campaign, each row in its channel's own unit and direction."""
        settings = BenchSettings(self.seed, bad_hits=0.0, k_root=inf, effects=self.effects)
        truth = draw_truth(settings, self.rig, SessionConditions(one_clock=True, modes=15))
        found: dict[str, Array] = {}
        tests: tuple[Test, ...] = ("impact", "sine")
        for test in tests:
            names = [b.name for b in usable_records(records_in_volts(campaign)) if b.test == test]
            if names:
                site = BenchAtOneRate(truth, self.rig, test, RATES_HZ[test])
                found |= simulated_records(partial(self._sensed, truth, site, test), campaign, names, site.oversample)
        return found

    def _sensed(self, truth: BenchTruth, site: BenchAtOneRate, test: Test, force: Array, _: float) -> Array:
        """(channels, n) in SI units along the drive; between delivered samples nothing is asked for, and it is 0."""
        at = int(np.argmax(np.max(np.abs(force), axis=1)))
        changes = truth.effects.altered
        shift = changes.excitation.hit_shift_m if test == "impact" else 0.0
        x_m = min(max(self.rig.points[at].x_m + shift, 0.0), truth.true.beam.length_m)
        one = force[at] / changes.chain.force_gain
        count = len(one) // site.oversample
        seen = _played(site, x_m, one, count)
        rows = [c.index for c in self.rig.responses]
        own = Chain.of(self.rig, test, ChainChanges()).volts_per_si
        sensed = (seen * (site.chain.volts_per_si / own)[:, None])[rows]
        answer = np.zeros((len(rows), len(one)))
        answer[:, :: site.oversample] = sensed
        return answer


def _played(site: BenchAtOneRate, x_m: float, force: Array, count: int) -> Array:
    """(rows, count) in SI units of a force on internal samples; beyond its end it goes on as it did a block before.

    What filters look ahead to is there: a sine goes on, and after a hit there is none.
    """
    structure, again = site.structure, round(BLOCK_S * site.rate_hz) * site.oversample
    state, stretches = structure.at_rest, []
    for block in range(ceil((count + structure.force_delay) / BLOCK)):
        first, wanted = structure.times(block)
        inside = np.arange(first, first + wanted)
        inside = np.where(inside < len(force), inside, inside - again)
        padded = np.where((inside >= 0) & (inside < len(force)), force[np.clip(inside, 0, len(force) - 1)], 0.0)
        seen, state = structure.advance(state, [BeamLoad(x_m, padded)])
        stretches.append(seen)
    return np.concatenate(stretches, axis=1)[:, structure.force_delay : structure.force_delay + count]
