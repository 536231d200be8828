"""FRFs of a stepped sine test: one line per drive frequency."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.estimate import combine_spectra, output_quantity
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.signals import Signals
from modallab.signals.tone_fit import fit_at

CLOCKS = 0.1
"""Share by which a measured frequency may differ from the one that was set: no clock is as wrong."""


@dataclass(frozen=True, eq=False, slots=True)
class SineLine:
    """What one sine block gives to an FRF: the complex amplitudes of its sine.

    Attributes:
        requested_hz: what the generator was set to, else what was found.
        frequency_hz: of the sine in the force.
        force: amplitude in N.
        response: (outputs,) amplitudes in SI units.
        point: where it was driven.
    """

    requested_hz: float
    frequency_hz: float
    force: complex
    response: NDArray[np.complex128]
    point: int | None


def sine_line_of_block(signals: Signals, rig: Rig) -> SineLine:
    """The line of a block, by a sine fit at the force's own frequency.

    The decay that may still be in a block is not taken off: this is what the block shows.

    Raises:
        DataError: a block of another test or of other outputs than the rig's, or one without a sine in its force near
            the frequency that was set.
    """
    check_outputs(signals, rig)
    _check(signals)
    tone = signals.tone
    response = fit_at(signals.responses, signals.rate_hz, tone.frequency_hz).amplitude
    set_to = float(signals.block.frequency_hz or tone.frequency_hz)
    return SineLine(set_to, tone.frequency_hz, complex(tone.amplitude[0]), response, signals.block.drive_point)


def stepped_frf(signals: Sequence[Signals], rig: Rig) -> Frf:
    """FRF by sine fits at the true drive frequency; levels at one frequency are averaged as H1.

    Args:
        signals: sine blocks.
        rig: names, points and quantities.

    Raises:
        DataError: no blocks, blocks that differ or of other outputs than the rig's, more than one drive point, a block
            of another test, or one without a sine in its force near the frequency that was set.
    """
    check_test(signals)
    return frf_of_lines([sine_line_of_block(item, rig) for item in signals], rig)


def frf_of_lines(lines: Sequence[SineLine], rig: Rig) -> Frf:
    """FRF of sine blocks that were looked at one by one; those of one frequency are averaged as H1.

    Raises:
        DataError: no lines, or of more than one drive point.
    """
    points = {line.point for line in lines}
    if len(points) != 1:
        found = f"the sine blocks are driven at points {', '.join(sorted(map(str, points))) or 'none'}"
        raise DataError(found, remedy="give the blocks of one drive point")
    at: dict[float, list[SineLine]] = {}
    for line in sorted(lines, key=lambda one: one.requested_hz):
        at.setdefault(line.requested_hz, []).append(line)
    values = [
        combine_spectra(np.array([[m.force] for m in members]), np.stack([m.response[:, None] for m in members]))[0][
            :, 0
        ]
        for members in at.values()
    ]
    return Frf(
        frequency_hz=np.array([float(np.mean([m.frequency_hz for m in members])) for members in at.values()]),
        values=np.stack(values, axis=1)[:, None, :],
        quantity=output_quantity(rig),
        outputs=tuple(c.name for c in rig.responses),
        output_points=tuple(c.point for c in rig.responses),
        input_points=tuple(points),
        averages=(max(len(members) for members in at.values()),),
    )


def _check(signals: Signals) -> None:
    where = f"record {signals.block.name}"
    if signals.block.test != "sine":
        found = f"a block of the {signals.block.test} test holds no steady sine"
        raise DataError(found, where=where, remedy="give the blocks of the sine test")
    set_to, found_hz = signals.block.frequency_hz, signals.tone.frequency_hz
    if set_to is not None and abs(found_hz / set_to - 1) > CLOCKS:
        found = f"the force holds a sine of {found_hz:.4g} Hz, the generator was set to {set_to:.4g} Hz"
        raise DataError(found, where=where, remedy="check the record's frequency and rate")
