"""A campaign that has not been made yet, as the fits would see it: the twin's own answer and the noise to expect.

The force of a hit is a half sine; the noise of a line of H1 over several hits is that of `reduce_hits` (Bendat and
Piersol, Random Data, 2010).
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import PlanError
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import (
    AFTER_S,
    BEFORE_S,
    IMPACT_BAND,
    NEIGHBOURS,
    ImpactData,
    Piece,
    Reduced,
    Rows,
    SineData,
    Weights,
)
from modallab.gap.model.forward import forward
from modallab.gap.model.nuisances import nuisances
from modallab.twin.response import Hits, Rise, Sines

Array = NDArray[np.float64]
Complex = NDArray[np.complexfloating[Any, Any]]

HIT_N, HIT_S = 80.0, 0.003
"""A plain hit: half a sine of this height and length."""
N_PER_V = 1.0
"""Force per volt of the drive, as a guess."""


def planned(rig: Rig, plans: Sequence[Plan]) -> Reduced:
    """What a campaign of these plans would give on the nominal bench.

    Raises:
        PlanError: there is no test in the plan, or a sine test and no shaker point.
    """
    if not plans:
        raise PlanError("the plan holds no test", remedy="add an impact or a sine test")
    if any(isinstance(plan, BroadbandPlan) for plan in plans):
        raise PlanError("a broadband test has no model in the diagnosis yet", remedy="plan an impact or a sine test")
    step = (rig.converter.volts_per_count if rig.converter is not None else 3e-4) / np.sqrt(12)
    own = rig.converter.noise_rms_v if rig.converter is not None else 3e-4
    weights = Weights(np.full(len(rig.channels), float(np.hypot(own, step))))
    impacts: list[ImpactData] = []
    sines: SineData | None = None
    order = 0.0
    for plan in plans:
        if isinstance(plan, ImpactPlan):
            for point in plan.points:
                impacts.append(_hits(rig, plan, point, weights, order + plan.hits / 2))
                order += plan.hits
        elif isinstance(plan, SinePlan):
            sines = _sines(rig, plan, weights, order)
            order += len(sines.pieces)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    empty = Reduced(rig, tuple(impacts), sines, channels, x, max(order, 1.0))
    free = nuisances(rig, 450.0)
    answers = forward(free.build(np.zeros(free.size)), empty)
    filled = tuple(replace(d, rows=replace(d.rows, y=y)) for d, y in zip(impacts, answers, strict=False))
    if sines is not None:
        sines = replace(sines, rows=replace(sines.rows, y=answers[-1]))
    return replace(empty, impacts=filled, sines=sines)


def _rows(sigma: Array) -> Rows:
    zero = np.zeros(sigma.shape, dtype=np.complex128)
    return Rows(zero, sigma, np.zeros(sigma.shape[1]), zero)


def _hits(rig: Rig, plan: ImpactPlan, point: int, weights: Weights, order: float) -> ImpactData:
    n, dt = round(plan.block_s * plan.rate_hz), 1 / plan.rate_hz
    lines = np.arange(1.0, int(IMPACT_BAND * n) + 1)
    before, after = round(BEFORE_S / dt), round(AFTER_S / dt)
    t = np.arange(-before, after) * dt
    pulse = HIT_N * np.where(np.abs(t) < HIT_S / 2, np.cos(np.pi * t / HIT_S), 0.0)
    start = max(0, round(plan.pre_trigger_s * plan.rate_hz) - before)
    whole = np.zeros(n)
    whole[start : start + len(pulse)] = pulse
    F = np.fft.rfft(whole)[1 : len(lines) + 1]
    power = plan.hits * np.abs(F) ** 2
    source = Hits(lines, n, dt, np.array([pulse]), np.array([start]), (F.conj() / np.abs(F) ** 2)[None])
    sigma = weights.sigma(rig, "impact", lines, n * dt) * np.sqrt(n / 2 / power)
    return ImpactData(Piece(f"impact_p{point:02d}", order, rig.x_of(point), None, ()), source, _rows(sigma))


def _sines(rig: Rig, plan: SinePlan, weights: Weights, order: float) -> SineData:
    if rig.shaker_point is None:
        raise PlanError("the plan has a sine test, the rig no shaker point", remedy="add shaker_point to the rig file")
    n, dt = round(plan.block_s * plan.rate_hz), 1 / plan.rate_hz
    offsets = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    pairs = [(name, volts, hz) for name, volts in plan.levels_v.items() for hz in plan.frequencies_hz]
    lines = np.array([round(hz * n * dt) + offsets for _, _, hz in pairs], dtype=np.float64)
    force = np.array([complex(volts * N_PER_V) for _, volts, _ in pairs])
    count = len(pairs)
    yes = np.ones(count, dtype=np.bool_)
    rise = Rise(np.full(count, plan.settle_s), np.full(count, plan.ramp_s), yes, yes)
    source = Sines(lines, np.array([hz for _, _, hz in pairs]), n, dt, force, rise)
    sigma = np.concatenate(
        [weights.sigma(rig, "sine", at, n * dt) * np.sqrt(2 / n) / abs(f) for at, f in zip(lines, force, strict=True)],
        axis=1,
    )
    x = rig.x_of(rig.shaker_point)
    pieces = tuple(Piece(f"sine_{v}_{hz:.3f}", order + i, x, v, ()) for i, (v, _, hz) in enumerate(pairs))
    return SineData(pieces, source, _rows(sigma), 1.0, 1e-6)
