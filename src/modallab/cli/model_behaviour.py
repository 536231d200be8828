"""`modallab model`: what a model predicts, which modes make a response, what the motion looks like."""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from modallab.cli.console import console_of, show_rows, write_json
from modallab.core.documents.model_use import ForceKind, ImpulseForce, RandomForce, SineForce, SweepForce
from modallab.core.errors import ConfigurationError, DataError, StorageError
from modallab.core.model import ModalModel, Verification
from modallab.core.rig import Rig
from modallab.core.units import Quantity, Test
from modallab.formats.campaign.campaign_hdf5 import read_campaign
from modallab.formats.frf_file import rig_of, write_frf
from modallab.formats.prediction import read_columns, write_motion
from modallab.formats.rig.rig_file import read_rig
from modallab.identification.options import IdentificationOptions
from modallab.modification.deflection import Deflection, mode_deflection, motion_in_space, operating_deflection
from modallab.modification.freedoms import freedoms_of, with_points
from modallab.modification.frfs import lines_with_peaks
from modallab.modification.known import KnownStructure
from modallab.modification.motion import MotionOverTime, force_samples
from modallab.modification.nodes import places_of_modes
from modallab.modification.participation import modal_participation
from modallab.modification.structure import At
from modallab.pipelines.identify import identify_campaign
from modallab.pipelines.model_file import read_models
from modallab.reporting.behaviour_table import (
    advice_of,
    deflection_rows,
    motion_document,
    motion_rows,
    node_rows,
    participation_rows,
    reduction_rows,
)
from modallab.reporting.waiting_line import waiting_line
from modallab.verification.comparison import reduction_of


