"""FRFs of a stepped sine test: one line per drive frequency."""

from collections.abc import Sequence

import numpy as np

from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.estimate import combine, output_quantity
from modallab.signals.block_sets import check_outputs, check_test
from modallab.signals.signals import Signals
from modallab.signals.tone_fit import fit_at

CLOCKS = 0.1
"""Share by which a measured frequency may differ from the one that was set: no clock is as wrong."""


def stepped_frf(signals: Sequence[Signals], rig: Rig) -> Frf:
    """FRF by sine fits at the true drive frequency; levels at one frequency are averaged as H1.

    The decay that may still be in a block is not taken off: this is what the block shows.

    Args:
        signals: sine blocks.
        rig: names, points and quantities.

    Raises:
        DataError: no blocks, blocks that differ or of other outputs than the rig's, more than one drive point, a block
            of another test, or one without a sine in its force near the frequency that was set.
    """
    check_test(signals)
    _check(signals, rig)
    at: dict[float, list[int]] = {}
    for i, item in enumerate(signals):
        at.setdefault(float(item.block.frequency_hz or item.tone.frequency_hz), []).append(i)
    frequencies, values = [], []
    for requested in sorted(at):
        members = at[requested]
        force = np.array([[signals[i].tone.amplitude[0]] for i in members])
        fits = [fit_at(signals[i].responses, signals[i].rate_hz, signals[i].tone.frequency_hz) for i in members]
        response = np.stack([f.amplitude[:, None] for f in fits])
        frequencies.append(float(np.mean([signals[i].tone.frequency_hz for i in members])))
        values.append(combine(force, response)[0][:, 0])
    return Frf(
        frequency_hz=np.array(frequencies),
        values=np.stack(values, axis=1)[:, None, :],
        quantity=output_quantity(rig),
        outputs=signals[0].outputs,
        output_points=tuple(c.point for c in rig.responses),
        input_points=(signals[0].block.drive_point,),
        averages=(max(len(m) for m in at.values()),),
    )


def _check(signals: Sequence[Signals], rig: Rig) -> None:
    check_outputs(signals[0], rig)
    points = {s.block.drive_point for s in signals}
    if len(points) > 1:
        found = f"the sine blocks are driven at points {', '.join(sorted(map(str, points)))}"
        raise DataError(found, remedy="give the blocks of one drive point")
    for s in signals:
        where = f"record {s.block.name}"
        if s.block.test != "sine":
            found = f"a block of the {s.block.test} test holds no steady sine"
            raise DataError(found, where=where, remedy="give the blocks of the sine test")
        set_to = s.block.frequency_hz
        if set_to is not None and abs(s.tone.frequency_hz / set_to - 1) > CLOCKS:
            found = f"the force holds a sine of {s.tone.frequency_hz:.4g} Hz, the generator was set to {set_to:.4g} Hz"
            raise DataError(found, where=where, remedy="check the record's frequency and rate")
