"""A campaign that has not been made yet, as the fits would see it: a twin's answer and the noise to expect.

The force of a hit is a half sine; the noise of a line of H1 over several hits is that of `reduce_hits` (Bendat and
Piersol, Random Data, 2010).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.errors import PlanError
from modallab.core.plan import BroadbandPlan, ImpactPlan, Plan, SinePlan
from modallab.core.rig import Rig
from modallab.gap.conditioning.reduce import AFTER_S, BEFORE_S, IMPACT_BAND, NEIGHBOURS
from modallab.gap.conditioning.rows import DataPiece, ImpactData, Reduced, Rows, SineData, Weights, rows_of
from modallab.gap.model.fit import GENERATOR
from modallab.gap.model.forward import forward
from modallab.gap.model.nuisances import nuisances
from modallab.twin.bench import Twin
from modallab.twin.response import HitsAtPoint, SineBlocks, SineStartUp

HIT_N, HIT_S = 80.0, 0.003
"""A plain hit: half a sine of this height and length."""
N_PER_V = 1.0
"""Force per volt of the drive, as a guess."""


@dataclass(frozen=True, eq=False, slots=True)
class PlannedRecords:
    """Records that have not been made: what drives them and their noise, without an answer.

    Attributes:
        data: as `Reduced`, its answers 0.
        force_noise: of each drive point, then of the sines: (rows,) noise of the force over the force.
    """

    data: Reduced
    force_noise: tuple[Real, ...]

    def predicted_by(self, twin: Twin) -> Reduced:
        """The records as a twin answers them, without noise; a clock that is wrong shows in the sines."""
        answers = forward(twin, self.data)
        impacts = tuple(
            replace(d, rows=rows_of(y, d.rows.sigma, noise))
            for d, y, noise in zip(self.data.impacts, answers, self.force_noise, strict=False)
        )
        sines = self.data.sines
        if sines is not None:
            rows = rows_of(answers[-1], sines.rows.sigma, self.force_noise[-1])
            sines = replace(sines, rows=rows, ratio=1 / (1 + twin.clock))
        return replace(self.data, impacts=impacts, sines=sines)


def join_planned(layouts: Sequence[PlannedRecords]) -> PlannedRecords:
    """The records of several plans side by side, each as it would be were it run alone; at least one."""
    first = layouts[0].data
    impacts = tuple(d for one in layouts for d in one.data.impacts)
    hit_numbers = tuple(noise for one in layouts for noise in one.force_noise[: len(one.data.impacts)])
    sines = [(one.data.sines, one.force_noise[-1]) for one in layouts if one.data.sines is not None]
    test, noise = _one_test(sines) if sines else (None, ())
    return PlannedRecords(replace(first, impacts=impacts, sines=test), (*hit_numbers, *noise))


def records_of_plans(rig: Rig, plans: Sequence[Plan]) -> Reduced:
    """What a campaign of these plans would give on the nominal bench.

    Raises:
        PlanError: there is no test in the plan, or a sine test and no shaker point.
    """
    free = nuisances(rig, 450.0)
    return records_of_plan(rig, plans, weights_by_converter_noise(rig)).predicted_by(free.build(np.zeros(free.size)))


def weights_by_converter_noise(rig: Rig) -> Weights:
    """The noise of the converter that a rig file states, on all rows."""
    step = (rig.converter.volts_per_count if rig.converter is not None else 3e-4) / np.sqrt(12)
    own = rig.converter.noise_rms_v if rig.converter is not None else 3e-4
    return Weights(np.full(len(rig.channels), float(np.hypot(own, step))))


def records_of_plan(
    rig: Rig, plans: Sequence[Plan], weights: Weights, pulse: HitsAtPoint | None = None, done: Reduced | None = None
) -> PlannedRecords:
    """The records that plans would give; those of all sine tests are one.

    Args:
        rig: the bench.
        plans: what would be run.
        weights: the noise of the rows.
        pulse: what hits drive with; None for a plain hit.
        done: records that are there already, behind which these come.

    Raises:
        PlanError: there is no test in the plan, or a sine test and no shaker point.
    """
    if not plans:
        raise PlanError("the plan holds no test", remedy="add an impact or a sine test")
    if any(isinstance(plan, BroadbandPlan) for plan in plans):
        raise PlanError("a broadband test has no model in the diagnosis yet", remedy="plan an impact or a sine test")
    order = 0.0 if done is None else done.last_order + 1
    hits: list[tuple[ImpactData, Real]] = []
    sines: list[tuple[SineData, Real]] = []
    for plan in plans:
        if isinstance(plan, ImpactPlan):
            for point in plan.points:
                hits.append(_planned_hits(rig, plan, point, weights, order + plan.hits / 2, pulse))
                order += plan.hits
        elif isinstance(plan, SinePlan):
            sines.append(_planned_sines(rig, plan, weights, order))
            order += len(sines[-1][0].pieces)
    channels = tuple(c.index for c in rig.responses)
    x = np.array([rig.x_of(c.point or 0) for c in rig.responses])
    last = max(order, 1.0) if done is None else done.last_order
    test, noise = _one_test(sines) if sines else (None, ())
    data = Reduced(rig, tuple(d for d, _ in hits), test, channels, x, last)
    return PlannedRecords(data, (*(noise for _, noise in hits), *noise))


def _one_test(sines: Sequence[tuple[SineData, Real]]) -> tuple[SineData, tuple[Real]]:
    whole = sines[0][0]
    for more, _ in sines[1:]:
        whole = merge_sine_tests(whole, more)
    return whole, (np.concatenate([noise for _, noise in sines]),)


def merge_sine_tests(data: SineData, more: SineData) -> SineData:
    """The blocks of two sine tests at one point and at one rate as those of one test."""
    a, b = data.source, more.source
    rise = SineStartUp(
        *(np.concatenate([getattr(a.rise, f), getattr(b.rise, f)]) for f in SineStartUp.__dataclass_fields__)
    )
    source = replace(
        a,
        lines=np.concatenate([a.lines, b.lines]),
        frequency_hz=np.concatenate([a.frequency_hz, b.frequency_hz]),
        force=np.concatenate([a.force, b.force]),
        rise=rise,
    )
    one, two = data.rows, more.rows
    rows = Rows(
        np.concatenate([one.y, two.y], axis=1),
        np.concatenate([one.sigma, two.sigma], axis=1),
        np.concatenate([one.common, two.common]),
        np.concatenate([one.direction, two.direction], axis=1),
    )
    return replace(data, pieces=(*data.pieces, *more.pieces), source=source, rows=rows)


def _empty_answer(sigma: Real) -> Rows:
    zero = np.zeros(sigma.shape, dtype=np.complex128)
    return Rows(zero, sigma, np.zeros(sigma.shape[1]), zero)


def _planned_hits(
    rig: Rig, plan: ImpactPlan, point: int, weights: Weights, order: float, pulse: HitsAtPoint | None
) -> tuple[ImpactData, Real]:
    n, dt = round(plan.block_s * plan.rate_hz), 1 / plan.rate_hz
    lines = np.arange(1.0, int(IMPACT_BAND * n) + 1)
    if pulse is None or (pulse.n, pulse.dt) != (n, dt):
        force, start = _plain_hit(plan, dt)
    else:
        force, start = pulse.pulses[0], int(pulse.first[0])
    whole = np.zeros(n)
    whole[start : start + len(force)] = force[: n - start]
    F = np.fft.rfft(whole)[1 : len(lines) + 1]
    power = plan.hits * np.abs(F) ** 2
    source = HitsAtPoint(lines, n, dt, np.array([force]), np.array([start]), (F.conj() / np.abs(F) ** 2)[None])
    sigma = weights.sigma(rig, "impact", lines, n, dt) * np.sqrt(n / 2 / power)
    noise = weights.force_noise(rig, "impact") * np.sqrt(len(force) / 2 / power)
    piece = DataPiece(f"impact_p{point:02d}", order, rig.x_of(point), None, ())
    return ImpactData(piece, source, _empty_answer(sigma)), noise


def _plain_hit(plan: ImpactPlan, dt: float) -> tuple[Real, int]:
    before, after = round(BEFORE_S / dt), round(AFTER_S / dt)
    t = np.arange(-before, after) * dt
    pulse = HIT_N * np.where(np.abs(t) < HIT_S / 2, np.cos(np.pi * t / HIT_S), 0.0)
    return pulse, max(0, round(plan.pre_trigger_s * plan.rate_hz) - before)


def _planned_sines(rig: Rig, plan: SinePlan, weights: Weights, order: float) -> tuple[SineData, Real]:
    if rig.shaker_point is None:
        raise PlanError("the plan has a sine test, the rig no shaker point", remedy="add shaker_point to the rig file")
    n, dt = round(plan.block_s * plan.rate_hz), 1 / plan.rate_hz
    offsets = np.arange(-NEIGHBOURS, NEIGHBOURS + 1)
    pairs = [(name, volts, hz) for name, volts in plan.levels_v.items() for hz in plan.frequencies_hz]
    lines = np.array([round(hz * n * dt) + offsets for _, _, hz in pairs], dtype=np.float64)
    newtons = {} if plan.force is None else plan.force.levels_n
    force = np.array([complex(newtons.get(name, volts * N_PER_V)) for name, volts, _ in pairs])
    count = len(pairs)
    yes = np.ones(count, dtype=np.bool_)
    rise = SineStartUp(np.full(count, plan.settle_s), np.full(count, plan.ramp_s), yes, yes)
    source = SineBlocks(lines, np.array([hz for _, _, hz in pairs]), n, dt, force, rise)
    sigma = np.concatenate(
        [weights.sigma(rig, "sine", at, n, dt) * np.sqrt(2 / n) / abs(f) for at, f in zip(lines, force, strict=True)],
        axis=1,
    )
    # Lines below the first are those above it again.
    sigma[:, lines.ravel() == 0] = np.inf
    noise = np.where(offsets == 0, weights.force_noise(rig, "sine") * np.sqrt(2 / n), 0.0) / np.abs(force)[:, None]
    x = rig.x_of(rig.shaker_point)
    pieces = tuple(DataPiece(f"sine_{v}_{hz:.3f}", order + i, x, v, ()) for i, (v, _, hz) in enumerate(pairs))
    return SineData(pieces, source, _empty_answer(sigma), 1.0, GENERATOR), noise.ravel()
