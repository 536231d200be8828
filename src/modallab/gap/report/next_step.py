"""The experiment that would distinguish what this campaign cannot."""

from collections.abc import Sequence

from modallab.core.block import Campaign
from modallab.core.diagnosis import FoundEffect, Verdict
from modallab.gap.model.fit import Fit
from modallab.twin.effects import model_of


def next_experiment(
    verdict: Verdict,
    ranked: list[tuple[Fit, float]],
    campaign: Campaign,
    nonlinear: bool = False,
    seen: Sequence[FoundEffect] = (),
) -> str:
    """One sentence on what to do next.

    Args:
        verdict: of the diagnosis.
        ranked: explanations with their probabilities.
        campaign: the records.
        nonlinear: whether these records show already that the bench does not answer in proportion.
        seen: effects that the records show without any model; the simulation cannot contain them.
    """
    if verdict == "no_gap":
        return "No test is needed: simulation and bench agree to within the noise."
    if verdict == "unknown":
        # What was fitted and explains nothing is no ground for advice.
        return _step_for_unknown(campaign, nonlinear)
    if seen:
        return model_of(seen[0].effect).experiment
    likely = [f for f, p in ranked if p > 0.05 and f.problem.candidates]
    if len(likely) > 1:
        first, second = ({c.effect for c in f.problem.candidates} for f in likely[:2])
        differ = frozenset(first ^ second)
        rivals = [r for name in sorted(differ) for r in model_of(name).rivals]
        separating = [r for r in rivals if r.experiment and r.effect in differ]
        if separating:
            return min(separating, key=lambda r: r.rank).experiment
        return f"Separate {' from '.join(sorted(differ))}: strike at a point where only one of these moves."
    return (
        "Put the effect into the simulation (modallab gap apply) or remove it from the bench, and repeat the campaign."
    )


def _step_for_unknown(campaign: Campaign, nonlinear: bool) -> str:
    levels = {b.level for b in campaign.blocks if b.test == "sine"}
    points = {b.drive_point for b in campaign.blocks if b.test == "impact"}
    if nonlinear:
        return "Repeat the sines at a third level: the growth of the response with the force distinguishes causes."
    if len(levels) < 2:
        return "Repeat the sines at a second level: this tests the linearity of the bench."
    if len(points) < 3:
        return "Strike at more points: a cause in the beam changes the poles, a cause at the hit does not."
    return "Repeat the sines at a third level, and the first hits at the end: level and time distinguish most effects."
