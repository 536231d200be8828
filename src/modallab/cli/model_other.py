"""`modallab model`: a measured model beside another one of its structure, which it corrects."""

import argparse
from pathlib import Path

from modallab.cli.console import show_rows, write_json
from modallab.core.errors import ConfigurationError, StorageError
from modallab.core.rig import Rig
from modallab.formats.atomic import replacing
from modallab.modification.known import KnownStructure
from modallab.pipelines.model_update import update_model
from modallab.pipelines.structure_gap import read_reference
from modallab.reporting.understood_table import correlation_rows
from modallab.reporting.updated_table import parameter_rows, updated_document, updated_mode_rows
from modallab.updating.correlation import ModelCorrelation, correlate_models
from modallab.updating.prior import Prior


def compare(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """Pairs of modes with another model."""
    other = KnownStructure(read_reference(arguments.other, known.stated_rig, known.model).model, known.rig)
    found = correlate_models(known, other)
    if arguments.out is not None:
        _draw_pairs(found, known.stated_rig, arguments.out)
    show_rows(arguments, correlation_rows(found))
    about = {"pairs": [[i + 1, j + 1] for i, j in found.pairs], "freedoms": found.freedoms}
    arrays = {name: getattr(found, name).tolist() for name in ("mac", "frequency_hz", "damping_ratio", "comac")}
    if arguments.json is not None:
        write_json(arguments.json, about | arrays)


def _draw_pairs(found: ModelCorrelation, rig: Rig, path: Path) -> None:
    from modallab.reporting.figures.mode_shapes import paired_shapes

    if path.suffix not in (".svg", ".png"):
        raise StorageError(f"{path.name} ends with neither .svg nor .png", where=str(path), remedy="name it pairs.svg")
    with replacing(path) as draft, draft.open("wb") as file:
        paired_shapes(found, rig).savefig(file, format=path.suffix[1:])


def update(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """Parameters of a model of the structure."""
    priors = dict(_prior(*given) for given in arguments.prior or ())
    found = update_model(known, arguments.fe, priors, arguments.hold_out or ())
    show_rows(arguments, updated_mode_rows(found))
    show_rows(arguments, parameter_rows(found))
    if arguments.json is not None:
        write_json(arguments.json, updated_document(found).model_dump(mode="json"))


def _prior(name: str, value: str, sigma: str) -> tuple[str, Prior]:
    relative = sigma.endswith("%")
    try:
        spread = float(sigma.removesuffix("%")) / (100 if relative else 1)
        return name, Prior(float(value), spread, relative)
    except ValueError as error:
        raise ConfigurationError(
            f"--prior {name} {value} {sigma} is no number with its deviation",
            remedy="write --prior spring@8 0 1000, or --prior density 7850 2%",
        ) from error