def frf(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """FRFs as a file."""
    f = lines_with_peaks(known.model.band_hz, arguments.lines, known.poles)
    whole = known.without_residual_terms if arguments.modes_alone else known
    found = whole.frf(f, arguments.outputs, arguments.inputs, arguments.quantity)
    write_frf(arguments.out, found, rig_of(found))
    outputs, inputs, lines = found.values.shape
    summary = f"{found.quantity}: {outputs} outputs, {inputs} inputs, {lines} lines: {arguments.out}"
    console_of(arguments).print(summary, markup=False, highlight=False, soft_wrap=True)


def response(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """The motion that a force gives."""
    a = arguments
    found = MotionOverTime.of(known, _force_samples(a), a.step, a.at, a.of, a.quantity, a.between, _start_state(a))
    show_rows(a, motion_rows(found))
    if a.out is not None:
        write_motion(a.out, found.time, found.values, found.sigma, found.names, found.quantity)
        console_of(a).print(f"motion over time: {a.out}", markup=False, highlight=False, soft_wrap=True)
    if a.json is not None:
        write_json(a.json, motion_document(found))


def _force_samples(a: argparse.Namespace) -> NDArray[np.float64]:
    """(forces, samples) N."""
    if a.force is not None:
        return read_columns(a.force)
    if a.seconds is None:
        raise ConfigurationError("the duration of the force is missing", remedy="add --seconds 10")
    return force_samples(_force_kind(a), a.step, max(2, round(a.seconds / a.step)))[None]


def _force_kind(a: argparse.Namespace) -> ForceKind:
    try:
        if a.impulse is not None:
            return ImpulseForce(impulse_n_s=a.impulse)
        if a.sine is not None:
            return SineForce(frequency_hz=a.sine[0], amplitude_n=a.sine[1])
        if a.sweep is not None:
            return SweepForce(from_hz=a.sweep[0], to_hz=a.sweep[1], amplitude_n=a.sweep[2])
        return RandomForce.model_validate({"spectrum": read_columns(a.random).T.tolist(), "seed": a.seed})
    except ValidationError as error:
        first = error.errors()[0]
        raise DataError(f"this force is impossible: {first['msg']}", remedy="give finite numbers") from error


def _start_state(a: argparse.Namespace) -> dict[Quantity, dict[At, float]] | None:
    given: dict[Quantity, list[list[float]] | None] = {"displacement": a.displaced, "velocity": a.moving}
    found: dict[Quantity, dict[At, float]] = {
        name: {int(point): value for point, value in pairs} for name, pairs in given.items() if pairs
    }
    return found or None


def state_space(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """A, B, C and D as a file."""
    of = arguments.of or known.sensors
    found = known.state_space(arguments.at, of, arguments.quantity)
    found.save(arguments.out)
    summary = f"{len(found.A)} states, {len(found.inputs)} forces, {len(found.outputs)} motions: {arguments.out}"
    console_of(arguments).print(summary, markup=False, highlight=False, soft_wrap=True)
    if arguments.json is not None:
        write_json(arguments.json, found.model_dump(mode="json"))


def show_participation(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """Each mode's share of a response."""
    a = arguments
    band, after = (None if given is None else (given[0], given[1]) for given in (a.band, a.after))
    found = modal_participation(known, a.at, a.of, a.quantity, band, after)
    show_rows(a, participation_rows(found, known.model.frequency_hz.tolist()))
    names = ("share", "share_sigma", "alone")
    _write(a, {name: getattr(found, name).tolist() for name in names} | {"outside": found.outside})


def show_nodes(known: KnownStructure, arguments: argparse.Namespace) -> None:
    """Antinodes and nodes of each mode."""
    found = places_of_modes(known.structure, known.samples, known.model, known.rig)
    show_rows(arguments, node_rows(found))
    crossings = [{"mode": c.mode + 1, "place_m": c.place_m.tolist(), "sigma_m": c.sigma_m} for c in found.crossings]
    about = {"freedoms": found.freedoms, "antinode": found.antinode, "nodes": found.nodes, "crossings": crossings}
    motion = {"motion": found.motion.tolist(), "motion_sigma": found.motion_sigma.tolist()}
    _write(arguments, about | motion | {"advice": advice_of(found)})


def show_reduction(known: KnownStructure, compared: Verification | None, arguments: argparse.Namespace) -> None:
    """The size of the FRFs and of the model, and the error of each pair."""
    c = _with_frfs(compared)
    found = reduction_of(known.model, c.measured.values, c.regenerated.values, c.frac)
    show_rows(arguments, reduction_rows(found))
    sizes = {"measured_numbers": found.measured_numbers, "model_numbers": found.model_numbers}
    _write(arguments, sizes | {"error": found.error.tolist(), "frac": found.frac.tolist()})


def show_shape(known: KnownStructure, compared: Verification | None, arguments: argparse.Namespace) -> None:
    """The shape of a mode, or an operating deflection shape."""
    found = _show_deflection(known, compared, arguments)
    if arguments.out is not None:
        _draw(found, known.stated_rig, arguments)
    show_rows(arguments, deflection_rows(found))
    sigma = [None if np.isnan(s) else float(s) for s in found.sigma]
    values = {"re": found.values.real.tolist(), "im": found.values.imag.tolist(), "sigma": sigma}
    about = {"frequency_hz": found.frequency_hz, "unit": found.unit, "freedoms": found.freedoms}
    _write(arguments, about | values)


def _show_deflection(known: KnownStructure, compared: Verification | None, arguments: argparse.Namespace) -> Deflection:
    if arguments.mode is not None:
        return mode_deflection(known.structure, known.samples, arguments.mode)
    if arguments.at is None:
        raise ConfigurationError("the point of the force is missing", remedy="add --at POINT")
    freedoms = freedoms_of(known.model, known.stated_rig)[0]
    return operating_deflection(_with_frfs(compared).measured, freedoms, arguments.hz, arguments.at)


def _with_frfs(compared: Verification | None) -> Verification:
    if compared is None:
        raise DataError("a file of models holds no measured FRF", remedy="name the campaign instead of its models")
    return compared


def _draw(found: Deflection, rig: Rig, arguments: argparse.Namespace) -> None:
    from modallab.reporting.figures.deflection import Drawing

    path = arguments.out
    if path.suffix != ".gif":
        raise StorageError(f"{path.name} does not end with .gif", where=str(path), remedy="name it shape.gif")
    Drawing(rig, motion_in_space(rig, found), deflection_rows(found).caption).save(path)
    console_of(arguments).print(f"moving picture: {path}", markup=False, highlight=False, soft_wrap=True)


def _write(arguments: argparse.Namespace, document: dict[str, Any]) -> None:
    if arguments.json is not None:
        write_json(arguments.json, document)


def prepare_model(
    path: Path, rig: Rig | None, test: Test | None, *, progress: bool
) -> tuple[KnownStructure, Verification | None]:
    """A model ready for use, and what it was compared with where there is anything.

    Args:
        path: models, or a campaign to identify.
        rig: instead of that inside or beside it.
        test: whose model; None for the first.
        progress: whether to show that it is identified.

    Raises:
        DataError: there is no model of the test, or nothing to read.
    """
    if path.suffix == ".json":
        return KnownStructure(_choose_model(read_models(path), test), rig or _rig_beside(path)), None
    campaign = read_campaign(path, rig)
    # The others take as long, and nobody asked for them; hits are the first.
    asked = test or "impact"
    only = asked if campaign.of(asked) else None
    with waiting_line("identifying", progress=progress):
        result = identify_campaign(campaign, IdentificationOptions(), only)
    model = _choose_model([item.model for item in result.identified], test)
    verification = next(item.verification for item in result.identified if item.model is model)
    return KnownStructure(with_points(model, campaign.rig), campaign.rig), verification


def _rig_beside(path: Path) -> Rig | None:
    near = path.with_name("rig.yaml")
    return read_rig(near) if near.exists() else None


def _choose_model(models: tuple[ModalModel, ...] | list[ModalModel], test: str | None) -> ModalModel:
    fitting = [m for m in models if test in (None, m.test)]
    if not fitting:
        there = ", ".join(str(m.test) for m in models) or "none"
        raise DataError(f"there is no model of {'a' if test is None else test} test", remedy=f"there are: {there}")
    return fitting[0]
