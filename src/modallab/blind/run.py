"""Blind trials from the draw to the outcome: sealed, answered, opened, and held against campaigns made later.

What is done already is not done again.
"""

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from modallab.blind.draw import TrialDraw, draw_trials, make_trial
from modallab.blind.outcome import BlindOutcome, summarise_trials
from modallab.blind.request import BlindRequest
from modallab.blind.score import Trial
from modallab.blind.seal import SEALED, open_truth, publish_hashes, published_hashes, seal_truth, sealed_hash
from modallab.blind.trial_answers import ANSWERS, TrialAnswer, answer_trials, compute_in_pool, read_answers
from modallab.core.block import Campaign
from modallab.core.diagnosis import Diagnosis
from modallab.core.errors import DataError, FormatError
from modallab.core.hold_out import MIXED
from modallab.core.progress import part_of_progress, report_progress
from modallab.formats.campaign.campaign_hdf5 import read_campaign, write_campaign
from modallab.gap.diagnosis import diagnose
from modallab.gap.report.initial_gap import gap_on_held_out, gap_outside_revisions, gap_without_effects
from modallab.gap.report.measure import BARE, share_of_gap_closed
from modallab.gap.revisions import with_diagnosis
from modallab.twin.effects import model_of

CAMPAIGNS = "campaigns"


def run_blind_trials(folder: Path, request: BlindRequest, pool: Executor | None = None) -> BlindOutcome:
    """Make trials, seal their truth, diagnose them, open the seals, and sum up.

    Args:
        folder: what was begun here goes on; hashes, campaigns, sealed truths and answers are in it.
        request: which trials.
        pool: computes each step of each trial in a process of its own; None: all in this one.

    Raises:
        DataError: the folder holds other trials, or a truth that is not the one that was sealed.
        StorageError: the folder cannot be written.
    """
    return blind_draws(folder, draw_trials(request), request.model_dump(mode="json"), request.later, pool)


def blind_draws(
    folder: Path, draws: Sequence[TrialDraw], plan: dict[str, Any], later: bool, pool: Executor | None = None
) -> BlindOutcome:
    """The same of any trials; `plan` says in the published hashes which they are."""
    folder.mkdir(parents=True, exist_ok=True)
    _require_same(folder, plan)
    with part_of_progress(0.0, 0.3, "sealed"):
        left = [draw for draw in draws if sealed_hash(folder, draw.name) is None]
        made = dict(compute_in_pool(pool, lambda draw: (_make_and_seal, (folder, draw, later)), left, "trial"))
        hashes = {draw.name: made.get(draw) or str(sealed_hash(folder, draw.name)) for draw in draws}
    sealed = publish_hashes(folder, plan, hashes)
    report_progress(0.3, f"sealed, SHA-256 {sealed}")
    campaigns = {draw.name: _campaign_of(folder, draw.name) for draw in draws}
    with part_of_progress(0.3, 0.8, "blind"):
        answers = answer_trials(campaigns, folder / ANSWERS, pool)
    with part_of_progress(0.8, 1.0, "opened"):
        found = {answer.name: answer for answer in read_answers(folder / ANSWERS)}
        seen = _later_campaigns_seen(folder, found, pool) if later else {}
        trials = [_trial_of_answer(found[name], open_truth(folder, name)["effects"], seen.get(name)) for name in hashes]
    return summarise_trials(trials, sealed, answers)


def blind_folder(campaigns: Path, truths: Path | None, out: Path, pool: Executor | None = None) -> BlindOutcome | str:
    """Diagnose every campaign of a folder, and only then read truths that lie elsewhere.

    Args:
        campaigns: holds a folder, or a campaign file, for each.
        truths: holds `NAME/truth.yaml` or `NAME.yaml` with the list `effects` for each; None: there is none yet.
        out: folder for the answers; what it holds already is kept.
        pool: as `run_blind_trials`.

    Returns:
        the outcome; without truths the SHA-256 of the answers.

    Raises:
        DataError: there is no campaign.
        FormatError: a truth cannot be read.
    """
    found = campaigns_in(campaigns)
    out.mkdir(parents=True, exist_ok=True)
    with part_of_progress(0.0, 1.0, "blind"):
        answers = answer_trials(found, out / ANSWERS, pool)
    if truths is None:
        return answers
    listed = {answer.name: answer for answer in read_answers(out / ANSWERS)}
    return summarise_trials(
        [_trial_of_answer(listed[name], _truth_of_trial(truths, name), None) for name in found], None, answers
    )


