"""Campaigns of the corpus as an engine gets them, made anew or read, beside their truth."""

import json
import os
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from other_structures import as_believed, as_built, benches, computed, drawn, frf, put_in
from structures import Material

from corpus.campaigns import Entry
from corpus.sealed import SEALED, unsealed
from modallab.blind.draw import TrialDraw, draw_rig, make_trial, with_changed_mounting
from modallab.blind.trial_bench import trial_bench
from modallab.core.block import Campaign
from modallab.core.effects import Effect
from modallab.core.errors import DataError
from modallab.core.model import ModalModel
from modallab.core.rig import Rig, Tolerance
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.mesh import Mesh

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class ModalTest:
    """A structure as it is: identified from its records, with the rig as believed."""

    model: ModalModel
    rig: Rig


@dataclass(frozen=True)
class Reference:
    """A structure's simulation: its modal model, and its shapes between the points where it was computed."""

    model: ModalModel
    mesh: Mesh | None


@dataclass(frozen=True)
class Made:
    """What an engine gets, and what is true.

    Attributes:
        campaign: the records and the rig, or of a structure its modal test.
        reference: of a structure.
        effects: the truth: dicts with effect, family, parameters, place; of a structure as `other_structures.drawn`.
        length_m: of the beam; of a structure its size.
    """

    campaign: Campaign | ModalTest
    reference: Reference | None
    effects: list[dict[str, Any]]
    length_m: float


def made(entry: Entry) -> Made:
    """The campaign of an entry.

    Raises:
        DataError: its folder is not there, or its seal does not hold what was sealed.
    """
    if entry.kind == "structure":
        return _structure(entry)
    if entry.set == SEALED:
        # Not kept: the truth of what is sealed stands nowhere in plain.
        campaign, effects = measured(unsealed(entry))
        return _beam(replace(campaign, provenance={}, source=""), effects)
    return _of_folder(entry) if entry.how == "folder" else _of_own_bench(entry)


def _of_folder(entry: Entry) -> Made:
    practice = Path(os.environ.get("MODALLAB_PRACTICE", ROOT.parent / "shared" / "practice"))
    folder = practice.parent / entry.set / entry.id
    if not folder.is_dir():
        raise DataError("there is no such campaign", where=str(folder), remedy="name the folder in MODALLAB_PRACTICE")
    truth = yaml.safe_load((folder / "truth.yaml").read_text(encoding="utf-8"))
    return _beam(read_campaign(folder), truth["effects"])


def _of_own_bench(entry: Entry) -> Made:
    """Made once and kept: what a draw measures may take a minute, and another engine is to get the same."""
    place = kept_at(entry)
    truth = place.with_suffix(".json")
    if not truth.exists():
        campaign, effects = measured(entry)
        write_campaign(replace(campaign, provenance={}, source=""), place)
        truth.write_text(json.dumps(effects), encoding="utf-8")
    return _beam(read_campaign(place), json.loads(truth.read_text(encoding="utf-8")))


def measured(entry: Entry) -> tuple[Campaign, list[dict[str, Any]]]:
    """The campaign on the own bench with the effects as listed, or as its seed draws them where none are."""
    if entry.drawn is None:
        draw = make_trial(TrialDraw(entry.id, entry.effect, int(entry.seed), entry.how), later=False)
        return draw.campaign, draw.truth["effects"]  # type: ignore[return-value]
    seed, rig = int(entry.seed), draw_rig(int(entry.seed))
    if entry.how != "none":
        rig = with_changed_mounting(rig.model_copy(update={"tolerance": Tolerance.usual()}), seed)
    effects = [as_effect(e) for e in entry.drawn]
    return trial_bench().make_trial(rig, seed, effects, entry.how)[0], entry.drawn


def as_effect(reported: dict[str, Any]) -> Effect:
    return Effect(effect=reported["effect"], parameters=reported["parameters"], place=reported["place"])


def kept_at(entry: Entry) -> Path:
    """Where a campaign of the own bench is kept once it is made, outside the repository."""
    folder = Path(os.environ.get("MODALLAB_CORPUS", Path(tempfile.gettempdir()) / "modallab-corpus"))
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{entry.effect}-{entry.seed}-{entry.how}.h5"


def _beam(campaign: Campaign, effects: list[dict[str, Any]]) -> Made:
    beam = campaign.rig.beam
    return Made(campaign, None, effects, beam.length_m if beam is not None else 1.0)


def _structure(entry: Entry) -> Made:
    """As `other_structures.trial` makes it, up to the diagnosis."""
    bench, rng = benches()[entry.how.partition(" ")[0]], np.random.default_rng([int(entry.seed), 17])
    rig = bench.rig
    before, _ = identify_frf(frf(bench, bench.make(Material()), rng, as_believed(bench)), rig, IdentificationOptions())
    of, built = as_built(bench, rng)
    truth: list[dict[str, Any]] = []
    if entry.effect != "none":
        truth = [drawn(bench, entry.effect, rng)]
        of, built = put_in(bench, truth[0], of, built)
    now, _ = identify_frf(frf(bench, of, rng, built), rig, IdentificationOptions())
    model, mesh = computed(bench, now) if entry.how.endswith("computed") else (before, None)
    return Made(ModalTest(now, rig), Reference(model, mesh), truth, float(bench.points.max()))
