"""Models as JSON, for other programs."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from itertools import combinations
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from modallab import __version__
from modallab.core.block import Campaign
from modallab.core.errors import DataError, FormatError
from modallab.core.model import ModalModel
from modallab.core.versions import MODEL
from modallab.formats.atomic import replacing
from modallab.pipelines.identify import CampaignResult, IdentifiedTest
from modallab.verification.assessment import ModelAssessment
from modallab.verification.comparison import compare_shapes
from modallab.verification.verify import frac, synthesised_frf


def write_models(path: Path, campaign: Campaign, result: CampaignResult) -> None:
    """One JSON document: every test's model, its FRAC, and where it comes from. Whole, or not at all.

    Raises:
        StorageError: the file cannot be written.
    """
    document = model_document(campaign, result)
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def read_models(path: Path) -> tuple[ModalModel, ...]:
    """The models of such a file.

    Raises:
        FormatError: it cannot be read, or holds no models.
    """
    try:
        content: Any = json.loads(path.read_text(encoding="utf-8"))
        models = cast("list[dict[str, Any]]", content["models"])
        return tuple(
            ModalModel.model_validate({key: value for key, value in model.items() if key != "frac"}) for model in models
        )
    except OSError as error:
        raise FormatError(f"cannot be read: {error.strerror}", where=str(path), remedy="name a models file") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise FormatError(
            f"holds no models: {error}", where=str(path), remedy="write the file with modallab identify --json"
        ) from error


def model_document(campaign: Campaign, result: CampaignResult) -> dict[str, object]:
    """The content of that file as JSON values."""
    return {
        "format_version": MODEL,
        "code_version": __version__,
        "source": campaign.source,
        "rig": campaign.rig.name,
        "provenance": campaign.provenance,
        "models": [_model(item) for item in result.identified],
        # Beside the models, not in them: what reads a model today reads it unchanged.
        "assessments": [None if i.assessment is None else _assessment(i.assessment) for i in result.identified],
        "frac_uncut": [_frac_uncut(item) for item in result.identified],
        "comparisons": _model_comparisons(result),
        "without_model": [{"test": item.source, "error": str(item.error)} for item in result.unidentified],
    }


def _model_comparisons(result: CampaignResult) -> list[dict[str, object]]:
    """Shapes of every two models that share modes and points; places of models and modes count from 0."""
    found: list[dict[str, object]] = []
    for i, j in combinations(range(len(result.identified)), 2):
        try:
            same = compare_shapes(result.identified[i].model, result.identified[j].model)
        except DataError:
            continue
        found.append(
            {
                "models": [i, j],
                "modes": [list(pair) for pair in same.pairs],
                "mac": _numbers_as_lists(same.mac),
                "points": list(same.points),
                "comac": _numbers_as_lists(same.comac),
            }
        )
    return found


def _model(item: IdentifiedTest) -> dict[str, object]:
    content = item.model.model_dump(mode="json")
    content["frac"] = None if item.verification is None else item.verification.frac.tolist()
    return content


def _frac_uncut(item: IdentifiedTest) -> list[list[float]] | None:
    """FRAC of the measured FRFs against the model's own: lower where blocks end before the ring-down does."""
    if item.verification is None:
        return None
    measured = item.verification.measured
    own = synthesised_frf(item.model, measured.frequency_hz, measured.quantity)
    return frac(measured.values, own.values).tolist()


def _assessment(found: ModelAssessment) -> dict[str, object]:
    """Verdicts, what could not be judged and why, and indices by mode; what is not known is null."""
    return {
        "verdicts": [_nan_as_null(asdict(verdict)) for verdict in found.verdicts],
        "unjudged": [{"assumption": name, "why": why} for name, why in found.unjudged],
        "confidence": _numbers_as_lists(found.confidence),
        "mpc": _numbers_as_lists(found.mpc),
        "mpd_rad": _numbers_as_lists(found.mpd_rad),
        "auto_mac": [_numbers_as_lists(row) for row in found.auto_mac],
    }


def _nan_as_null(values: Mapping[str, object]) -> dict[str, object]:
    return {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in values.items()}


def _numbers_as_lists(values: NDArray[np.float64]) -> list[float | None]:
    return [float(v) if np.isfinite(v) else None for v in values]
