"""What the answers of many twins follow from, at once: their poles, residues and what the modes left out add.

As `modallab.gap.model.forward` has it of one twin; the slopes of a fit ask for all its numbers at every step.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from modallab.core.arrays import Complex, Real
from modallab.gap.conditioning.rows import ImpactData, Reduced, SineData
from modallab.gap.model.forward import drift_scale, driven_at
from modallab.twin.bench import Twin
from modallab.twin.elements import shape_rows
from modallab.twin.modes import TwinModes
from modallab.twin.predict import sensor_positions

Numbers = tuple[Complex, Complex, Real]
"""(twins, p) poles, (twins, channels, p) residues and (twins, channels) static remainder."""


@dataclass(frozen=True, eq=False, slots=True)
class ManyModes:
    """The modes of many twins, and where their accelerometers sit.

    Attributes:
        poles: (twins, p); NaN for a twin with other modes.
        columns: (twins, n, p) as in `TwinModes`; NaN too.
        out_of_band: of each twin, as in `TwinModes`.
        sensors: (twins, channels, n) rows that take a shape at the accelerometers.
        outputs: (twins, channels, p) shapes there, which all drive points share.
        length_m: of the beam.
    """

    poles: Complex
    columns: Complex
    out_of_band: tuple[Real, ...]
    sensors: Real
    outputs: Complex
    length_m: float

    @classmethod
    def of(cls, modes: Sequence[TwinModes], sensors: Real, count: int) -> Self:
        """Of twins whose accelerometers sit there, with so many modes as a rule."""
        poles = np.full((len(modes), count), np.nan, dtype=np.complex128)
        columns: Complex = np.full((len(modes), sensors.shape[2], count), np.nan, dtype=np.complex128)
        for k, own in enumerate(modes):
            if len(own.poles) == count:
                poles[k], columns[k] = own.poles, own.columns
        out_of_band = tuple(m.out_of_band for m in modes)
        return cls(poles, columns, out_of_band, sensors, sensors @ columns, modes[0].length_m)

    def at(self, x_m: Sequence[float]) -> tuple[Complex, Real]:
        """(twins, p) shapes at one place on each twin, and (twins, channels) static m per N that others add there."""
        rows = np.array([shape_rows(x, self.length_m)[0] for x in x_m])
        pushed = np.array([given @ row for given, row in zip(self.out_of_band, rows, strict=True)])
        return (rows[:, None] @ self.columns)[:, 0], (self.sensors @ pushed[:, :, None])[:, :, 0]


def sensor_rows(twins: Sequence[Twin], modes: TwinModes, data: Reduced) -> Real:
    """(twins, channels, n) rows that take a shape at the accelerometers of each twin."""
    first, *others = twins
    usual = shape_rows(sensor_positions(first.chain, modes, data.channels, data.x_m), modes.length_m)
    rows = [usual]
    for twin in others:
        moved = twin.chain.shift != first.chain.shift
        x = sensor_positions(twin.chain, modes, data.channels, data.x_m) if moved else None
        rows.append(usual if x is None else shape_rows(x, modes.length_m))
    return np.array(rows)


def hit_numbers(twins: Sequence[Twin], modes: ManyModes, d: ImpactData, data: Reduced) -> Numbers:
    """The numbers of hits at one point, on twins that drift alike."""
    scale = float(drift_scale(twins[0], d.piece.order, data))
    x, gains = zip(*(driven_at(t, d.piece) for t in twins), strict=True)
    drive, static = modes.at(x)
    gain = np.array(gains)[:, None]
    residue = modes.outputs * (drive * gain / scale)[:, None]
    return modes.poles * scale, residue, static * gain * _shares(twins) / scale**2


def sine_numbers(twins: Sequence[Twin], modes: ManyModes, d: SineData) -> Numbers:
    """The numbers of the sine test, without drift."""
    drive, static = modes.at([d.pieces[0].drive_x_m] * len(twins))
    return modes.poles, modes.outputs * drive[:, None], static * _shares(twins)


def _shares(twins: Sequence[Twin]) -> Real:
    return np.array([[t.residual_compliance] for t in twins])
