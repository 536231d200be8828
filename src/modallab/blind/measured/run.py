"""Semi-real trials from the draw to the outcome: sealed, diagnosed, opened."""

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from modallab.blind.measured.draw import AppliedEffect, MeasuredRequest, draw_effects, places_of, with_effect
from modallab.blind.measured.score import MeasuredOutcome, Truth, judge_trial, trial_figures
from modallab.blind.seal import open_truth, publish_hashes, seal_truth
from modallab.core.arrays import Real
from modallab.core.errors import IdentificationError
from modallab.core.frf import Frf
from modallab.core.modal_diagnosis import ModalDiagnosis
from modallab.core.model import ModalModel
from modallab.core.progress import part_of_progress, report_progress
from modallab.core.rig import Rig
from modallab.frf.estimate import variance_of
from modallab.gap.modal.diagnosis import diagnose_by_model
from modallab.identification.frf_model import identify_frf
from modallab.identification.options import IdentificationOptions
from modallab.modification.freedoms import with_points

ANSWERS = "answers"


def run_trials_on(frf: Frf, rig: Rig, folder: Path, request: MeasuredRequest, named: str = "") -> MeasuredOutcome:
    """Put effects into measured FRFs, seal what was done, diagnose all, open the seals, and sum up.

    Each trial is the measured structure with one effect, or none, and with noise drawn anew; it is held against the
    model of the FRFs as they were measured. A trial in which no mode is found is counted as not identified.

    Args:
        frf: measured.
        rig: its points and channels.
        folder: for the sealed truths and the answers; empty.
        request: which trials.
        named: the campaign, in words.

    Raises:
        DataError: the folder holds other trials, or the FRFs have no points.
        IdentificationError: the FRFs hold no mode.
    """
    folder.mkdir(parents=True, exist_ok=True)
    report_progress(0.0, "identifying")
    reference = _model_of_frf(frf, rig)
    puts = draw_effects(reference, rig, request)
    names = [f"trial_{n:03d}" for n in range(len(puts))]
    truths = [_truth_of_trial(put, reference, rig) for put in puts]
    hashes = {name: seal_truth(folder, name, _truth_document(truth)) for name, truth in zip(names, truths, strict=True)}
    sealed = publish_hashes(folder, request.model_dump(mode="json") | {"on": named}, hashes)
    variance = variance_of(frf)
    for n, (name, put) in enumerate(zip(names, puts, strict=True)):
        with part_of_progress(n / len(puts), (n + 1) / len(puts), name):
            rng = np.random.default_rng((request.seed, 1, n))
            there = with_noise(with_effect(frf, put), variance, rng)
            _keep_diagnosis(folder, name, _diagnose_trial(reference, (frf, there), rig))
    trials = [judge_trial(name, _open_seal(folder, name), _read_answer(folder, name)) for name in names]
    return MeasuredOutcome(campaign=named, sealed=sealed, figures=trial_figures(trials), trials=trials)


def _model_of_frf(frf: Frf, rig: Rig) -> ModalModel:
    return with_points(identify_frf(frf, rig, IdentificationOptions())[0], rig)


def _diagnose_trial(reference: ModalModel, frfs: tuple[Frf, Frf], rig: Rig) -> ModalDiagnosis | None:
    try:
        return diagnose_by_model(reference, _model_of_frf(frfs[1], rig), rig, frfs=frfs)
    except IdentificationError:
        return None


def _truth_of_trial(put: AppliedEffect | None, model: ModalModel, rig: Rig) -> Truth:
    if put is None or put.output is None:
        return Truth(put, "")
    if put.input is not None:
        return Truth(put, str(model.input_points[put.input]))
    at = places_of(model, rig)
    moved = 0.0 if put.other is None else float(np.linalg.norm(at[put.other] - at[put.output]))
    return Truth(put, model.outputs[put.output], moved)


def _truth_document(truth: Truth) -> dict[str, Any]:
    return asdict(truth)


def _open_seal(folder: Path, name: str) -> Truth:
    content = open_truth(folder, name)
    put = content["put"]
    return Truth(None if put is None else AppliedEffect(**put), content["place"], content["moved_m"])


_STORED: TypeAdapter[ModalDiagnosis | None] = TypeAdapter(ModalDiagnosis | None)


def _keep_diagnosis(folder: Path, name: str, found: ModalDiagnosis | None) -> None:
    place = folder / ANSWERS / f"{name}.json"
    place.parent.mkdir(exist_ok=True)
    place.write_bytes(_STORED.dump_json(found, indent=1) + b"\n")


def _read_answer(folder: Path, name: str) -> ModalDiagnosis | None:
    return _STORED.validate_json((folder / ANSWERS / f"{name}.json").read_bytes())


def with_noise(frf: Frf, variance: Real, rng: np.random.Generator) -> Frf:
    """The same with noise drawn anew."""
    drawn = rng.standard_normal((2, *frf.values.shape))
    return replace(frf, values=frf.values + np.sqrt(variance / 2) * (drawn[0] + 1j * drawn[1]))
