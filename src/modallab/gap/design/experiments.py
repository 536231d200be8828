"""Which experiment separates the explanations that a campaign has left standing, before it is made.

Each experiment is planned beside what has been recorded, once for each explanation as if that were true, and all
explanations are fitted to both. What counts is the probability that the true one then has (Box and Hill, Technometrics
9 (1967), 57), and the time at the bench. The best are looked at again with full fits: slopes know no curvature.
"""

from dataclasses import replace

import numpy as np

from modallab.core.blas_threads import one_thread
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.frozen import Frozen
from modallab.core.plan import Plan
from modallab.core.progress import report_progress
from modallab.gap.design.planning import ExperimentPlanner, RankedExperiment

DECIDES = 0.65
"""Expected probability of the true explanation below which no experiment is said to decide."""
HOUR = 0.05
"""Probability that an hour at the bench must bring."""
LOOKED = 4
"""Experiments that are looked at with full fits, at most."""


class Experiment(Frozen):
    """An experiment that could be made next.

    Attributes:
        name: short.
        says: what to do.
        plans: to be run.
        seconds: what it takes at the bench, about.
        now: probability of the likeliest explanation as the campaign is.
        expected: probability that the true explanation is expected to have with the experiment.
        alone: probability that the true explanation is the only one left then.
        nats: expected logarithm of the likelihoods' ratio of the true explanation to the one nearest to it, on all
            records.
    """

    name: str
    says: str
    plans: tuple[Plan, ...]
    seconds: float
    now: float
    expected: float
    alone: float
    nats: float


@one_thread()
def next_experiments(campaign: Campaign, diagnosis: Diagnosis) -> list[Experiment]:
    """Experiments that would separate what a diagnosis has left standing, the best first.

    Raises:
        PlanError: fewer than two explanations are left standing, or one of them depends on the size of the motion.
        DataError: the campaign holds no record that says what drove it, or the diagnosis not the explanations' numbers.
    """
    report_progress(0.0, "the explanations")
    planning = ExperimentPlanner.of(campaign, diagnosis)
    report_progress(0.3, "experiments")
    found = planning.ranked_by_slopes()
    for k in range(LOOKED):
        # A full fit may take from the best what slopes promised; then the next is the best.
        found.sort(key=_expected_value, reverse=True)
        if not found or found[0].looked:
            break
        report_progress(0.5 + 0.5 * k / LOOKED, f"full fits of {found[0].option.name}")
        found[0] = planning.ranked_by_full_fits(found[0])
    found.sort(key=_expected_value, reverse=True)
    return [_experiment_of_prospect(p) for p in found]


def _expected_value(prospect: RankedExperiment) -> float:
    return prospect.outlook.right - HOUR * prospect.option.duration_s / 3600


def _experiment_of_prospect(prospect: RankedExperiment) -> Experiment:
    option, outlook = prospect.option, prospect.outlook
    return Experiment(
        name=option.name,
        says=option.says,
        plans=option.plans,
        seconds=option.duration_s,
        now=float(np.max(outlook.chances)),
        expected=outlook.right,
        alone=outlook.alone,
        nats=outlook.log_likelihood_ratio,
    )


def continue_campaign(campaign: Campaign, later: Campaign) -> Campaign:
    """A campaign with the records of a later one behind its own, under names that are free."""
    first = 1 + max((b.order for b in campaign.blocks), default=-1)
    taken = {b.name for b in campaign.blocks}
    added = tuple(
        replace(b, order=first + k, name=_free_name(b.name, taken))
        for k, b in enumerate(sorted(later.blocks, key=lambda b: b.order))
    )
    return replace(campaign, blocks=(*campaign.blocks, *added))


def _free_name(name: str, taken: set[str]) -> str:
    number = 2
    free = name
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    taken.add(free)
    return free
