"""Whether an element without a name explains a gap better than effects that have one.

A beam that is pulled, that carries a mass on a spring or that twists is far from any beam of the catalogue, and effects
put together approach it as polynomials approach a curve: the more of them, the less is left, and none of them is there.
A channel that loses samples reads as one whose gain is too small, with noise on it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from modallab.gap.conditioning.prepare import PreparedCampaign
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.agreement import Agreement
from modallab.gap.inference.evidence import evidence, evidence_without_name
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.search.choose import Selection
from modallab.gap.search.fitting import Bench, search_origin, within_tolerances
from modallab.gap.unknown.description import Description, cost_per_number, description_of, rows_of
from modallab.gap.unknown.fitted import best_fits, converged_fits, forgiven_error, short_fits
from modallab.gap.unknown.on_beam import forces_along_beam, operators_on_all_channels
from modallab.gap.unknown.on_row import fit_without_channel, linear_operators, sample_operators
from modallab.gap.unknown.spare_poles import trials_at_spare_poles


@dataclass(frozen=True, eq=False, slots=True)
class LoneChannel:
    """A channel that is off where all others agree with a sound bench.

    Attributes:
        row: the channel.
        fit: the twin as the other channels have it.
        loses: whether it loses samples, as its records show.
    """

    row: int
    fit: Fit
    loses: bool


def loses_samples(prepared: PreparedCampaign, fit: Fit) -> bool:
    """Whether an effect of a fit stands on a channel that repeats or loses samples, as its records show."""
    return any(row in rows_of(fit) for row in prepared.repeated)


def lone_channel(
    bench: Bench, prepared: PreparedCampaign, agreement: Agreement, held: Sequence[str]
) -> LoneChannel | None:
    """The channel without which there is no gap, if there is one.

    Args:
        bench: what is searched.
        prepared: the campaign.
        agreement: of the twin without effects with it.
        held: records that no fit may see.
    """
    if len(bench.data.channels) < 2:
        return None
    fitted = [b for b in prepared.blocks if b.name not in set(held)]
    for row in prepared.repeated or _differing_channel(bench, agreement):
        alone = fit_without_channel(bench, prepared, fitted, row)
        if alone.gap <= bench.flat and within_tolerances(alone):
            return LoneChannel(row, alone, bool(prepared.repeated))
    return None


def unnamed_explanations(
    bench: Bench,
    prepared: PreparedCampaign,
    named: Selection,
    alone: LoneChannel | None,
    unseen: Reduced,
    held: Sequence[str],
) -> tuple[Description, ...]:
    """What explains the gap and is more probable than effects with a name, best first; nothing where nothing does.

    Args:
        bench: what is searched.
        prepared: the campaign.
        named: what effects of the catalogue explain.
        alone: the channel that is off alone, if there is one.
        unseen: records that no fit has seen.
        held: their names.
    """
    base, best = named.base, named.fit
    begin = search_origin(bench, base)
    if alone is None:
        return _on_beam(bench, begin, best, unseen)
    found = sorted(sample_operators(bench, prepared, alone.fit, held, alone.row), key=cost_per_number)
    if alone.loses and unnamed_evidence(found[0]) < evidence_without_name(base):
        # Lost samples are visible in the record itself: no effect explains them.
        return tuple(found)
    operators = best_fits(bench, begin, list(linear_operators(bench, alone.row)), 1)
    found = sorted([*found, *(description_of(fit, unseen, (alone.row,)) for fit in operators)], key=cost_per_number)
    return tuple(found) if _explains(found[0], best) else ()


def _differing_channel(bench: Bench, agreement: Agreement) -> list[int]:
    """The channel that differs, if the modes and all other channels agree."""
    if len(agreement.differing) != 1 or agreement.modes_differ:
        return []
    return [row for row in bench.data.channels if bench.data.rig.channels[row].name in agreement.differing]


def _on_beam(bench: Bench, begin: Fit, best: Fit, unseen: Reduced) -> tuple[Description, ...]:
    """Elements in the structure or on all channels."""
    trials = [*trials_at_spare_poles(bench, begin), *forces_along_beam(bench), *operators_on_all_channels(bench)]
    looks = short_fits(bench, begin, trials)
    if not looks or looks[0].cost >= _cost_of_short_fit(bench, begin, best):
        return ()
    found = sorted((description_of(fit, unseen) for fit in converged_fits(bench, begin, looks)), key=cost_per_number)
    return tuple(found) if _explains(found[0], best) else ()


def _cost_of_short_fit(bench: Bench, begin: Fit, best: Fit) -> float:
    """What the best effect leaves where as much is forgiven as at a look at an element."""
    held = (float(best.u[0]), float(best.u[1]), float(best.u[2]))
    return fit_at(
        Problem(bench.thin, bench.free, best.problem.candidates, forgiven_error(begin), held=held), best.u
    ).cost


def unnamed_evidence(one: Description) -> float:
    """-2 log evidence of a description."""
    return float(evidence([one.fit])[0]) + _price_beside_fitted(one)


def _price_beside_fitted(one: Description) -> float:
    """What its fit does not count: an element stands for any of many causes, and costs two effects."""
    return DEFAULT.effect_price * (2 * len(one.learned) - len(one.fit.problem.candidates))


def _explains(one: Description, best: Fit) -> bool:
    """Whether a description explains the gap and is more probable than the best explanation that has a name."""
    named, nameless = evidence([best, one.fit])
    more_probable = bool(nameless + _price_beside_fitted(one) < named)
    return more_probable and unnamed_evidence(one) < evidence_without_name(one.fit)
