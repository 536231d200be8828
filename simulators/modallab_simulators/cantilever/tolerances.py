"""A bench as people build it: a little of everything is wrong, drawn from what a rig file says its parts may be off.

What has one sign only is half-normal. Noise differs from row to row, and a little hum is there.
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.rig import FORCE_SHARE, Rig, Tolerance
from modallab_simulators.cantilever.altered import Altered, ChainChanges, StructureChanges
from modallab_simulators.cantilever.attached import Attachment
from modallab_simulators.cantilever.damped import Damper
from modallab_simulators.cantilever.draw import Stream, generator

TERMS = 3
"""Cosine terms of the fields of EI and rho A."""
NOISE = (0.7, 1.6)
"""Between which factors the noise of a row lies."""
HUM_V = 3e-4
"""Most hum."""
DAMPED = (0.1, 1.0)
"""Between which shares of the length a damper stands."""
MOST = 3.0
"""Deviations beyond which nothing is drawn."""


def as_built(altered: Altered, rig: Rig, tolerance: Tolerance, seed: int, lasts_s: float | None) -> Altered:
    """What effects have left of a bench, with everything a little off.

    Args:
        altered: the bench with its effects.
        rig: with a beam.
        tolerance: one standard deviation each.
        seed: draws it all.
        lasts_s: bench time over which the stiffness drifts, unless an effect says it; None for the usual.
    """
    drawn = _Drawn(generator(seed, Stream.TOLERANCES), tolerance)
    return Altered(
        _structure(altered.structure, rig, drawn, lasts_s),
        _chain(altered.chain, rig, drawn),
        replace(altered.excitation, scatter_m=tolerance.hit_position_m, gain_scatter=tolerance.hit_gain),
    )


@dataclass(frozen=True, slots=True)
class _Drawn:
    rng: np.random.Generator
    tolerance: Tolerance

    def some(self, sigma: float, count: int) -> list[float]:
        return (np.clip(self.rng.standard_normal(count), -MOST, MOST) * sigma).tolist()

    def one(self, sigma: float) -> float:
        return abs(self.some(sigma, 1)[0])


def _structure(s: StructureChanges, rig: Rig, drawn: _Drawn, lasts_s: float | None) -> StructureChanges:
    t, beam = drawn.tolerance, rig.beam
    assert beam is not None
    ei_l = beam.bending_stiffness_n_m2 / beam.length_m
    turns = drawn.one(t.clamp_compliance)
    places = [rig.x_of(c.point) for c in rig.responses if c.point is not None]
    cables = [
        Attachment(x, mass=abs(m)) for x, m in zip(places, drawn.some(t.sensor_mass_kg, len(places)), strict=True)
    ]
    waves = tuple((k + 1, a) for k, a in enumerate(drawn.some(t.stiffness_field, TERMS)))
    mass_waves = tuple((k + 1, a) for k, a in enumerate(drawn.some(t.mass_field, TERMS)))
    damper = Damper(float(drawn.rng.uniform(*DAMPED)) * beam.length_m, drawn.one(t.damper_n_s_per_m))
    drift = drawn.some(t.stiffness_drift, 1)[0]
    hung = (drawn.one(t.shaker_mass_kg), drawn.one(t.stinger_rotation) * ei_l)
    at_shaker: tuple[Attachment, ...] = ()
    if rig.shaker_point is not None:
        x = rig.x_of(rig.shaker_point)
        at_shaker = (Attachment(x, mass=hung[0]), Attachment(x, 1, stiffness=hung[1]))
    return replace(
        s,
        root_nm_rad=(*s.root_nm_rad, ei_l / turns) if turns else s.root_nm_rad,
        waves=(*s.waves, *(w for w in waves if w[1])),
        mass_waves=(*s.mass_waves, *(w for w in mass_waves if w[1])),
        attachments=(*s.attachments, *(a for a in cables if a.mass)),
        at_shaker=(*s.at_shaker, *(a for a in at_shaker if a.mass or a.stiffness)),
        dampers=(*s.dampers, damper) if damper.c else s.dampers,
        drift=s.drift + drift,
        drift_s=s.drift_s if s.drift or lasts_s is None else lasts_s,
    )


def _chain(c: ChainChanges, rig: Rig, drawn: _Drawn) -> ChainChanges:
    t, beam = drawn.tolerance, rig.beam
    assert beam is not None
    rows = [r.index for r in rig.responses]
    gains, moves = drawn.some(t.sensitivity, len(rows)), drawn.some(t.position_m, len(rows))
    force = drawn.some(FORCE_SHARE * t.sensitivity, 1)[0]
    factors = drawn.rng.uniform(*NOISE, size=len(rig.channels)).tolist()
    hum = float(drawn.rng.uniform(0, HUM_V))
    moved_m = dict(c.moved_m)
    for row, dx in zip(rows, moves, strict=True):
        point = rig.channels[row].point
        if point is not None and row not in moved_m:
            x = rig.x_of(point)
            # Nothing sits beyond the tip.
            moved_m[row] = min(x + dx, beam.length_m) - x
    return replace(
        c,
        gain={row: c.gain.get(row, 1.0) * (1 + g) for row, g in zip(rows, gains, strict=True)},
        force_gain=c.force_gain * (1 + force),
        moved_m=moved_m,
        noise={row: c.noise.get(row, 1.0) * f for row, f in enumerate(factors)},
        hum=c.hum or (hum, 50.0),
    )
