"""The convention matrix in full: every way to write down one recording, asked of every slow answer.

    python benchmarks/conventions.py

Prints, for each way, the largest relative difference of the modal model and of the diagnosis from those of the plain
way; ends with 1 if any differs by more than rounding does.
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests" / "helpers"), str(ROOT / "tests" / "conventions")]

from convention import SAME  # noqa: E402
from twin_campaign import built, link  # noqa: E402

from modallab.core.block import Campaign  # noqa: E402
from modallab.core.diagnosis import Diagnosis  # noqa: E402
from modallab.core.effect import OneChannel  # noqa: E402
from modallab.core.effects import Effect  # noqa: E402
from modallab.core.model import ModalModel  # noqa: E402
from modallab.gap.diagnosis import diagnose  # noqa: E402
from modallab.identification import IdentificationOptions  # noqa: E402
from modallab.pipelines.identify import identify_campaign  # noqa: E402

MOST = 5e-4
"""Relative difference that rounding makes of a fit that ends where a step no longer pays; sigma is far larger."""
EFFECTS = (
    Effect(effect="added_mass", parameters={"mass": 0.05}, place={"x": 0.8}),
    Effect(effect="gain_error", parameters={"gain": 1.2}, place={"channel": 7}),
    Effect(effect="force_gain", parameters={"gain": 0.8}, place={"channel": 0}),
)


def of_model(one: ModalModel, two: ModalModel) -> float:
    if one.n_modes != two.n_modes:
        return np.inf
    a, b = (np.moveaxis(m.modal_constants, 1, 0)[np.argsort(m.outputs)] for m in (one, two))
    return max(
        float(np.max(np.abs(two.frequency_hz / one.frequency_hz - 1))),
        float(np.max(np.abs(two.damping_ratio / one.damping_ratio - 1))),
        float(np.max(np.abs(b - a)) / np.max(np.abs(a))),
    )


def of_diagnosis(one: Diagnosis, two: Diagnosis, names: tuple[list[str], list[str]]) -> float:
    if (one.verdict, one.where.stage, sorted(one.where.channels)) != (
        two.verdict, two.where.stage, sorted(two.where.channels)
    ):  # fmt: skip
        return np.inf
    if [e.effect for e in one.effects] != [e.effect for e in two.effects]:
        return np.inf
    pairs = [
        (v, b.parameters[k]) for a, b in zip(one.effects, two.effects, strict=True) for k, v in a.parameters.items()
    ]
    for a, b in zip(one.effects, two.effects, strict=True):
        where = [names[i][e.place.channel] for i, e in enumerate((a, b)) if isinstance(e.place, OneChannel)]
        if len(set(where)) > 1:
            return np.inf
    return max(abs(b / a - 1) for a, b in [*pairs, (one.gap.after, two.gap.after)])


def modelled(campaign: Campaign) -> ModalModel:
    return identify_campaign(campaign, IdentificationOptions(), "impact").identified[0].model


def main() -> int:
    campaigns = [built(link(), effect) for effect in EFFECTS]
    usual = [(modelled(c), diagnose(c)) for c in campaigns]
    for campaign, (model, diagnosis) in zip(campaigns, usual, strict=True):
        named = ", ".join(e.effect for e in diagnosis.effects)
        print(f"{campaign.source}: {model.n_modes} modes, {diagnosis.verdict}: {named}")
    worst = 0.0
    for name, convention in SAME.items():
        found = []
        for campaign, (model, diagnosis) in zip(campaigns, usual, strict=True):
            other = convention(campaign)
            names = tuple([c.name for c in rig.channels] for rig in (campaign.rig, other.rig))
            found += [of_model(model, modelled(other)), of_diagnosis(diagnosis, diagnose(other), names)]
        worst = max(worst, *found)
        print(f"{name:28s} model {max(found[::2]):.1e}  diagnosis {max(found[1::2]):.1e}", flush=True)
    print(f"largest: {worst:.1e}, at most {MOST:g}")
    return int(not worst <= MOST)


if __name__ == "__main__":
    sys.exit(main())
