"""What blind trials have shown, as a document."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from math import isfinite

import numpy as np

from modallab.blind.score import Figure, Trial, parameter_errors, probability_calibration, score_trials
from modallab.core.frozen import Frozen


class OutcomeFigure(Frozen):
    """A figure: a share or a number, of how many trials, and which of them missed.

    Attributes:
        name: of the figure, in words.
        value: None where no trial counts for it.
        count: how many do.
        misses: names of trials that missed.
    """

    name: str
    value: float | None
    count: int
    misses: tuple[str, ...] = ()


class EffectOutcome(Frozen):
    """How trials with one true effect went.

    Attributes:
        effect: its name; "none" for sound benches, two names with a plus for a pair.
        trials: how many.
        right: how many verdicts are right: the name, "unknown" where the twin has no model, no gap where there is none.
        stage: how many stages are right; None for sound benches.
        parameter: median relative error of the parameters where it was named; None where it has none.
        closed: median share of the gap closed on records held out; None where it was not named.
        shrink_error: median difference between the shrinkage predicted and that seen later.
        said: what was said -> how often.
    """

    effect: str
    trials: int
    right: int
    stage: int | None
    parameter: float | None
    closed: float | None
    shrink_error: float | None
    said: dict[str, int]


class ShrinkageOutcome(Frozen):
    """The shrinkage of a trial, as predicted on records held out and as seen in a later campaign."""

    name: str
    effect: str
    predicted: float
    seen: float


class BlindOutcome(Frozen):
    """What blind trials have shown.

    Attributes:
        sealed: SHA-256 over the hashes of all truths, published before the first answer; None where others sealed.
        answers: SHA-256 of the file of answers, written before a truth was read.
        trials: how many were answered.
        figures: those a diagnosis is judged by.
        effects: true effect by true effect; their `said` are the rows of the confusion matrix.
        calibration_error: mean distance of probabilities from the share that was right, over named effects.
        reliability: probability that was said, and the share that was right.
        shrinkage: predicted against seen.
    """

    sealed: str | None
    answers: str
    trials: int
    figures: list[OutcomeFigure]
    effects: list[EffectOutcome]
    calibration_error: float
    reliability: list[OutcomeFigure]
    shrinkage: list[ShrinkageOutcome]


def summarise_trials(trials: Sequence[Trial], sealed: str | None, answers: str) -> BlindOutcome:
    """Sum up trials whose truth has been read."""
    error, bins = probability_calibration(trials)
    groups: dict[str, list[Trial]] = defaultdict(list)
    for trial in trials:
        groups[true_name(trial)].append(trial)
    return BlindOutcome(
        sealed=sealed,
        answers=answers,
        trials=len(trials),
        figures=[_outcome_figure(figure) for figure in score_trials(trials)],
        effects=[
            _outcome_of_effect(name, groups[name]) for name in sorted(groups, key=lambda n: (n == "none", "+" in n, n))
        ],
        calibration_error=error,
        reliability=[_outcome_figure(figure) for figure in bins],
        shrinkage=[
            ShrinkageOutcome(name=t.name, effect=true_name(t), predicted=t.diagnosis.shrink.closed, seen=t.seen_closed)
            for t in trials
            if t.diagnosis.shrink.closed is not None and t.seen_closed is not None
        ],
    )


def true_name(trial: Trial) -> str:
    """The true effects of a trial as one name."""
    return "+".join(sorted(str(e["effect"]) for e in trial.truth)) or "none"


def named_cause(trial: Trial) -> str:
    """What a diagnosis says as one name."""
    return "+".join(sorted(trial.said)) or trial.diagnosis.verdict.replace("_", " ")


def _outcome_figure(figure: Figure) -> OutcomeFigure:
    value = figure.value if isfinite(figure.value) else None
    return OutcomeFigure(name=figure.name, value=value, count=figure.count, misses=figure.misses)


def _outcome_of_effect(name: str, trials: Sequence[Trial]) -> EffectOutcome:
    right = [t for t in trials if t.right]
    stages = sum(t.diagnosis.where.stage in {e["family"] for e in t.truth} for t in trials)
    return EffectOutcome(
        effect=name,
        trials=len(trials),
        right=len(right),
        stage=None if name == "none" else stages,
        parameter=_median([e for t in trials for e in parameter_errors(t)]),
        closed=_median([t.diagnosis.shrink.closed for t in right if t.diagnosis.shrink.closed is not None]),
        shrink_error=_median([e for t in right if (e := t.shrink_error) is not None]),
        said=dict(Counter(named_cause(t) for t in trials).most_common()),
    )


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None
