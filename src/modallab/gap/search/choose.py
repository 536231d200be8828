"""From the rounds of a search to what is judged present, how surely, and the verdict.

Effects are dropped one by one as in backward elimination (Draper and Smith, Applied Regression Analysis, 1998).
"""

from dataclasses import dataclass, replace

import numpy as np

from modallab.core.arrays import Real
from modallab.core.effects import kind_of
from modallab.gap.conditioning.rows import Reduced
from modallab.gap.inference.select import Level
from modallab.gap.inference.settings import DEFAULT
from modallab.gap.model.fit import Fit
from modallab.gap.model.forward import forward
from modallab.gap.model.own_numbers import twin_of
from modallab.gap.model.share import discrepancies, unexplained
from modallab.gap.search.clock import clock_error_visible
from modallab.gap.search.consequence import Dismissed, of_consequence
from modallab.gap.search.fitting import (
    Bench,
    each_within_tolerance,
    excess,
    refitted_without,
    temperature_of,
    within_tolerances,
)
from modallab.twin.effects import search_of

CLOSED = 0.998
"""Share of the excess an explanation must close to count as one, where it does not reach the floor."""
CLOSED_RESAMPLED = 0.98
"""The same where samples were taken at other times than stated: no bench and no twin resamples without an error."""
CLOSED_STEPPED = 0.9
"""The same of an effect that depends on the size of the motion, on records no fit has seen: no bench's law is quite the
twin's, and what it leaves is stated as discrepancy."""
COUNTS = 20.0
"""Independent numbers that the records count for at least beside such an effect, however wrong its law is."""
AT_FLOOR = 1.15
"""Rms residual that counts as the floor."""

HOLDS = 0.15
"""Share of the gap that an effect which is stepped in time may leave."""
PLAIN = 1000.0
"""Squares of noise units that a small effect must take away: on sound benches some model takes up to 250."""
PLAIN_LEAVES = 0.1
"""Share of a small gap that it may leave."""


@dataclass(frozen=True, eq=False, slots=True)
class Choice:
    """What the search says.

    Attributes:
        base: the twin without effects.
        fit: the twin with those judged present; `base` if there are none.
        rivals: other explanations that were fitted to the end, best first.
        explained: whether nothing structured is left.
        flat: whether there was nothing to explain.
        dismissed: effects that explain something, but are within tolerance or of no consequence.
        tolerated: share of the response that no effect explains and that the rig file tolerates; None where all of the
            gap is explained, or where it exceeds the tolerance.
    """

    base: Fit
    fit: Fit
    rivals: tuple[Fit, ...]
    explained: bool
    flat: bool
    dismissed: tuple[Dismissed, ...] = ()
    tolerated: float | None = None

    @property
    def accepted_fit(self) -> Fit:
        """The twin with what is judged present: what does not explain the gap is none of it."""
        return self.fit if self.explained else self.base


def choose(bench: Bench, levels: list[Level], held: Reduced | None = None, unseen: Reduced | None = None) -> Choice:
    """Keep the effects without which the gap comes back, and say whether they explain it.

    Args:
        bench: what was searched.
        levels: the rounds.
        held: records that no fit has seen, where what does not matter there is no gap: on a rig that states how well it
            is put together.
        unseen: records that no fit has seen, where effects that depend on the size of the motion were looked for.
    """
    base = levels[0].base
    plain = base.gap <= bench.flat and (within_tolerances(base) or not bench.free.deviations)
    if plain and not _small_but_plain(levels) and not _clock_alone(bench, levels):
        return Choice(base, base, (), True, True)
    chain = [base, *(level.fits[0] for level in levels if level.fits)]
    while len(chain) > 1 and not _stays(chain[-2], chain[-1], unseen):
        chain.pop()
    fit = chain[-1]
    rivals = sorted((f for level in levels for f in level.fits), key=lambda f: f.cost)
    others = tuple(f for f in rivals if effect_names(f) != effect_names(fit))
    resampled = any(kind_of(c.effect).stage == "acquisition" for c in fit.problem.candidates)
    needed = CLOSED_RESAMPLED if resampled else CLOSED
    explained = bool(fit.problem.candidates) and (
        fit.gap <= AT_FLOOR * bench.flat / 1.1
        or excess(fit) <= (1 - needed) * excess(base)
        or (held is not None and _closes(base, fit, held, needed))
        or (unseen is not None and has_stepped_law(fit) and _closes_unseen(_without_law(fit), fit, unseen))
    )
    choice = Choice(base, fit, others, explained, False)
    return _most_probable(choice if held is None else _that_matters(choice, held, clock_error_visible(bench)))


