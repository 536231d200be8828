"""FRFs of a stepped sine test: one line per drive frequency."""

from collections.abc import Sequence

import numpy as np

from modallab.errors import DataError
from modallab.schema.block import Signals
from modallab.schema.frf import Frf
from modallab.schema.rig import Rig
from modallab.spectra.border import check_test
from modallab.spectra.frf import combine, output_quantity
from modallab.spectra.sine_fit import SineFit, fit_at


def stepped_frf(signals: Sequence[Signals], force_fits: Sequence[SineFit], rig: Rig) -> Frf:
    """FRF by sine fits at the true drive frequency; levels at one frequency are averaged as H1.

    The decay that may still be in a block is not taken off: this is what the block shows.

    Args:
        signals: sine blocks.
        force_fits: the fit of each block's force.
        rig: names, points and quantities.

    Raises:
        DataError: no blocks, blocks that differ, or not one fit per block.
    """
    check_test(signals)
    if len(force_fits) != len(signals):
        raise DataError(
            f"{len(force_fits)} fits for {len(signals)} blocks", remedy="give the force's fit of each block"
        )
    at: dict[float, list[int]] = {}
    for i, item in enumerate(signals):
        at.setdefault(float(item.block.frequency_hz or force_fits[i].frequency_hz), []).append(i)
    frequencies, values = [], []
    for wanted in sorted(at):
        members = at[wanted]
        force = np.array([[force_fits[i].amplitude[0]] for i in members])
        fits = [fit_at(signals[i].responses, signals[i].rate_hz, force_fits[i].frequency_hz) for i in members]
        response = np.stack([f.amplitude[:, None] for f in fits])
        frequencies.append(float(np.mean([force_fits[i].frequency_hz for i in members])))
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
