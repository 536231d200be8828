"""A law that is known by its overtones, where a linear beam within its tolerances follows the sines themselves.

Nothing linear makes overtones (Worden and Tomlinson, Nonlinearity in Structural Dynamics, 2001, ch. 3): a law that
makes them on records it has not seen is named, though what it does at the sines' own frequencies a tolerance could do.
"""

from dataclasses import replace

from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.evidence import explains
from modallab.gap.inference.select import Level
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.share import largest_difference, unexplained
from modallab.gap.search.choose import Choice, effect_names, has_stepped_law
from modallab.gap.search.fitting import Bench
from modallab.gap.search.overtone_check import overtones_closed
from modallab.gap.search.rough_fit import beam_of_hits

OVERTONE_SHARE = 0.8
"""Share of the overtones, on records it has not seen, that a law must make to be named for them alone."""


def named_by_overtones(
    bench: Bench, choice: Choice, levels: list[Level], prepared: PreparedCampaign, unseen: Reduced
) -> Choice:
    """The choice with the law that makes the overtones, where a beam within its tolerances follows the lines as well.

    Args:
        bench: what was searched.
        choice: what the rounds say.
        levels: the rounds; the last may have found such a law.
        prepared: the records.
        unseen: records that no fit has seen.
    """
    if (choice.explained and choice.tolerated is None) or not levels or not levels[-1].fits:
        return choice
    fit = levels[-1].fits[0]
    if (
        not has_stepped_law(fit)
        or not explains(fit)
        or not _matters(fit, unseen)
        or overtones_closed(fit, prepared, unseen) < OVERTONE_SHARE
    ):
        return choice
    others = tuple(f for f in (*levels[-1].fits[1:], *choice.rivals) if effect_names(f) != effect_names(fit))
    best = min(fit, beam_of_hits(bench, fit), key=lambda f: f.cost)
    return Choice(levels[0].base, best, others, True, False)


def _matters(fit: Fit, unseen: Reduced) -> bool:
    """Whether its law moves the response by more than the tolerance, and what is left of sines without a name does not.

    A hit runs through every state of the law, and no law that is a little off follows it.
    """
    least, sines = unseen.rig.tolerance.response, replace(unseen, impacts=())
    if unexplained(sines, forward(twin_of(fit, sines), sines)) >= least:
        return False
    twin = twin_of(fit, unseen)
    return largest_difference(unseen, forward(twin, unseen), forward(replace(twin, element=None), unseen)) >= least
