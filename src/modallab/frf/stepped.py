"""FRFs of a stepped sine test: one line per drive frequency."""

from collections.abc import Sequence

import numpy as np

from modallab.core.block import Signals
from modallab.core.errors import DataError
from modallab.core.frf import Frf
from modallab.core.rig import Rig
from modallab.frf.estimate import combine, output_quantity
from modallab.signals.checks import check_outputs, check_test
from modallab.signals.tone_fit import SineFit, fit_at

CLOCKS = 0.1
"""Share by which a measured frequency may differ from the one that was set: no clock is as wrong."""


def stepped_frf(signals: Sequence[Signals], force_fits: Sequence[SineFit], rig: Rig) -> Frf:
    """FRF by sine fits at the true drive frequency; levels at one frequency are averaged as H1.

    The decay that may still be in a block is not taken off: this is what the block shows.

    Args:
        signals: sine blocks.
        force_fits: the fit of each block's force.
        rig: names, points and quantities.

    Raises:
        DataError: no blocks, blocks that differ or of other outputs than the rig's, more than one drive point, or not
            one fit per block, of the sine that drove it.
    """
    check_test(signals)
    _check(signals, force_fits, rig)
    at: dict[float, list[int]] = {}
    for i, item in enumerate(signals):
        at.setdefault(float(item.block.frequency_hz or force_fits[i].frequency_hz), []).append(i)
    frequencies, values = [], []
    for nominal_hz in sorted(at):
        members = at[nominal_hz]
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


def _check(signals: Sequence[Signals], force_fits: Sequence[SineFit], rig: Rig) -> None:
    check_outputs(signals[0], rig)
    points = {s.block.drive_point for s in signals}
    if len(points) > 1:
        found = f"the sine blocks are driven at points {', '.join(sorted(map(str, points)))}"
        raise DataError(found, remedy="give the blocks of one drive point")
    if len(force_fits) != len(signals):
        raise DataError(
            f"{len(force_fits)} fits for {len(signals)} blocks", remedy="give the force's fit of each block"
        )
    for s, fit in zip(signals, force_fits, strict=True):
        if s.block.test != "sine":
            found = f"a block of the {s.block.test} test holds no steady sine"
            raise DataError(found, where=f"record {s.block.name}", remedy="give the blocks of the sine test")
        set_to = s.block.frequency_hz
        if fit.amplitude.shape != (1,) or (set_to is not None and abs(fit.frequency_hz / set_to - 1) > CLOCKS):
            raise DataError(
                f"a fit of {fit.amplitude.size} channels at {fit.frequency_hz:.4g} Hz for a sine of {set_to} Hz",
                where=f"record {s.block.name}",
                remedy="give the fit of this block's force alone",
            )