def campaigns_in(folder: Path) -> dict[str, Path]:
    """Name -> campaign, for each in a folder.

    Raises:
        DataError: there is none.
    """
    if not folder.is_dir():
        raise DataError("is no folder", where=str(folder), remedy="name a folder of campaign files or folders")
    files = {path.stem: path for path in folder.glob("*.h5")}
    folders = {path.name: path for path in folder.iterdir() if path.is_dir() and _is_campaign(path)}
    found = dict(sorted((files | folders).items()))
    if not found:
        raise DataError("holds no campaign", where=str(folder), remedy="name a folder of campaign files or folders")
    return found


def _is_campaign(folder: Path) -> bool:
    return (folder / "campaign.h5").exists() or (folder / "rig.yaml").exists()


def _truth_of_trial(truths: Path, name: str) -> list[dict[str, Any]]:
    place = next((p for p in (truths / name / "truth.yaml", truths / f"{name}.yaml") if p.exists()), None)
    if place is None:
        raise FormatError(f"there is no truth of {name}", where=str(truths), remedy=f"add {name}/truth.yaml")
    try:
        content = yaml.safe_load(place.read_text(encoding="utf-8"))
        return [{"family": "", "parameters": {}, "place": {}} | dict(effect) for effect in content["effects"]]
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise FormatError(f"is no truth: {error}", where=str(place), remedy="write a list `effects`") from error


def _require_same(folder: Path, plan: dict[str, Any]) -> None:
    known = published_hashes(folder)
    if known is not None and known["plan"] != plan:
        raise DataError(
            "other trials were sealed in this folder",
            where=str(folder),
            remedy="request the same trials, or name an empty folder",
        )


def _campaign_of(folder: Path, name: str) -> Path:
    return folder / CAMPAIGNS / f"{name}.h5"


def _later_of(folder: Path, name: str) -> Path:
    return folder / SEALED / f"{name}_later.h5"


def _make_and_seal(what: tuple[Path, TrialDraw, bool]) -> str:
    """Make a trial and seal its truth; gives the hash."""
    folder, draw, later = what
    made = make_trial(draw, later)
    for place in (folder / CAMPAIGNS, folder / SEALED):
        place.mkdir(parents=True, exist_ok=True)
    write_campaign(_anonymous(made.campaign, draw.name), _campaign_of(folder, draw.name))
    if made.later is not None:
        write_campaign(_anonymous(made.later, draw.name), _later_of(folder, draw.name))
    # Last of all: what has a seal is whole.
    return seal_truth(folder, draw.name, made.truth)


def _anonymous(campaign: Campaign, name: str) -> Campaign:
    rig = campaign.rig.model_copy(update={"name": name, "bench": None})
    return replace(campaign, rig=rig, provenance={}, source="")


class RepeatedCampaign(NamedTuple):
    """A diagnosis compared with a later campaign.

    Attributes:
        closed: share of the reducible gap that it closes there; None where there was next to none.
        shut: whether that campaign has no gap to the simulation that carries the diagnosis.
    """

    closed: float | None
    shut: bool


def _later_campaigns_seen(
    folder: Path, found: Mapping[str, TrialAnswer], pool: Executor | None
) -> dict[str, RepeatedCampaign]:
    known = [answer for answer in found.values() if answer.diagnosis.verdict == "known"]
    later = compute_in_pool(
        pool, lambda a: (_repeat_campaign, (_later_of(folder, a.name), a.diagnosis)), known, "later campaign"
    )
    return {answer.name: seen for answer, seen in later}


def _repeat_campaign(what: tuple[Path, Any]) -> RepeatedCampaign:
    return diagnose_later_campaign(*what)


def _trial_of_answer(answer: TrialAnswer, truth: list[dict[str, Any]], seen: RepeatedCampaign | None) -> Trial:
    return Trial(
        answer.name,
        truth,
        answer.diagnosis,
        answer.length_m,
        answer.seconds,
        answer.withheld,
        None if seen is None else seen.closed,
        None if seen is None else seen.shut,
    )


def diagnose_later_campaign(later: Path, diagnosis: Diagnosis) -> RepeatedCampaign:
    """Hold a diagnosis that names effects against a later campaign on the same bench."""
    campaign = read_campaign(later)
    revised = replace(campaign, rig=with_diagnosis(campaign.rig, diagnosis, date.min))
    before, after = _gaps_before_and_after(campaign, revised, diagnosis)
    share = share_of_gap_closed(before, after) if before**2 - 1 > BARE else None
    return RepeatedCampaign(share, diagnose(revised).verdict == "no_gap")


def _gaps_before_and_after(campaign: Campaign, revised: Campaign, diagnosis: Diagnosis) -> tuple[float, float]:
    """In noise units, on what a diagnosis measures its shrinkage on: records that its fits have not seen."""
    if any(model_of(f.effect).search is None for f in diagnosis.effects):
        # What no force predicts is in each record on its own.
        return gap_without_effects(campaign), gap_outside_revisions(revised)
    return gap_on_held_out(campaign, MIXED), gap_on_held_out(revised, MIXED)
