"""Models as JSON, for other programs."""

import json
from pathlib import Path

from modallab import __version__
from modallab.exchange.atomic import replacing
from modallab.schema.block import Campaign
from modallab.schema.versions import MODEL
from modallab.tasks.identify import Identified, Result


def write_models(path: Path, campaign: Campaign, result: Result) -> None:
    """One JSON document: every test's model, its FRAC, and where it comes from. Whole, or not at all.

    Raises:
        StorageError: the file cannot be written.
    """
    document = model_document(campaign, result)
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def model_document(campaign: Campaign, result: Result) -> dict[str, object]:
    """The content of that file as JSON values."""
    return {
        "format_version": MODEL,
        "code_version": __version__,
        "source": campaign.source,
        "rig": campaign.rig.name,
        "provenance": campaign.provenance,
        "models": [_model(item) for item in result.identified],
        "without_model": [{"test": item.source, "error": str(item.error)} for item in result.unidentified],
    }


def _model(item: Identified) -> dict[str, object]:
    content = item.model.model_dump(mode="json")
    content["frac"] = None if item.verification is None else item.verification.frac.tolist()
    return content
