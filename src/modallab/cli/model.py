"""`modallab model`: a modal model put to use."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np

from modallab.cli.console import console_of, show_rows, write_json
from modallab.cli.model_other import compare, update
from modallab.cli.model_understood import nodes, parts, shape
from modallab.core.errors import ConfigurationError, DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Rig
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.frf_file import rig_of, write_frf
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.options import Options
from modallab.modification.attachments import Addition, Element, RigidLink, TunedAbsorber
from modallab.modification.inverse import tuned
from modallab.modification.known import Known
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models
from modallab.pipelines.model_use import known_of
from modallab.pipelines.structure_gap import read_reference
from modallab.reporting.modified_table import checked, modified_rows, tuned_rows
from modallab.reporting.waiting import waiting

LOWEST = 1e-3
"""Of the upper edge of a band that begins at 0 Hz: the first line of FRFs."""


def run(arguments: argparse.Namespace) -> int:
    """Make the model ready, and do what was asked for."""
    known, measured = _ready(arguments)
    if arguments.action == "shape":
        shape(known, measured, arguments)
    else:
        ACTIONS[arguments.action](known, arguments)
    return 0


def _ready(arguments: argparse.Namespace) -> tuple[Known, Frf | None]:
    """The model ready for use, and the FRFs it was compared with where there are any."""
    path: Path = arguments.model
    rig = None if arguments.rig is None else read_rig(arguments.rig)
    if path.suffix == ".json":
        return Known(_chosen(read_models(path), arguments.test), rig or _beside(path)), None
    campaign = read_campaign(path, rig)
    # The others take as long, and nobody asked for them.
    only = arguments.test if arguments.test and campaign.of(arguments.test) else None
    with waiting("identifying", progress=not arguments.hush):
        result = identify_campaign(campaign, Options(), only)
    model = _chosen([item.model for item in result.identified], arguments.test)
    verification = next(item.verification for item in result.identified if item.model is model)
    return known_of(campaign, model), None if verification is None else verification.measured


def _beside(path: Path) -> Rig | None:
    near = path.with_name("rig.yaml")
    return read_rig(near) if near.exists() else None


def _chosen(models: tuple[ModalModel, ...] | list[ModalModel], test: str | None) -> ModalModel:
    fitting = [m for m in models if test in (None, m.test)]
    if not fitting:
        there = ", ".join(str(m.test) for m in models) or "none"
        raise DataError(f"there is no model of {'a' if test is None else test} test", remedy=f"there are: {there}")
    return fitting[0]


def _modify(known: Known, arguments: argparse.Namespace) -> None:
    changes = list(_changes(arguments))
    if not changes:
        raise ConfigurationError(
            "there is no change", remedy="give --mass 0.05 --at 8, or --absorber, --ground, --link"
        )
    changed = known.with_changes(changes)
    show_rows(arguments, modified_rows(known.model, changed.modes, [c.words for c in changes]))
    if arguments.check is not None:
        for one in checked(changed.modes, read_reference(arguments.check, known.stated_rig, known.model).model):
            console_of(arguments).print(one.words, markup=False, highlight=False, soft_wrap=True)
    if arguments.json is not None:
        m = changed.modes
        arrays = ("frequency_hz", "frequency_sigma_hz", "damping_ratio", "damping_sigma", "outside", "mac")
        document = {name: np.asarray(getattr(m, name)).tolist() for name in arrays}
        write_json(arguments.json, {"changes": [c.words for c in changes], "like": (m.like + 1).tolist(), **document})


def _changes(arguments: argparse.Namespace) -> Iterator[Addition]:
    a = arguments
    if a.mass or a.spring or a.damper:
        if a.at is None:
            raise ConfigurationError("the point of the change is missing", remedy="add --at POINT")
        yield Element(a.at, a.to, a.mass, a.spring, a.damper)
    if a.absorber:
        point, mass, hz, percent = a.absorber
        yield TunedAbsorber(int(point), mass, hz, percent / 100)
    yield from (RigidLink(point) for point in a.ground or ())
    if a.link:
        yield RigidLink(*a.link)


def _tune(known: Known, arguments: argparse.Namespace) -> None:
    at = arguments.at or known.sensors
    answers = tuned(known, arguments.mode, arguments.to, arguments.by, at)
    show_rows(arguments, tuned_rows(answers, arguments.by, arguments.mode, arguments.to))
    if arguments.json is not None:
        rows = [{k: None if v != v else v for k, v in asdict(a).items()} for a in answers]
        write_json(arguments.json, {"answers": rows})


def _frf(known: Known, arguments: argparse.Namespace) -> None:
    low, high = known.model.band_hz
    f = np.linspace(max(low, LOWEST * high), high, arguments.lines)
    found = known.frf(f, arguments.outputs, arguments.inputs, arguments.quantity)
    write_frf(arguments.out, found, rig_of(found))
    outputs, inputs, lines = found.values.shape
    summary = f"{found.quantity}: {outputs} outputs, {inputs} inputs, {lines} lines: {arguments.out}"
    console_of(arguments).print(summary, markup=False, highlight=False, soft_wrap=True)


ACTIONS = {
    "modify": _modify,
    "tune": _tune,
    "frf": _frf,
    "participation": parts,
    "nodes": nodes,
    "compare": compare,
    "update": update,
}
