"""Experiments beside what has been recorded, as the fits of each explanation would see them."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Self

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.plan import ImpactPlan, Plan, SinePlan
from modallab.gap.conditioning.records import every_third
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.design.explanations import (
    Explanation,
    RecordsSoFar,
    fit_explanations,
    prepared_with_later_records,
    undecided_explanations,
)
from modallab.gap.design.information import (
    ExpectedOutcome,
    RivalExplanations,
    expected_outcome,
    predicted_differences,
    residuals_after_refit,
    residuals_between_explanations,
)
from modallab.gap.design.options import (
    HITS,
    MOST_OF_LIMIT,
    PossibleExperiment,
    limit_force,
    plans_of,
    possible_experiments,
    sines_on_all_lines,
)
from modallab.gap.design.planned import PlannedRecords, join_planned, merge_sine_tests, records_of_plan
from modallab.gap.model.fit import Fit, Problem, fit_at, with_relative_noise
from modallab.gap.model.minimise import minimise
from modallab.gap.search.best_place import at_best_place
from modallab.twin.bench import Twin
from modallab.twin.response import HitsAtPoint

CHOSEN = 9
"""Sines at frequencies where the explanations differ most."""
BESIDE = 3
"""Of the best experiments, how many are planned together, two and two."""
STEPS = 6
"""Evaluations of the slopes of a full fit."""
UNPROVEN = 0.003
"""Relative error of the twin in a test that was not made before."""
LONGEST = 4.0
"""Coordinates that slopes may lead away from a fit."""


@dataclass(frozen=True, eq=False, slots=True)
class RankedExperiment:
    """An experiment, and what it is expected to bring.

    Attributes:
        option: what would be done.
        layout: the records that a fit would see.
        gram: products of the explanations' slopes and answers on them.
        outlook: what they are expected to bring.
        looked: whether full fits say so; else slopes.
    """

    option: PossibleExperiment
    layout: PlannedRecords
    gram: Real
    outlook: ExpectedOutcome
    looked: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class ExperimentPlanner:
    """What experiments are planned with.

    Attributes:
        there: what is recorded.
        done: as plans.
        rivals: the explanations left standing.
        listed: what could be done, of one kind each.
    """

    there: RecordsSoFar
    done: tuple[Plan, ...]
    rivals: RivalExplanations
    listed: tuple[PossibleExperiment, ...]

    @classmethod
    def of(cls, campaign: Campaign, diagnosis: Diagnosis) -> Self:
        """What is planned with beside a campaign; errors as of `next_experiments`."""
        sets, there, done = undecided_explanations(diagnosis), prepared_with_later_records(campaign), plans_of(campaign)
        rig = there.prepared.campaign.rig
        listed = possible_experiments(rig, done, diagnosis.gap.poles_hz)
        struck = [p for o in listed for plan in o.plans if isinstance(plan, ImpactPlan) for p in plan.points]
        rivals = fit_explanations(sets, there, [(rig.x_of(p), HITS) for p in struck])
        return cls(there, tuple(done), RivalExplanations.of(rivals), tuple(listed))

    def ranked_by_slopes(self) -> list[RankedExperiment]:
        """Every experiment by slopes, and the best of them two and two."""
        found = [self._prospect(o) for o in self.listed]
        chosen = self._chosen()
        found += [] if chosen is None else [self._prospect(chosen)]
        best = sorted(found, key=lambda p: -p.outlook.right)[:BESIDE]
        return [*found, *(self._both(a, b) for a, b in combinations(best, 2))]

    def ranked_by_full_fits(self, prospect: RankedExperiment) -> RankedExperiment:
        """The same by full fits of every explanation to what every other one would answer."""
        listed = self.rivals.listed
        nonlinear = np.zeros((len(listed), len(listed)))
        for true, rival in enumerate(listed):
            joint = _join_data(self.there.data, self._answered(prospect.layout, rival))
            straight = residuals_after_refit(self.rivals, prospect.gram, true)
            for k, other in enumerate(listed):
                problem, (squares, end) = replace(other.fit.problem, data=joint), straight[k]
                nonlinear[true, k] = _least_squares_left(problem, other.fit, end, rival.fit) - squares
        expected = expected_outcome(self.rivals, prospect.gram, nonlinear)
        return replace(prospect, outlook=expected, looked=True)

    def _prospect(self, option: PossibleExperiment) -> RankedExperiment:
        option = replace(option, plans=tuple(self._within_limits(plan) for plan in option.plans))
        layout = join_planned([self._laid_out(self._fitted(plan)) for plan in option.plans])
        columns = self._columns(layout)
        gram = columns.T @ columns
        return RankedExperiment(option, layout, gram, expected_outcome(self.rivals, gram))

    def _laid_out(self, plan: Plan) -> PlannedRecords:
        data = self.there.data
        hits = next((d.source for d in data.impacts if isinstance(d.source, HitsAtPoint)), None)
        return records_of_plan(data.rig, [plan], self.there.weights, hits, data)

    def _columns(self, layout: PlannedRecords) -> Real:
        # The force's noise lies along the answer, which is nearly the same of all that are left standing.
        return predicted_differences(self.rivals, self._answered(layout, self.rivals.listed[0]))

    def _answered(self, layout: PlannedRecords, rival: Explanation) -> Reduced:
        """What an explanation answers; of a test that was not made before nobody knows how exact the twin is in it."""
        data, done = layout.predicted_by(_twin_of_rival(rival)), self.there.data
        if not done.impacts:
            data = replace(
                data, impacts=tuple(replace(d, rows=with_relative_noise(d.rows, UNPROVEN)) for d in data.impacts)
            )
        if done.sines is None and data.sines is not None:
            data = replace(data, sines=replace(data.sines, rows=with_relative_noise(data.sines.rows, UNPROVEN)))
        return data

    def _within_limits(self, plan: Plan) -> Plan:
        """The same no louder than the likeliest explanation lets the sensors move within the rig's limits."""
        rig = self.there.data.rig
        if (
            not isinstance(plan, SinePlan)
            or rig.limits is None
            or any(c.quantity != "acceleration" for c in rig.responses)
        ):
            return plan
        sines = self._laid_out(plan).predicted_by(_twin_of_rival(self.rivals.listed[0])).sines
        assert sines is not None
        return limit_force(plan, MOST_OF_LIMIT * rig.limits.acceleration_m_s2 / float(np.max(np.abs(sines.rows.y))))

    def _fitted(self, plan: Plan) -> Plan:
        """What of a plan a fit would see."""
        if isinstance(plan, ImpactPlan):
            return plan.model_copy(update={"hits": plan.hits - len(every_third(range(plan.hits), 2))})
        assert isinstance(plan, SinePlan)
        before = {f for p in self.done if isinstance(p, SinePlan) for f in p.frequencies_hz}
        held = set(every_third(sorted(before | set(plan.frequencies_hz)), 1))
        kept = tuple(f for f in plan.frequencies_hz if f not in held)
        return plan.model_copy(update={"frequencies_hz": kept or plan.frequencies_hz})

    def _both(self, one: RankedExperiment, two: RankedExperiment) -> RankedExperiment:
        a, b = one.option, two.option
        option = PossibleExperiment(f"{a.name}, {b.name}", f"{a.says} {b.says}", (*a.plans, *b.plans))
        return self._prospect(option)

    def _chosen(self) -> PossibleExperiment | None:
        """Sines at the frequencies where the two likeliest explanations differ most, once both are fitted."""
        rig = self.there.prepared.campaign.rig
        if rig.shaker_point is None:
            return None
        plan = sines_on_all_lines(rig, self.done)
        layout = self._laid_out(plan)
        best = np.sort(np.argsort(-self._apart_by_sine(layout))[:CHOSEN])
        kept = plan.model_copy(update={"frequencies_hz": tuple(plan.frequencies_hz[k] for k in best)})
        return PossibleExperiment(
            "sines where the explanations differ", f"Drive {CHOSEN} frequencies where the explanations differ.", (kept,)
        )

    def _apart_by_sine(self, layout: PlannedRecords) -> Real:
        """(sines,) squares that the likeliest explanation's answers leave of the next."""
        assert layout.data.sines is not None
        sines, channels = layout.data.sines.source.lines, len(layout.data.channels)
        left = residuals_between_explanations(self.rivals, self._columns(layout))[: 2 * channels * sines.size]
        return np.sum(left.reshape(2 * channels, *sines.shape) ** 2, axis=(0, 2))


def _twin_of_rival(rival: Explanation) -> Twin:
    return rival.fit.problem.twin(rival.fit.u)


def _least_squares_left(problem: Problem, fit: Fit, end: Real, other: Fit) -> float:
    """Least squares that an explanation leaves, from its own numbers, where slopes lead, and beside another's twin."""
    own = problem.free.size
    begins = (fit.u, np.clip(end, fit.u - LONGEST, fit.u + LONGEST), np.concatenate([other.u[:own], fit.u[own:]]))
    first = min((fit_at(problem, u) for u in begins), key=lambda f: f.cost)
    best = min([first, *(minimise(problem, u, STEPS, 1e-4) for u in (first.u, fit.u))], key=lambda f: f.cost)
    # What is true is where it is; what is not may follow it from any other place.
    return best.cost if fit is other else at_best_place(best).cost


def _join_data(data: Reduced, more: Reduced) -> Reduced:
    """Records that are there and planned ones."""
    if data.sines is None or more.sines is None:
        sines = data.sines or more.sines
    else:
        sines = merge_sine_tests(data.sines, more.sines)
    return replace(data, impacts=(*data.impacts, *more.impacts), sines=sines)
