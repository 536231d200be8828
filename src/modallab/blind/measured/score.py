"""The score of semi-real trials, as a document."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from modallab.blind.measured.draw import AppliedEffect
from modallab.blind.outcome import OutcomeFigure
from modallab.core.effect import BetweenPoints, EveryOutput, NamedChannel, PlaceOnStructure
from modallab.core.frozen import Frozen
from modallab.core.modal_diagnosis import ModalDiagnosis

SIZE = 0.1
"""Relative error up to which a size is right; of a gain that of its distance from 1."""
SURE = 0.9
"""Probability from which a name is a claim."""


class MeasuredTrial(Frozen):
    """What was done and what was said of it.

    Attributes:
        name: of the trial.
        effect: that was put in; "none" for none.
        value: its number, SI.
        place: of it: a channel or a point; "" for all.
        said: effect that was named, else the verdict; "not_identified" where the trial's FRFs showed no mode.
        probability: of the name; 0 without one.
        said_value: its number.
        said_place: its channel or point.
        right: whether the name is right, or nothing was done and nothing said.
        size_error: relative; None where none was named right, or it has no size.
        place_right: None where none was named right, or it has no place.
        among: whether the effect is among the most probable explanations that have 95 % together; None in older files.
    """

    name: str
    effect: str
    value: float | None
    place: str
    said: str
    probability: float
    said_value: float | None
    said_place: str
    right: bool
    size_error: float | None
    place_right: bool | None
    among: bool | None = None


class MeasuredOutcome(Frozen):
    """What semi-real trials have shown.

    Attributes:
        campaign: whose FRFs they were made of.
        sealed: SHA-256 over the hashes of all truths, published before the first answer.
        figures: shares and medians over all trials.
        trials: one by one.
    """

    campaign: str
    sealed: str
    figures: list[OutcomeFigure]
    trials: list[MeasuredTrial]


@dataclass(frozen=True, slots=True)
class Truth:
    """A trial's effect with its place in words, and how far a moved sensor went."""

    put: AppliedEffect | None
    place: str
    moved_m: float = 0.0


def judge_trial(name: str, truth: Truth, found: ModalDiagnosis | None) -> MeasuredTrial:
    """A diagnosis held against what was done; None where no mode was identified."""
    put, named = truth.put, found.effects[0] if found and found.effects else None
    verdict = found.verdict if found else "not_identified"
    value = None if put is None else (put.value if put.other is None else truth.moved_m)
    said = None if named is None else _size_of_effect(named.parameters)
    there = "" if named is None else _place_in_words(named.place)
    right = verdict == "no_gap" if put is None else named is not None and named.effect == put.effect
    counts = right and put is not None
    return MeasuredTrial(
        name=name,
        effect="none" if put is None else put.effect,
        value=value,
        place=truth.place,
        said=verdict if named is None else named.effect,
        probability=0.0 if named is None else named.probability,
        said_value=said,
        said_place=there,
        right=right,
        size_error=_relative_error(put, said, value) if counts else None,
        place_right=there == truth.place if counts and truth.place else None,
        among=found is not None and ("no_gap" if put is None else put.effect) in found.explanations(),
    )


def _place_in_words(place: PlaceOnStructure) -> str:
    if isinstance(place, EveryOutput):
        return ""
    if isinstance(place, BetweenPoints):
        return f"{place.points[0]}-{place.points[1]}"
    return place.channel if isinstance(place, NamedChannel) else str(place.point)


def _relative_error(put: AppliedEffect | None, said: float | None, value: float | None) -> float | None:
    """Relative error of a size; of a gain that of its distance from 1."""
    if put is None or said is None or value is None:
        return None
    return abs(said - value) / abs(value - (1.0 if put.effect == "gain_error" else 0.0))


def _size_of_effect(parameters: dict[str, float]) -> float:
    """The number of an effect; of a move its length."""
    values = list(parameters.values())
    return values[0] if len(values) == 1 else float(np.linalg.norm(values))


def trial_figures(trials: Sequence[MeasuredTrial]) -> list[OutcomeFigure]:
    """The figures they are judged by."""
    done = [t for t in trials if t.effect != "none"]
    sizes = [t for t in trials if t.size_error is not None]
    placed = [t for t in trials if t.place_right is not None]
    sure = [t for t in trials if t.probability > SURE]
    return [
        _share_of_trials("named right", done, lambda t: t.right),
        _share_of_trials("effect among explanations of 95 % together", done, lambda t: bool(t.among)),
        _share_of_trials("size within 10 %, of effects named right", sizes, lambda t: (t.size_error or 0.0) <= SIZE),
        _share_of_trials("place right, of effects named right", placed, lambda t: bool(t.place_right)),
        _share_of_trials("right where the probability is above 0.9", sure, lambda t: t.right),
        _share_of_trials("no gap although an effect was added", done, lambda t: t.said == "no_gap", expected=False),
        _share_of_trials(
            "false alarms", [t for t in trials if t.effect == "none"], lambda t: not t.right, expected=False
        ),
    ]


def _share_of_trials(
    name: str, trials: Sequence[MeasuredTrial], test: Callable[[MeasuredTrial], bool], expected: bool = True
) -> OutcomeFigure:
    matches = [test(t) for t in trials]
    misses = tuple(t.name for t, match in zip(trials, matches, strict=True) if match is not expected)
    return OutcomeFigure(
        name=name, value=float(np.mean(matches)) if matches else None, count=len(trials), misses=misses
    )
