"""The score of diagnoses against a truth they did not see."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, cast

import numpy as np

from modallab.core.diagnosis import Diagnosis
from modallab.core.effects import kind_of
from modallab.twin.effect_model import NoChange
from modallab.twin.effects import effect_models

X_TOLERANCE = 0.05
"""Share of the beam's length within which a place is right."""
_BIN_EDGES = (0.0, 0.5, 0.8, 0.95, 1.0)
"""Of the probabilities that are held against what came true."""
SURE = 0.9
"""Probability from which a name is a claim."""


def _modelled_effects() -> frozenset[str]:
    return frozenset(name for name, model in effect_models().items() if model.change is not NoChange.NO_MODEL_YET)


@dataclass(frozen=True, slots=True)
class Trial:
    """A diagnosis beside the truth.

    Attributes:
        name: of the campaign.
        truth: its effects: dicts with effect, family, parameters, place.
        diagnosis: what was said.
        length_m: of the beam.
        seconds: how long it took.
        withheld: names that were taken out of the candidates.
        seen_closed: share of the reducible gap closed in a later campaign, once applied; None where it was not seen.
        shut: whether that campaign had no gap left; None where it was not looked at.
    """

    name: str
    truth: Sequence[dict[str, Any]]
    diagnosis: Diagnosis
    length_m: float
    seconds: float = 0.0
    withheld: frozenset[str] = frozenset()
    seen_closed: float | None = None
    shut: bool | None = None

    @property
    def names(self) -> frozenset[str]:
        """True effects that may be named: where the twin has no model, the right answer is that it does not know."""
        return frozenset(str(e["effect"]) for e in self.truth if e["effect"] in _modelled_effects() - self.withheld)

    @property
    def identifiable(self) -> bool:
        """Whether every effect of the truth has a model."""
        return len(self.names) == len(self.truth)

    @property
    def right(self) -> bool:
        """Whether the verdict is the right one and names all true effects and no other."""
        verdict = self.diagnosis.verdict
        if not self.truth:
            return verdict == "no_gap"
        return self.said == self.names if self.identifiable else verdict == "unknown"

    @property
    def shrink_error(self) -> float | None:
        """By how much the shrinkage that was predicted differs from what a later campaign showed."""
        predicted = self.diagnosis.shrink.closed
        return None if predicted is None or self.seen_closed is None else abs(predicted - self.seen_closed)

    @property
    def said(self) -> frozenset[str]:
        """Effects judged present."""
        return frozenset(f.effect for f in self.diagnosis.effects)


@dataclass(frozen=True, slots=True)
class Figure:
    """A share or a number, of how many."""

    name: str
    value: float
    count: int
    misses: tuple[str, ...] = field(default_factory=tuple)


def score_trials(trials: Sequence[Trial]) -> list[Figure]:
    """The figures a diagnosis is judged by."""
    singles = [t for t in trials if len(t.truth) == 1 and t.identifiable]
    doubles = [t for t in trials if len(t.truth) > 1 and t.identifiable]
    empty = [t for t in trials if not t.truth]
    strange = [t for t in trials if t.truth and not t.identifiable]
    present = [t for t in trials if t.truth]
    return [
        _share("single effect named right", singles, lambda t: t.said == t.names),
        _share("two effects named right", doubles, lambda t: t.said == t.names),
        _share("the three best explanations contain the truth", singles, _truth_in_set),
        _share("stage right", present, _stage_right),
        _share("stage right by tests on the residual alone", [t for t in present if _was_tested(t)], _tested_right),
        _share("channel right", [t for t in singles if _true_channels(t)], _channel_right),
        _share("place within 0.05 L", [t for t in singles if _true_x(t) is not None], _place_right),
        _median("parameter, median relative error", [e for t in (*singles, *doubles) for e in parameter_errors(t)]),
        _share(
            "precision where the probability is above 0.9", [t for t in present if _claims_of_trial(t)], _claims_right
        ),
        _share("false alarms", empty, lambda t: t.diagnosis.verdict != "no_gap", expected=False),
        _share("unknown flagged", strange, lambda t: t.diagnosis.verdict == "unknown"),
        _median("gap closed on held-out records", _closed_shares(t for t in singles if t.said == t.names)),
        _median("shrinkage predicted less measured, median", [e for t in trials if (e := t.shrink_error) is not None]),
        _share(
            "gap closed in a later campaign", [t for t in present if t.shut is not None and t.right], _gap_closed_right
        ),
        _median("seconds a diagnosis", [t.seconds for t in trials]),
    ]


