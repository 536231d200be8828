"""Effects added, exchanged and deleted one by one, all candidates of a round against each other by evidence.

Stepwise selection with successive halving (Jamieson and Talwalkar, AISTATS 2016, 240): many starts get a few steps, the
better half goes on, the best are fitted to the records.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.progress import report_progress
from modallab.gap.inference.evidence import explains, more_probable
from modallab.gap.inference.posterior import Key, Posterior, key_of, maximise_posterior
from modallab.gap.inference.score_test import ScoreTest
from modallab.gap.inference.screen import GridStart, Screen
from modallab.gap.inference.settings import DEFAULT, Settings
from modallab.gap.inference.view import RowModel, sparse
from modallab.gap.model.candidates import beam_candidates, channel_candidates, has_needed_tests, pair_candidates
from modallab.gap.model.fit import Fit, Problem, fit_at
from modallab.gap.search.clock import clock_error_visible
from modallab.gap.search.fitting import Bench, converged_fit, within_tolerances, without_effect
from modallab.twin.candidate import CandidateEffect
from modallab.twin.effects import model_of, search_of

Array = NDArray[np.float64]

HALVING = ((3, 6), (2, 3), (10, 3))
"""Evaluations of the slopes in each stage, and how many go on; the first stage takes the nuisances' from the screen."""


@dataclass(frozen=True, eq=False, slots=True)
class SearchRound:
    """One round of a search.

    Attributes:
        base: the fit it began from.
        fits: the fits that were finished, best first.
    """

    base: Fit
    fits: tuple[Fit, ...]


class StepwiseSelection:
    """Rounds of linear effects beside what a bench is believed to be."""

    def __init__(self, bench: Bench, base: Fit, settings: Settings = DEFAULT) -> None:
        """Begin without effects.

        Args:
            bench: what to search.
            base: the twin without further effects, fitted to the records.
            settings: of the inference.
        """
        self.bench, self.settings = bench, settings
        self.levels: list[SearchRound] = []
        self.best = base
        self._view, self._coarse = (RowModel.of(bench.points, d, settings) for d in (bench.thin, sparse(bench.thin)))
        problem = Problem(bench.data, bench.free, base.problem.candidates)
        self._here = maximise_posterior(self._view, problem, base.u, 12)
        self.finished = base.gap <= bench.flat and self._sound(base)

    def rounds(self, most: int | None = None) -> list[SearchRound]:
        """All levels after at most so many rounds in all, fewer where one more makes no explanation more probable."""
        most = self.settings.most_effects if most is None else most
        while not self.finished and len(self.levels) < most:
            self._round()
        return self.levels or [SearchRound(self.best, ())]

    def _round(self) -> None:
        self._progress(0.0, "candidates screened")
        found = [self._pruned(f) for f in self._with_one_more(self._here)]
        if not self.levels:
            found += [maximise_posterior(self._view, self._problem(p.candidates), u, 10) for p, u in self.bench.known]
        found = [f for f in _best_of_each(found) if f.key != self._here.key][: self.settings.rivals]
        self._progress(0.7, "explanations fitted to the records")
        fitted: list[tuple[Posterior, Fit]] = []
        for f in found:
            # Beside one that leaves only noise, one that the modal rows call that much less probable is no rival.
            if self._explained(fitted) and f.evidence > fitted[0][0].evidence + self.settings.effect_price:
                break
            fitted.append((f, self._fit(f.problem.candidates, f.u)))
        if not self._explained(fitted):
            fitted += self._by_records({f.key for f in found})
        if fitted and not self._explained(fitted):
            fitted += self._exchanged(min(fitted, key=_score), {f.key for f, _ in fitted})
        fitted.sort(key=_score)
        if not fitted or self._ends(*fitted[0]):
            self.finished = True
            return
        self.levels.append(SearchRound(self.best, tuple(fit for _, fit in fitted)))
        self._here, self.best = fitted[0]
        self.finished = self.best.gap <= self.bench.flat and self._sound(self.best)

    def _ends(self, posterior: Posterior, fit: Fit) -> bool:
        """Whether a round that has come to this ends the search, as nothing more probable is there.

        While the gap is not explained another effect may be missing yet, beside which this one will be more probable:
        then it has to gain its price under noise alone.
        """
        if more_probable(fit, self.best):
            return False
        return (
            explains(self.best)
            or _score((posterior, fit)) > _score((self._here, self.best)) - self.settings.effect_price
        )

    def _explained(self, fitted: list[tuple[Posterior, Fit]]) -> bool:
        """Whether one of these leaves nothing but noise: no other can explain more."""
        return any(fit.gap <= self.bench.flat and self._sound(fit) for _, fit in fitted)

    def _sound(self, fit: Fit) -> bool:
        """Whether beam and assembly are within tolerance, and the generator's lines show no other clock."""
        clocked = any(search_of(c.effect).tolerance.is_clock for c in fit.problem.candidates)
        return within_tolerances(fit) and (clocked or not clock_error_visible(self.bench))

    def _problem(self, candidates: tuple[CandidateEffect, ...]) -> Problem:
        return Problem(self.bench.data, self.bench.free, candidates)

    def _fit(self, candidates: tuple[CandidateEffect, ...], u: Array) -> Fit:
        """An explanation on the records, which say how large its numbers are and whether more is left."""
        return converged_fit(self.bench, fit_at(self._problem(candidates), u))

    def _by_records(self, there: set[Key]) -> list[tuple[Posterior, Fit]]:
        """The explanation that the records speak for most to first order, of those that are not there already."""
        test = ScoreTest(self.bench, self.best)
        present = self.best.problem.candidates
        listed = [c for c in candidates(self.bench, present) if key_of((*present, c)) not in there]
        begun = test.best(listed)
        if begun is None:
            return []
        found = maximise_posterior(self._view, self._problem(begun.problem.candidates), self._rested(begun.u), 10)
        return [(found, self._fit(begun.problem.candidates, found.u))]

    def _exchanged(self, best: tuple[Posterior, Fit], there: set[Key]) -> list[tuple[Posterior, Fit]]:
        """The best explanation with another effect in the place of each that came in an earlier round."""
        (posterior, fit), found = best, list[tuple[Posterior, Fit]]()
        problem = self._problem(fit.problem.candidates)
        for at in range(len(problem.candidates) - 1):
            bare = maximise_posterior(self._view, *without_effect(problem, fit.u, at), 4)
            begun = (f for f in self._with_one_more(bare) if f.key not in there or f.evidence < posterior.evidence - 1)
            chosen = [self._pruned(f) for f in sorted(begun, key=lambda f: f.evidence)[:1]]
            found += [(f, self._fit(f.problem.candidates, f.u)) for f in chosen]
        return found

    def _with_one_more(self, here: Posterior) -> list[Posterior]:
        """The best explanations with one effect more, best first.

        The rows are linear in the nuisances near those that were fitted, unless these have replaced an effect: then
        they are near the nuisances at rest. What begins at rest has further to go, and is compared with its like.
        """
        present, found = candidates(self.bench, here.problem.candidates), list[Posterior]()
        for u in (here.u, self._rested(here.u)):
            screen = Screen(self._coarse, here.problem, u)
            listed = sorted((s for c in present for s in screen.starts(c, self.settings.starts)), key=lambda s: s.score)
            found += self._halved(listed[: self.settings.first], screen.J)
        return _distinct(found)

    def _halved(self, starts: list[GridStart], slopes: Array) -> list[Posterior]:
        """The best of some starts, each stage with more steps for fewer of them."""
        self._progress(0.3, "explanations compared")
        (steps, keep), *stages = HALVING
        found = _distinct(maximise_posterior(self._coarse, s.problem, s.u, steps, slopes) for s in starts)[:keep]
        for stage, (steps, keep) in enumerate(stages):
            self._progress(0.5 + 0.15 * stage, "explanations compared")
            found = _distinct(maximise_posterior(self._view, f.problem, f.u, steps) for f in found)[:keep]
        return found

    def _rested(self, u: Array) -> Array:
        """The numbers of the effects, the nuisances at rest: what they took over of another effect is forgotten."""
        free = self.bench.free.size
        return np.concatenate([np.zeros(free), u[free:]])

    def _progress(self, share: float, what: str) -> None:
        at = len(self.levels)
        report_progress((at + share) / self.settings.most_effects, f"round {at + 1}: {what}")

    def _pruned(self, found: Posterior) -> Posterior:
        """The same without effects and without numbers that the evidence does not ask for."""
        at = 0
        while at < len(found.problem.candidates):
            simpler = min(self._simpler(found, at), key=lambda f: f.evidence, default=found)
            fewer = len(simpler.problem.candidates) < len(found.problem.candidates)
            if simpler.evidence < found.evidence + self.settings.effect_price * fewer:
                found, at = simpler, 0
            else:
                at += 1
        return found

    def _simpler(self, found: Posterior, at: int) -> list[Posterior]:
        """An explanation without one of its effects, and with one that has no numbers in its place."""
        problem, u = without_effect(found.problem, found.u, at)
        place = found.problem.candidates[at].place
        bare = [maximise_posterior(self._view, problem, u, 4)] if problem.candidates else []
        fixed = (c for c in candidates(self.bench, problem.candidates) if not c.slots and c.place == place)
        return bare + [maximise_posterior(self._view, self._problem((*problem.candidates, c)), u, 4) for c in fixed]


