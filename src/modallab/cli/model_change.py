"""`modallab model`: a structure changed, coupled, or held beside another model, which it corrects."""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from modallab.cli.console import console_of, show_rows, write_json
from modallab.cli.model_behaviour import prepare_model
from modallab.core.errors import ConfigurationError, StorageError
from modallab.core.rig import Rig
from modallab.formats.atomic import replacing
from modallab.modification.attachments import AttachedPart, Element, RigidLink, TunedAbsorber
from modallab.modification.coupled import CouplingToStructure
from modallab.modification.inverse import (
    ChangeAtPoint,
    FreeBand,
    best_absorber,
    changes_for_free_band,
    changes_for_frequency,
)
from modallab.modification.known import KnownStructure
from modallab.pipelines.model_update import update_model
from modallab.pipelines.structure_gap import read_reference
from modallab.reporting.behaviour_table import correlation_rows
from modallab.reporting.modification_table import (
    absorber_rows,
    check_predictions,
    free_rows,
    modified_rows,
    parameter_rows,
    tuned_rows,
    updated_document,
    updated_mode_rows,
)
from modallab.updating.correlation import ModelCorrelation, correlate_models
from modallab.updating.result import Prior


def modify(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The modes with what is added."""
    changes = list(_changes(arguments))
    if not changes:
        raise ConfigurationError(
            "there is no change", remedy="give --mass 0.05 --at 8, or --absorber, --ground, --link"
        )
    _show_changed(known, changes, arguments)


def couple(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The modes with another structure held to it, or taken away."""
    other, _ = prepare_model(arguments.other, None, None, progress=not arguments.hush)
    sign = -1 if arguments.remove else 1
    pairs = [(a, b) for a, b in arguments.pair]
    held = CouplingToStructure(other.structure, pairs, arguments.joint, sign, samples=other.samples)
    _show_changed(known, [held], arguments)


def _show_changed(known: KnownStructure, changes: Sequence[AttachedPart], arguments: argparse.Namespace) -> None:
    changed = known.with_changes(changes)
    m, words = changed.modes, [c.description for c in changes]
    show_rows(arguments, modified_rows(changed, words))
    if arguments.check is not None:
        for one in check_predictions(m, read_reference(arguments.check, known.stated_rig, known.model).model):
            console_of(arguments).print(one.words, markup=False, highlight=False, soft_wrap=True)
    if arguments.json is not None:
        arrays = ("frequency_hz", "frequency_sigma_hz", "damping_ratio", "damping_sigma", "outside", "mac")
        document = {name: np.asarray(getattr(m, name)).tolist() for name in arrays}
        document |= {"like": (m.like + 1).tolist(), "conditioning": changed.conditioning}
        write_json(arguments.json, {"changes": words, **document})


def _changes(arguments: argparse.Namespace) -> Iterator[AttachedPart]:
    a = arguments
    for name in ("mass", "spring", "damper"):
        yield from _elements(name, getattr(a, name), a.at, a.to)
    for point, mass, hz, percent in a.absorber:
        yield TunedAbsorber(int(point), mass, hz, percent / 100)
    yield from (RigidLink(point) for point in a.ground)
    yield from (RigidLink(*pair) for pair in a.link)


def _elements(name: str, sizes: list[float], at: list[int], to: int | None) -> Iterator[Element]:
    """One size hangs at every point; several at a point each."""
    if sizes and not at:
        raise ConfigurationError("the point of the change is missing", remedy="add --at POINT")
    if len(sizes) > 1 and len(sizes) != len(at):
        raise ConfigurationError(
            f"{len(sizes)} sizes of a {name} for {len(at)} points", remedy="give one size, or one for each point"
        )
    each = sizes * len(at) if len(sizes) == 1 else sizes
    yield from (Element(point, to, **{name: size}) for point, size in zip(at, each, strict=False))


def tune(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The change that brings a mode to a frequency."""
    at = arguments.at or known.sensors
    answers = changes_for_frequency(known, arguments.mode, arguments.to, arguments.by, at)
    show_rows(arguments, tuned_rows(answers, arguments.by, arguments.mode, arguments.to))
    if arguments.json is not None:
        write_json(arguments.json, {"answers": _print_documents(answers)})


def free_band(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The change that leaves no mode in a band."""
    low, high = arguments.band
    answers = changes_for_free_band(known, (low, high), arguments.by, arguments.at or known.sensors)
    show_rows(arguments, free_rows(answers, arguments.by, (low, high)))
    if arguments.json is not None:
        write_json(arguments.json, {"answers": _print_documents(answers)})


def _print_documents(answers: Sequence[ChangeAtPoint] | Sequence[FreeBand]) -> list[dict[str, object]]:
    unsaid = (None, float("inf"))
    return [{k: None if v != v or v in unsaid else v for k, v in asdict(a).items()} for a in answers]


def absorber(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The absorber that leaves the least peak about a mode."""
    found = best_absorber(known, arguments.mode, arguments.at, arguments.mass)
    show_rows(arguments, absorber_rows(found, arguments.mode))
    if arguments.json is not None:
        peaks = {f"peak_{k}": v for k, v in found._asdict().items() if k not in ("absorber", "mass_ratio")}
        write_json(arguments.json, asdict(found.absorber) | {"mass_ratio": found.mass_ratio} | peaks)


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
            f"--prior {name} {value} {sigma} is not a value with its standard deviation",
            remedy="write --prior spring@8 0 1000, or --prior density 7850 2%",
        ) from error
