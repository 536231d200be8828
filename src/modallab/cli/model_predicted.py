"""`modallab model`: FRFs, the motion that forces give, and the state space."""

import argparse

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from modallab.cli.console import console_of, show_rows, write_json
from modallab.core.documents.forces import ForceKind, ImpulseForce, RandomForce, SineForce, SweepForce
from modallab.core.errors import ConfigurationError, DataError
from modallab.core.units import Quantity
from modallab.formats.frf_file import rig_of, write_frf
from modallab.formats.time_series import read_columns, write_motion
from modallab.modification.forces import force_samples
from modallab.modification.frfs import lines_with_peaks
from modallab.modification.known import KnownStructure
from modallab.modification.motion import MotionOverTime
from modallab.modification.structure import At
from modallab.reporting.understood_table import motion_document, motion_rows


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
        raise ConfigurationError("how long the force lasts is not said", remedy="add --seconds 10")
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
        raise DataError(f"this force cannot be: {first['msg']}", remedy="give finite numbers") from error


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
        write_json(arguments.json, found.document())
