"""Where the rig file and the records contradict each other, in words for who wrote the rig file.

The common factor of all frequencies by the least sum of absolute deviations up to a bound (Hampel et al., Robust
Statistics, 1986).
"""

from collections.abc import Sequence

import numpy as np

from modallab.core.arrays import Real
from modallab.core.block import Campaign
from modallab.core.diagnosis import FoundEffect, Verdict
from modallab.core.digits import percent_text, relative_change
from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.model.fit import Fit
from modallab.gap.search.choose import Selection
from modallab.twin.effects import model_of
from modallab.twin.modes import solve_modes

PULLED = 2.5
"""Deviations from which a sensitivity is worth a word, though within what the rig file allows."""
FAR = 5.0
"""Deviations of its tolerance at which a beam is another beam."""
CLOSE = 0.02
"""Relative deviation at which a frequency still counts as that of a mode."""


def contradiction_sentences(choice: Selection, prepared: PreparedCampaign) -> list[str]:
    """One sentence for each: a beam far off its tolerance, and sensitivities that had to move far within theirs."""
    sentences = _beam_contradiction(choice, prepared)
    return sentences or (_gain_contradiction(choice, prepared) if choice.explained else [])


def _beam_contradiction(choice: Selection, prepared: PreparedCampaign) -> list[str]:
    if choice.explained or len(prepared.poles) < 3:
        return []
    free = choice.base.problem.free
    nominal = np.abs(solve_modes(free.build(np.zeros(free.size)).structure).poles)
    shift, share = common_frequency_shift(np.abs(prepared.poles), nominal)
    t = free.rig.tolerance
    allowed = 0.5 * float(np.sqrt(t.youngs_modulus**2 + (2 * t.thickness) ** 2 + t.density**2))
    if share < 0.99 or abs(shift) < FAR * allowed:
        return []
    return [
        f"All frequencies of the ring-down lie {relative_change(np.expm1(shift))} off those of the rig file's "
        "beam, and its "
        f"tolerances allow {percent_text(allowed)}: first check length, thickness and material in the rig file."
    ]


def common_frequency_shift(seen: Real, model: Real) -> tuple[float, float]:
    """The factor, as a logarithm, that brings the model's frequencies to those seen, and the share that then agree.

    Args:
        seen: (n,) frequencies, any unit.
        model: (m,) frequencies of the modes in the same unit.
    """
    shifts = np.linspace(-1.6, 1.6, 1601)
    distance = np.min(np.abs(np.log(seen)[:, None, None] - np.log(model)[None, :, None] - shifts), axis=1)
    cost = np.sum(np.minimum(distance, 5 * CLOSE), axis=0)
    best = int(np.argmin(cost + 1e-6 * np.abs(shifts)))
    return float(shifts[best]), float(np.mean(distance[:, best] < CLOSE))


def _gain_contradiction(choice: Selection, prepared: PreparedCampaign) -> list[str]:
    fit, rig = choice.fit, prepared.campaign.rig
    free = fit.problem.free
    factors = free.bare(fit.u[: free.size]).chain.gain
    return [
        f"{rig.channels[channel].name} reads {relative_change(factor - 1)} against its sensitivity, "
        f"{abs(np.log(factor)) / free.tolerance:.1f} deviations of the rig file's tolerance: calibrate this channel."
        for channel, factor in factors.items()
        if abs(np.log(factor)) > PULLED * free.tolerance
    ]


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