def parameter_errors(trial: Trial) -> list[float]:
    """Relative errors of the parameters of effects named right."""
    errors: list[float] = []
    for true in trial.truth:
        found = next((f for f in trial.diagnosis.effects if f.effect == true["effect"]), None)
        for name, value in cast("dict[str, float]", true["parameters"]).items():
            if found is not None and name in found.parameters and name not in {"sign", "hz"}:
                # A gain of one is no effect: what counts is how far it is off one.
                zero = kind_of(found.effect).parameter(name).none
                errors.append(abs(found.parameters[name] - value) / abs(value - zero))
    return errors


def probability_calibration(trials: Sequence[Trial]) -> tuple[float, list[Figure]]:
    """Calibration error of the probabilities of named effects, and the share right in each bin."""
    return calibration_of_claims([(f.probability, f.effect in t.names) for t in trials for f in t.diagnosis.effects])


def calibration_of_claims(claims: Sequence[tuple[float, bool]]) -> tuple[float, list[Figure]]:
    """The same of claims: the probability that was said, and whether it was right."""
    bins: list[Figure] = []
    error = 0.0
    for low, high in pairwise(_BIN_EDGES):
        inside = [(p, right) for p, right in claims if low < p <= high]
        if inside:
            said, was = float(np.mean([p for p, _ in inside])), float(np.mean([r for _, r in inside]))
            bins.append(Figure(f"said {said:.2f}", was, len(inside)))
            error += abs(said - was) * len(inside) / len(claims)
    return error, bins


def _share(name: str, trials: Iterable[Trial], test: Callable[[Trial], bool], expected: bool = True) -> Figure:
    listed = list(trials)
    matches = [bool(test(t)) for t in listed]
    misses = tuple(t.name for t, match in zip(listed, matches, strict=True) if match is not expected)
    return Figure(name, float(np.mean(matches)) if matches else float("nan"), len(listed), misses)


def _median(name: str, values: Sequence[float]) -> Figure:
    return Figure(name, float(np.median(values)) if values else float("nan"), len(values))


def _gap_closed_right(trial: Trial) -> bool:
    return bool(trial.shut)


def _stage_right(trial: Trial) -> bool:
    return trial.diagnosis.where.stage in {e["family"] for e in trial.truth}


def _was_tested(trial: Trial) -> bool:
    return trial.diagnosis.where.tested_stage is not None


def _tested_right(trial: Trial) -> bool:
    return trial.diagnosis.where.tested_stage in {e["family"] for e in trial.truth}


def _closed_shares(trials: Iterable[Trial]) -> list[float]:
    return [t.diagnosis.shrink.closed for t in trials if t.diagnosis.shrink.closed is not None]


def _truth_in_set(trial: Trial) -> bool:
    listed = [trial.said, *(frozenset(c.effects) for c in trial.diagnosis.candidates[:3])]
    return any(trial.names <= s for s in listed)


def _true_channels(trial: Trial) -> set[int]:
    found: set[int] = set()
    for e in trial.truth:
        channel = e["place"].get("channel")
        if isinstance(channel, int):
            found.add(channel)
        elif isinstance(channel, list):
            found |= set(cast("list[int]", channel))
    return found


def _channel_right(trial: Trial) -> bool:
    said = {
        0 if c == "force" else int(c[1:]) for c in trial.diagnosis.where.channels if c == "force" or c[1:].isdigit()
    }
    return said == _true_channels(trial)


def _true_x(trial: Trial) -> float | None:
    x = trial.truth[0]["place"].get("x")
    return float(x) if isinstance(x, float | int) else None


def _place_right(trial: Trial) -> bool:
    x, said = _true_x(trial), trial.diagnosis.where.x_m
    return x is not None and said is not None and abs(said / trial.length_m - x) <= X_TOLERANCE


def _claims_of_trial(trial: Trial) -> bool:
    return any(f.probability > SURE for f in trial.diagnosis.effects)


def _claims_right(trial: Trial) -> bool:
    return all(f.effect in trial.names for f in trial.diagnosis.effects if f.probability > SURE)
