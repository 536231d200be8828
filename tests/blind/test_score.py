"""The score of diagnoses against truths, on diagnoses written by hand."""

from typing import Any

import pytest

from modallab.blind.score import Figure, Trial, probability_calibration, score_trials
from modallab.core.diagnosis import Diagnosis

MASS = {"effect": "added_mass", "family": "structure", "parameters": {"mass": 0.1}, "place": {"x": 0.5}}
GAIN = {"effect": "gain_error", "family": "sensor", "parameters": {"gain": 1.1}, "place": {"channel": 4}}


def said(verdict: str, *effects: dict[str, Any], stage: str | None = None, **where: Any) -> Diagnosis:
    """A diagnosis that says so."""
    place = {"channels": [], "x_m": None, "tests": [], "bands": [], "share": 1.0, "why": []} | where
    none: dict[str, float] = {}
    gap = {"before": 9.0, "floor": 1.0, "after": 1.0, "poles_hz": []} | {
        f"by_{k}": none for k in ("record", "test", "level", "channel", "band", "mode", "order")
    }
    return Diagnosis.model_validate(
        {
            "rig": "r",
            "verdict": verdict,
            "gap": gap | {"after_by_channel": none},
            "where": place | {"stage": stage},
            "effects": list(effects),
            "candidates": [{"effects": [e["effect"] for e in effects], "probability": 0.9, "gap": 1.0}],
            "shrink": {
                "held_out": ["a"],
                "before": 9.0,
                "after": 1.0,
                "closed": 1.0,
                "interval": (0.9, 1.0),
                "rival": none,
            },
            "next_experiment": "",
            "twin": {"youngs_modulus_pa": 1.0, "thickness_m": 1.0, "density_kg_m3": 1.0, "zeta": [0.01]},
            "notes": [],
        }
    )


def found(truth: dict[str, Any], probability: float = 0.95, **parameters: float) -> dict[str, Any]:
    return {
        "effect": truth["effect"],
        "stage": truth["family"],
        "probability": probability,
        "parameters": truth["parameters"] | parameters,
        "interval": {},
        "place": truth["place"],
    }


def figures(*trials: Trial) -> dict[str, Figure]:
    return {f.name: f for f in score_trials(trials)}


def test_a_right_name_counts_with_its_place_and_the_error_of_its_number() -> None:
    right = Trial("one", [MASS], said("known", found(MASS, mass=0.102), stage="structure", x_m=0.98), 2.0)
    f = figures(right)
    assert f["single effect named right"].value == 1
    assert f["stage right"].value == 1
    assert f["place within 0.05 L"].value == 1
    assert f["parameter, median relative error"].value == pytest.approx(0.02)


def test_a_gain_is_off_by_what_it_is_off_one() -> None:
    trial = Trial("one", [GAIN], said("known", found(GAIN, gain=1.12), stage="sensor", channels=["a04"]), 1.0)
    assert figures(trial)["parameter, median relative error"].value == pytest.approx(0.2)
    assert figures(trial)["channel right"].value == 1


def test_a_wrong_name_a_wrong_channel_and_a_false_alarm_are_listed() -> None:
    wrong = Trial("wrong", [GAIN], said("known", found(MASS), stage="structure", channels=["a05"]), 1.0)
    alarm = Trial("alarm", [], said("known", found(MASS), stage="structure"), 1.0)
    f = figures(wrong, alarm)
    assert f["single effect named right"].misses == ("wrong",)
    assert f["channel right"].misses == ("wrong",)
    assert f["false alarms"].misses == ("alarm",)
    assert f["precision where the probability is above 0.9"].misses == ("wrong",)


def test_what_is_withheld_must_be_called_unknown() -> None:
    withheld = frozenset({"added_mass"})
    honest = Trial("honest", [MASS], said("unknown", stage="structure"), 1.0, withheld=withheld)
    bold = Trial("bold", [MASS], said("known", found(GAIN), stage="sensor"), 1.0, withheld=withheld)
    f = figures(honest, bold)
    assert f["unknown flagged"].misses == ("bold",)
    assert f["single effect named right"].count == 0


def test_probabilities_are_held_against_what_came_true() -> None:
    right = Trial("right", [MASS], said("known", found(MASS, 0.9), stage="structure"), 1.0)
    wrong = Trial("wrong", [GAIN], said("known", found(MASS, 0.9), stage="structure"), 1.0)
    error, bins = probability_calibration([right, wrong])
    assert error == pytest.approx(0.4)
    assert [(b.value, b.count) for b in bins] == [(0.5, 2)]