def candidates(bench: Bench, present: Iterable[CandidateEffect] = ()) -> list[CandidateEffect]:
    """Every linear effect that may stand beside those present."""
    rig, channels, there = bench.data.rig, bench.data.channels, list(present)
    if bench.row is not None:
        listed = channel_candidates(rig, bench.row)
    else:
        listed = [
            *beam_candidates(rig),
            *(c for row in channels for c in channel_candidates(rig, row)),
            *pair_candidates(rig, channels),
        ]
    keys = {(c.effect, c.place) for c in there}
    once = {c.effect for c in there if model_of(c.effect).once}
    return [
        c
        for c in listed
        if bench.allowed(c.effect)
        and has_needed_tests(c, bench.data)
        and (c.effect, c.place) not in keys
        and c.effect not in once
    ]


def _score(fitted: tuple[Posterior, Fit]) -> float:
    """-2 log evidence of an explanation: what the records leave, and what the ranges of its numbers cost."""
    posterior, fit = fitted
    return fit.cost + posterior.evidence - posterior.cost


def _best_of_each(found: Iterable[Posterior]) -> list[Posterior]:
    """Best first, of each explanation the best numbers."""
    best: dict[Key, Posterior] = {}
    for f in sorted(found, key=lambda f: f.evidence):
        best.setdefault(f.key, f)
    return list(best.values())


def _distinct(found: Iterable[Posterior]) -> list[Posterior]:
    """Best first, of those that have come to the same explanation and numbers the best."""
    kept: list[Posterior] = []
    for f in sorted(found, key=lambda f: f.evidence):
        if not any(f.key == k.key and np.allclose(f.u, k.u, atol=1e-2) for k in kept):
            kept.append(f)
    return kept