def _most_probable(choice: Choice) -> Choice:
    """The same with the explanation that is the most probable of all: an effect less than even odds have is none."""
    best = probabilities(choice)[0][0]
    if choice.flat or not choice.explained or best is choice.fit or not best.problem.candidates:
        return choice
    return replace(choice, fit=best, rivals=(choice.fit, *(f for f in choice.rivals if f is not best)))


def _closes(base: Fit, fit: Fit, held: Reduced, needed: float) -> bool:
    """Whether a fit leaves nothing that matters of the response, and closes as much of that as must be of the gap.

    In noise units what is left is mostly that of the resonances with the best signal; where samples were interpolated
    it is a few images of them, thousands of times below the response and far above the noise.
    """
    before, after = (unexplained(held, forward(twin_of(f, held), held)) for f in (base, fit))
    return after < held.rig.tolerance.response and after**2 <= (1 - needed) * before**2


def _stays(before: Fit, fit: Fit, unseen: Reduced | None) -> bool:
    """Whether the last effect of a fit stays: a linear one earns its price; a law that is stepped must explain."""
    if not has_stepped_law(fit):
        return before.cost - fit.cost >= DEFAULT.effect_price * temperature_of(excess(fit))
    if kind_of(fit.problem.candidates[-1].effect).linear and not earns_beside_law(before, fit):
        return False
    bare = _without_law(fit)
    return excess(fit) <= HOLDS * excess(bare) or (unseen is not None and _closes_unseen(bare, fit, unseen))


def earns_beside_law(before: Fit, fit: Fit) -> bool:
    """Whether a linear effect is worth its price, -2 log evidence, where a law is there that may be wrong."""
    return COUNTS * np.log(before.cost / fit.cost) >= DEFAULT.effect_price


def _without_law(fit: Fit) -> Fit:
    """The fit without its effect that is stepped in time: a law may be wrong by a share of what it does itself."""
    return refitted_without(fit, next(k for k, c in enumerate(fit.problem.candidates) if not kind_of(c.effect).linear))


def _closes_unseen(base: Fit, fit: Fit, unseen: Reduced) -> bool:
    """Whether a fit closes enough of records it has not seen, in noise units or with each record counted alike.

    In noise units a hit through every state of a law outweighs all sines, and no law that is a little off follows it:
    of records that count alike only the sines are compared.
    """
    if _share_closed(base, fit, unseen) >= CLOSED_STEPPED:
        return True
    if unseen.sines is not None:
        unseen = replace(unseen, impacts=())
    before, after = (_mean_square(f, unseen) for f in (base, fit))
    return after <= (1 - CLOSED_STEPPED) * before


def _mean_square(fit: Fit, data: Reduced) -> float:
    """Mean over records of what a fit leaves besides noise, as a share of the response's squares, at most all of it."""
    found = discrepancies(data, forward(twin_of(fit, data), data))
    return float(np.mean([min(v**2, 1.0) for v in found.values()])) if found else 1.0


def _share_closed(base: Fit, fit: Fit, unseen: Reduced) -> float:
    """Share of the gap above the floor that a fit closes on records no fit has seen."""
    before, after = (_rms_on(f, unseen) for f in (base, fit))
    return 1 - (after**2 - 1) / max(before**2 - 1, 1e-9)


def _rms_on(fit: Fit, data: Reduced) -> float:
    twin = twin_of(fit, data)
    r = replace(fit.problem, data=data).residual_of(twin, forward(twin, data))
    return float(np.sqrt(np.mean(r[r != 0] ** 2)))


def has_stepped_law(fit: Fit) -> bool:
    """Whether an effect of a fit depends on the size of the motion."""
    return any(not kind_of(c.effect).linear for c in fit.problem.candidates)


