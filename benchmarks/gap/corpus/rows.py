"""A row of the results: what was said of a campaign beside its truth, judged by the project's own scoring."""

import json
from typing import Any

import numpy as np
from in_turn import held
from other_structures import judged

from corpus.campaigns import Entry, kind_of_truth
from corpus.made import Made
from corpus.results import Row
from modallab.blind.score import SURE, Trial, parameter_errors, score_trials
from modallab.core.diagnosis import Diagnosis, FoundEffect
from modallab.core.modal_diagnosis import FoundChange, ModalDiagnosis

FIGURES = {
    "in_three": "the three best explanations contain the truth",
    "stage_right": "stage right",
    "channel_right": "channel right",
    "place_right": "place within 0.05 L",
    "claims_right": "precision where the probability is above 0.9",
}


def truth_of(entry: Entry, made: Made) -> Row:
    """What of a row is known before the diagnosis."""
    names = sorted(str(e["effect"]) for e in made.effects)
    kind = "structure" if entry.kind == "structure" else kind_of_truth(names)
    return {"id": entry.id, "set": entry.set, "kind": kind, "seen": entry.seen, "true": "+".join(names)}


def row_of(entry: Entry, made: Made, said: Diagnosis | ModalDiagnosis, seconds: float) -> Row:
    """The rest of it, but for engine, date and commit."""
    row: Row = {"seconds": round(seconds, 2), "verdict": said.verdict, "said": _joined(said.effects)}
    row |= _effects(said.effects)
    row["candidates"] = json.dumps([["+".join(c.effects), round(c.probability, 4)] for c in said.candidates[:5]])
    beam = isinstance(said, Diagnosis)
    return row | (_of_beam(entry, made, said, seconds) if beam else _of_structure(entry, made, said, seconds))


def _joined(effects: list[FoundEffect] | list[FoundChange]) -> str:
    return "+".join(sorted(f.effect for f in effects))


def _effects(effects: list[FoundEffect] | list[FoundChange]) -> Row:
    columns = {"probabilities": "probability", "numbers": "parameters", "intervals": "interval", "places": "place"}
    return {
        name: json.dumps({f.effect: f.model_dump(mode="json")[of] for f in effects}) for name, of in columns.items()
    }


def _of_beam(entry: Entry, made: Made, said: Diagnosis, seconds: float) -> Row:
    trial = Trial(entry.id, made.effects, said, made.length_m, seconds)
    figures = {f.name: f for f in score_trials([trial])}
    errors = parameter_errors(trial)
    return {
        "right": int(trial.right),
        **{column: int(figures[name].value) for column, name in FIGURES.items() if figures[name].count},
        "number_error": float(np.median(errors)) if errors else "",
        "held": json.dumps(dict(held(trial))),
        "stage": said.where.stage or "",
        "x_m": "" if said.where.x_m is None else said.where.x_m,
        "channels": "+".join(said.where.channels),
        "gap_without_effects": said.gap.before,
        "gap_after": said.gap.after,
        "held_out_before": said.shrink.before,
        "held_out_after": said.shrink.after,
        "closed": "" if said.shrink.closed is None else said.shrink.closed,
    }


def _of_structure(entry: Entry, made: Made, said: ModalDiagnosis, seconds: float) -> Row:
    """Gaps are shares of the response; places and numbers are judged as `other_structures.judged` does."""
    truth = made.effects[0] if made.effects else {"effect": "none"}
    bench = entry.how.partition(" ")[0]
    mark = judged({"bench": bench, "truth": truth, "said": said.model_dump(mode="json"), "seconds": seconds})
    claims = [f.effect == truth["effect"] for f in said.effects if f.probability > SURE]
    row: Row = {"right": int(mark["right"]), "gap_without_effects": said.before, "gap_after": said.after}
    if made.effects and claims:
        row["claims_right"] = int(all(claims))
    if "error" in mark:
        row |= {"place_right": int(mark["place"]), "number_error": mark["error"]}
    return row | {"held": json.dumps(_held_by_model(truth, said))}


def _held_by_model(truth: dict[str, Any], said: ModalDiagnosis) -> dict[str, bool]:
    """Whether the intervals of a change named right hold the truth."""
    found = next((f for f in said.effects if f.effect == truth["effect"]), None)
    if found is None:
        return {}
    moved = dict(zip(("dx", "dy", "dz"), truth.get("moved_m", ()), strict=False))
    true = {name: moved.get(name, truth["size"]) for name in found.interval}
    # Along an axis in which the sensor cannot move there is nothing to be found.
    inside = {name: (low, high) for name, (low, high) in found.interval.items() if high > low}
    return {f"{found.effect} {name}": bool(low <= true[name] <= high) for name, (low, high) in inside.items()}
