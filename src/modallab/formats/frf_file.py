"""FRFs as files hold them: units, directions and order of lines, and the rig that FRFs without one are of."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.io import savemat

from modallab.core.arrays import Complex128, Real
from modallab.core.block import Campaign
from modallab.core.errors import DataError, StorageError
from modallab.core.frf import DERIVATIVES, UNIT, Frf, FrfQuantity
from modallab.core.rig import Channel, Point, Rig
from modallab.core.units import DERIVATIVE, si_factor
from modallab.formats.atomic import replacing
from modallab.formats.exporter import write_export
from modallab.signals.conversion import sign_of

_QUANTITY: dict[int, FrfQuantity] = {order: quantity for quantity, order in DERIVATIVES.items()}
_ROUNDING = 1e-6
OF_THE_RIG = "no unit is written of the FRFs: taken in those of the rig's channels"
"""A note."""


def assumed_factor(channel: Channel, rig: Rig, where: str) -> tuple[FrfQuantity, float]:
    """Quantity of the FRFs of a channel, and the factor from the units of the rig's channels to SI.

    Raises:
        DataError: the channel measures no motion.
    """
    order = DERIVATIVE.get(channel.quantity)
    if order is None:
        raise DataError(
            f"channel {channel.name} measures {channel.quantity}, of which no modal FRF is made",
            where=where,
            remedy="leave it out of the rig, or mend its quantity",
        )
    force = 1.0 if rig.force is None else si_factor("force", rig.force.unit, where)
    return _QUANTITY[order], si_factor(channel.quantity, channel.unit, where) / force


def turned(channel: Channel, rig: Rig) -> float:
    """1 or -1: what turns the FRF of a channel to the direction of the drive, as its records are turned."""
    return sign_of(rig, channel) * (1.0 if rig.force is None else sign_of(rig, rig.force))


def rising(frequency_hz: Real, values: Complex128, coherence: Real | None) -> tuple[Real, Complex128, Real | None]:
    """Lines (lines,), FRFs and coherences (outputs, inputs, lines) by rising frequency, of a sweep down too."""
    if frequency_hz.size < 2 or not np.all(np.diff(frequency_hz) < 0):
        return frequency_hz, values, coherence
    turned = None if coherence is None else coherence[..., ::-1]
    return frequency_hz[::-1], values[..., ::-1], turned


def share_of_one(coherence: Real, where: str, unit: str = "") -> Real:
    """Coherences, those in % as shares.

    Raises:
        DataError: they are not between 0 and 1.
    """
    share = coherence / 100 if unit == "%" else coherence
    if not ((share >= 0) & (share <= 1 + _ROUNDING)).all():
        raise DataError(
            f"a coherence is not between 0 and 1: they reach {float(np.max(share)):.4g}",
            where=where,
            remedy="write [%] behind the names of columns in percent, or export the coherences again",
        )
    return np.minimum(share, 1.0)


OUTPUT_UNIT: dict[FrfQuantity, tuple[str, str]] = {
    "receptance": ("displacement", "m"),
    "mobility": ("velocity", "m/s"),
    "inertance": ("acceleration", "m/s^2"),
}
FORMATS = {".uff": "uff", ".h5": "hdf5", ".mat": "mat"}


def write_frf(path: Path, frf: Frf, rig: Rig) -> None:
    """Write FRFs: a universal file (.uff), MATLAB's (.mat, with the deviation of each line) or a campaign file (.h5).

    Raises:
        StorageError: the name ends otherwise, or the file cannot be written.
    """
    if path.suffix not in FORMATS:
        raise StorageError(f"{path.name} ends with none of {', '.join(FORMATS)}", where=str(path), remedy="name it so")
    if path.suffix != ".mat":
        write_export(Campaign(rig, (), (frf,), source="model"), path, FORMATS[path.suffix])
        return
    sigma = {} if frf.variance is None else {"sigma": np.sqrt(frf.variance)}
    points = {"outputs": list(frf.output_points), "inputs": list(frf.input_points)}
    about = {"quantity": frf.quantity, "unit": UNIT[frf.quantity], **points}
    with replacing(path) as draft:
        savemat(str(draft), {"f": frf.frequency_hz, "H": frf.values, **sigma, **about}, appendmat=False)


def rig_of(frf: Frf) -> Rig:
    """A rig of FRFs between points whose places are not known."""
    to, of = ([p for p in points if p is not None] for points in (frf.output_points, frf.input_points))
    return rig_without_places(frf.outputs, to, of, frf.quantity)


def rig_without_places(names: Sequence[str], to: Sequence[int], of: Sequence[int], quantity: FrfQuantity) -> Rig:
    """A rig of outputs and points whose places are not known: the numbers of the points stand for them in figures."""
    measured, unit = OUTPUT_UNIT[quantity]
    force = Channel.model_validate({"index": 0, "name": "force", "quantity": "force", "unit": "N"})
    responses = [
        Channel.model_validate({"index": i, "name": name, "quantity": measured, "unit": unit, "point": point})
        for i, (name, point) in enumerate(zip(names, to, strict=True), 1)
    ]
    points = tuple(Point(id=p, x_m=float(p)) for p in sorted({*to, *of}))
    return Rig(name="FRFs from arrays", model="unknown", points=points, channels=(force, *responses))