def _that_matters(choice: Choice, held: Reduced, shown: bool) -> Choice:
    """The same without what is within tolerance or of no consequence; `shown` says whether lines show a wrong clock."""
    left = unexplained(held, forward(twin_of(choice.base, held), held))
    unnamed = not choice.explained and each_within_tolerance(choice.base)
    clocked = (
        shown
        and choice.explained
        and any(search_of(c.effect).tolerance.is_clock for c in choice.fit.problem.candidates)
    )
    if left < held.rig.tolerance.response and (within_tolerances(choice.base) or unnamed) and not clocked:
        # Nothing has a name, no number alone is beyond its tolerance, and nothing that matters is left to name.
        tolerated = None if choice.explained else left
        return Choice(choice.base, choice.base, choice.rivals, True, True, tolerated=tolerated)
    if not choice.explained:
        return choice
    fit, dismissed = of_consequence(choice.fit, held, shown)
    if not fit.problem.candidates:
        # An effect of next to nothing may have shown the way to a twin without effects that fits better.
        base = min(choice.base, fit, key=lambda f: f.cost)
        return Choice(base, base, choice.rivals, True, True, tuple(dismissed))
    return replace(choice, fit=fit, dismissed=tuple(dismissed))


def _small_but_plain(levels: list[Level]) -> bool:
    """Whether one effect takes nearly all of a small gap away, by far more than the model's own error could."""
    if not levels[0].fits:
        return False
    base, best = levels[0].base, levels[0].fits[0]
    return base.cost - best.cost > PLAIN and excess(best) < PLAIN_LEAVES * excess(base)


def _clock_alone(bench: Bench, levels: list[Level]) -> bool:
    """Whether the lines show a wrong clock that begins the rounds: a beam within its tolerances follows it unseen."""
    first = levels[0].fits[0].problem.candidates if levels[0].fits else ()
    return clock_error_visible(bench) and any(search_of(c.effect).tolerance.is_clock for c in first)


def effect_names(fit: Fit) -> tuple[str, ...]:
    """The effects of a fit, sorted."""
    return tuple(sorted(c.effect for c in fit.problem.candidates))


def probabilities(choice: Choice) -> list[tuple[Fit, float]]:
    """The explanations, each with its probability, best first.

    Weights are exp(-n / 2 ln(cost) / T - 3 k), normalised over the explanations: n residuals, k effects. With T = 1
    the first term is the Gaussian likelihood with the noise's size profiled out (Seber and Wild, Nonlinear Regression,
    1989), and 3 k a price for each effect as in information criteria (Schwarz, Ann. Stat. 6, 1978, 461; Burnham and
    Anderson, Model Selection and Multimodel Inference, 2002), here a constant. The temperature T = 2 + 100 x the excess
    of the best explanation flattens the weights, as in temperature scaling (Guo, Pleiss, Sun and Weinberger, "On
    calibration of modern neural networks", ICML 2017): where the best explanation stays above the floor, the model
    itself is wrong by that much, so that margins count for less; where it is a law of the motion's size, the records
    still count for COUNTS numbers. The constants 2, 100, 3 and COUNTS are this project's own.
    """
    fits: dict[tuple[str, ...], Fit] = {effect_names(choice.fit): choice.fit}
    for fit in choice.rivals:
        fits.setdefault(effect_names(fit), fit)
    ordered = list(fits.values())
    n = float(np.count_nonzero(choice.fit.residual))
    temperature = temperature_of(excess(choice.fit))
    if has_stepped_law(choice.fit):
        temperature = min(temperature, n / COUNTS)
    shares = probabilities_of(
        np.array([f.cost for f in ordered]), np.array([len(f.problem.candidates) for f in ordered]), n, temperature
    )
    return sorted(zip(ordered, shares.tolist(), strict=True), key=lambda pair: -pair[1])


def probabilities_of(costs: Real, effects: Real, n: float, temperature: float | Real) -> Real:
    """(..., explanations) probabilities of explanations, see `probabilities`.

    Args:
        costs: (..., explanations) squares that each leaves.
        effects: (explanations,) how many each has.
        n: residuals.
        temperature: T.
    """
    scores = -0.5 * n * np.log(np.maximum(costs, 1.0)) / temperature - 3.0 * effects
    weights = np.exp(scores - np.max(scores, axis=-1, keepdims=True))
    return weights / np.sum(weights, axis=-1, keepdims=True)
