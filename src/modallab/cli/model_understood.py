"""`modallab model`: which modes make a response, where they move, what the motion looks like."""

import argparse
from typing import Any

import numpy as np

from modallab.cli.console import console_of, show_rows, write_json
from modallab.core.errors import ConfigurationError, DataError, StorageError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.modification.deflection import Deflection, mode_deflection, motion_in_space, operating_deflection
from modallab.modification.freedoms import freedoms_of
from modallab.modification.known import KnownStructure
from modallab.modification.nodes import places_of_modes
from modallab.modification.participation import modal_participation
from modallab.reporting.understood_table import (
    advice_of,
    deflection_rows,
    node_rows,
    participation_rows,
)


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


def show_shape(known: KnownStructure, measured: Frf | None, arguments: argparse.Namespace) -> None:
    """The shape of a mode, or an operating deflection shape."""
    found = _show_deflection(known, measured, arguments)
    if arguments.out is not None:
        _draw(found, known.stated_rig, arguments)
    show_rows(arguments, deflection_rows(found))
    sigma = [None if np.isnan(s) else float(s) for s in found.sigma]
    values = {"re": found.values.real.tolist(), "im": found.values.imag.tolist(), "sigma": sigma}
    about = {"frequency_hz": found.frequency_hz, "unit": found.unit, "freedoms": found.freedoms}
    _write(arguments, about | values)


def _show_deflection(known: KnownStructure, measured: Frf | None, arguments: argparse.Namespace) -> Deflection:
    if arguments.mode is not None:
        return mode_deflection(known.structure, known.samples, arguments.mode)
    if arguments.at is None:
        raise ConfigurationError("the point of the force is missing", remedy="add --at POINT")
    if measured is None:
        raise DataError("a file of models holds no measured FRF", remedy="name the campaign instead of its models")
    return operating_deflection(measured, freedoms_of(known.model, known.stated_rig)[0], arguments.hz, arguments.at)


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
