"""The twin as a modal model in a universal file: shapes (dataset 55) and FRFs (dataset 58), of the structure alone."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from modallab.core.block import Campaign
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.model import ModalModel
from modallab.core.rig import Channel, Rig
from modallab.core.units import DERIVATIVE, Test
from modallab.formats.modes import ModeShapes
from modallab.formats.uff.uff_shapes import read_uff_shapes
from modallab.formats.uff.uff_write import write_uff
from modallab.gap.export.mjcf_laws import require_linear_twin
from modallab.gap.export.state_space import StateSpace, modal_state_space
from modallab.twin.bench import Twin
from modallab.twin.modes import solve_modes
from modallab.twin.structure import TwinStructure

TOP_HZ = 800.0
STEP_HZ = 0.5


def write_modal(path: Path, twin: Twin, rig: Rig, tests: Sequence[Test]) -> None:
    """Write modes and FRFs at the points that have a response channel; sensors and chain are no part of them.

    Raises:
        DataError: no response channel stands at a point, or the twin is not linear.
        StorageError: the file cannot be written.
    """
    require_linear_twin(twin, "a modal model")
    channels = _exported_channels(rig)
    structures: dict[Test, TwinStructure] = {test: _structure_of_twin(twin, rig, test) for test in tests}
    models = [_exported_model(structure, rig, channels, test) for test, structure in structures.items()]
    frfs = (_exported_frf(next(iter(structures.values())), rig, channels),)
    write_uff(Campaign(rig, (), frfs), path, models)


def read_modal(path: Path, rig: Rig) -> dict[Test, StateSpace]:
    """The modes of such a file as a state space: force at each point of the rig that has a shape.

    Raises:
        FormatError, DataError: as `read_uff_shapes`.
    """
    found: dict[Test, StateSpace] = {}
    for shapes in read_uff_shapes(path, rig):
        tests: list[Test] = [test for test in ("impact", "sine") if f", {test}, " in f"{shapes.title}, "]
        found |= dict.fromkeys(tests, _exported_system(shapes, rig))
    return found


def _structure_of_twin(twin: Twin, rig: Rig, test: Test) -> TwinStructure:
    return twin.in_sine(rig.x_of(rig.shaker_point)) if test == "sine" and rig.shaker_point else twin.structure


def _exported_channels(rig: Rig) -> list[Channel]:
    first = {c.point: c for c in reversed(rig.responses) if c.point is not None}
    if not first:
        raise DataError("no response channel stands at a point", where=rig.name, remedy="give channels their points")
    return sorted(first.values(), key=lambda c: c.index)


def _exported_model(structure: TwinStructure, rig: Rig, channels: Sequence[Channel], test: Test) -> ModalModel:
    modes = solve_modes(structure)
    points = tuple(c.point for c in channels)
    x = np.array([rig.x_of(c.point or 0) for c in channels])
    # At unit modal mass.
    scaled = (modes.shapes_at(x) * np.sqrt(2j * np.abs(modes.poles.imag))).T
    shapes = np.asarray(scaled if structure.dampers else scaled.real, dtype=np.complex128)
    unknown = np.full(len(modes.poles), np.nan)
    driving = shapes[:, :, None] * shapes[:, None, :]
    return ModalModel(
        method="twin",
        test=test,
        band_hz=(0.0, float(modes.frequency_hz[-1])),
        frequency_hz=modes.frequency_hz,
        damping_ratio=-modes.poles.real / np.abs(modes.poles),
        frequency_sigma_hz=unknown,
        damping_sigma=unknown,
        outputs=tuple(c.name for c in channels),
        output_points=points,
        input_points=points,
        modal_constants=driving,
        modal_constant_sigma=np.full(driving.shape, np.nan),
        residuals=np.zeros((0, len(points), len(points))),
        shapes=shapes,
        half_power=unknown,
        half_power_floor=unknown,
    )


def _exported_frf(structure: TwinStructure, rig: Rig, channels: Sequence[Channel]) -> Frf:
    modes = solve_modes(structure)
    x = np.array([rig.x_of(c.point or 0) for c in channels])
    out = modes.shapes_at(x)
    hz = np.arange(1, round(TOP_HZ / STEP_HZ) + 1) * STEP_HZ
    s = 2j * np.pi * hz
    both = ((out, modes.poles), (out.conj(), modes.poles.conj()))
    values = sum(np.einsum("ap,bp,pk->abk", psi, psi, s**2 / (s - poles[:, None])) for psi, poles in both)
    points = tuple(c.point for c in channels)
    return Frf(
        np.asarray(hz, dtype=np.float64),
        np.asarray(values),
        "inertance",
        tuple(c.name for c in channels),
        points,
        points,
    )


def _exported_system(shapes: ModeShapes, rig: Rig) -> StateSpace:
    by_name = {c.name: c for c in rig.channels}
    omega, zeta = 2 * np.pi * shapes.frequency_hz, shapes.damping_ratio
    poles = -zeta * omega + 1j * omega * np.sqrt(1 - zeta**2)
    mass = np.where(np.isfinite(shapes.modal_mass_kg), shapes.modal_mass_kg, 1.0)
    columns = shapes.shapes.T / np.sqrt(2j * poles.imag * mass)
    at_point = dict(zip(shapes.output_points, columns, strict=True))
    missing = np.full(len(poles), np.nan, dtype=np.complex128)
    into = np.array([at_point.get(p.id, missing) for p in rig.points])
    order = np.array([DERIVATIVE[by_name[name].quantity] for name in shapes.outputs])
    # What no shape is known of cannot be driven: it gives no number, which is seen where it is played.
    return modal_state_space(poles, columns, into, order)
